"""The section ``installation`` of results.json."""

import math
from typing import Any

from calib.mounting.mounting import Mounting


def mounting_json(found: Mounting) -> dict[str, Any]:
    """The section ``installation`` of results.json; null for what was not measured."""
    yaw, slope = found.yaw, found.slope
    return {
        "order": found.order,
        "roll_deg": math.degrees(found.roll_rad),
        "pitch_deg": math.degrees(found.pitch_rad),
        "sd_deg": [math.degrees(sd) for sd in found.sd_rad],
        "yaw_deg": math.degrees(yaw.yaw_rad) if yaw else None,
        "yaw_sd_deg": math.degrees(yaw.sd_rad) if yaw else None,
        "floor_rise_deg": [math.degrees(v) for v in slope.rise_rad] if slope else None,
        "floor_rise_sd_deg": [math.degrees(v) for v in slope.sd_rad] if slope else None,
        "rotation": found.rotation.tolist(),
        "before": found.before.tolist(),
        "after": found.after.tolist(),
        "magnitude_error_m_s2": found.magnitude_error_m_s2,
        "readings": found.samples,
        "notes": list(found.notes),
    }
