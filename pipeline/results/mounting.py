"""The section ``installation`` of results.json."""

import math
from typing import Any

from calib.mounting.mounting import Mounting
from pipeline.results.json_values import number


def mounting_json(mounting: Mounting) -> dict[str, Any]:
    """The section ``installation`` of results.json; null for what was not measured."""
    yaw, slope = mounting.yaw, mounting.slope
    return {
        "order": mounting.order,
        "roll_deg": math.degrees(mounting.roll_rad),
        "pitch_deg": math.degrees(mounting.pitch_rad),
        "sd_deg": [math.degrees(sd) for sd in mounting.sd_rad],
        "yaw_deg": math.degrees(yaw.yaw_rad) if yaw else None,
        "yaw_sd_deg": math.degrees(yaw.sd_rad) if yaw else None,
        "floor_rise_deg": [math.degrees(v) for v in slope.rise_rad] if slope else None,
        "floor_rise_sd_deg": [math.degrees(v) for v in slope.sd_rad] if slope else None,
        "rotation": mounting.rotation.tolist(),
        "before": mounting.before.tolist(),
        "after": mounting.after.tolist(),
        "magnitude_error_m_s2": mounting.magnitude_error_m_s2,
        "readings": mounting.samples,
        "orders": [
            {
                "order": trial.order,
                "roll_deg": math.degrees(trial.roll_rad),
                "pitch_deg": math.degrees(trial.pitch_rad),
                "sd_deg": [number(math.degrees(sd)) for sd in trial.sd_rad],
                "margin": trial.margin,
                "residual_m_s2": trial.residual_m_s2,
            }
            for trial in mounting.orders
        ],
        "notes": list(mounting.notes),
    }
