"""The mounting angles in words."""

import math
from collections.abc import Iterator

from calib.mounting.mounting import Mounting
from pipeline.text.formatting import with_sd


def mounting_parts(mounting: Mounting) -> Iterator[str]:
    """``roll 30.65 ± 0.01°`` and so on, for each measured angle."""
    roll_sd, pitch_sd = mounting.sd_rad
    yield f"roll {_degrees(mounting.roll_rad, roll_sd)}"
    yield f"pitch {_degrees(mounting.pitch_rad, pitch_sd)}"
    if mounting.yaw:
        yield f"yaw {_degrees(mounting.yaw.yaw_rad, mounting.yaw.sd_rad)}"
    if mounting.slope:
        slope = mounting.slope
        for axis, rise, sd in zip("xy", slope.rise_rad, slope.sd_rad, strict=True):
            yield f"floor rises along {axis} by {_degrees(float(rise), float(sd))}"


def mounting_text(mounting: Mounting) -> str:
    """One line for the terminal and the report."""
    return f"{', '.join(mounting_parts(mounting))} (order {mounting.order})"


def _degrees(angle_rad: float, sd_rad: float) -> str:
    return f"{with_sd(math.degrees(angle_rad), math.degrees(sd_rad))}°"
