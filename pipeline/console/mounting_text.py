"""The mounting angles in words."""

import math
from collections.abc import Iterator

from calib.mounting.mounting import Mounting
from pipeline.formatting import with_sd


def mounting_parts(found: Mounting) -> Iterator[str]:
    """``roll 30.65 ± 0.01°`` and so on, what was measured."""
    roll_sd, pitch_sd = found.sd_rad
    yield f"roll {_degrees(found.roll_rad, roll_sd)}"
    yield f"pitch {_degrees(found.pitch_rad, pitch_sd)}"
    if found.yaw:
        yield f"yaw {_degrees(found.yaw.yaw_rad, found.yaw.sd_rad)}"
    if found.slope:
        for axis, rise, sd in zip("xy", found.slope.rise_rad, found.slope.sd_rad, strict=True):
            yield f"floor rises along {axis} by {_degrees(float(rise), float(sd))}"


def mounting_text(found: Mounting) -> str:
    """One line for the terminal and the report."""
    return f"{', '.join(mounting_parts(found))} (order {found.order})"


def _degrees(angle_rad: float, sd_rad: float) -> str:
    return f"{with_sd(math.degrees(angle_rad), math.degrees(sd_rad))}°"
