"""The mounting in the report: angles in both orders, and the readings before and after.

The charts are those of figure 5 of Promrit et al.
"""

import math

import numpy as np

from calib.mounting.both_orders import OrderTrial
from calib.mounting.mounting import Mounting
from calib.poses.imu_log import AXES, FloatArray
from pipeline.console.parameter_text import mounting_text
from pipeline.drawings.charts import Chart, Figure, across, upward
from pipeline.results.json_values import Json
from pipeline.text.formatting import with_minus_signs, with_sd

ROOM = 0.08  #: share of the range of the forces, above and below; layout
DIGITS = 4  #: digits of a force that the page shows
NAME_PX = 14  #: from the name of one line to the next, which may overlap it; layout
NOT_DETERMINED = "locked"


def mounting_view(mounting: Mounting | None) -> Json | None:
    """Contents of the page on the mounting, a row for each order of the rotations; None if it was
    not measured.
    """
    if mounting is None:
        return None
    readings = mounting.readings
    forces = np.concatenate([readings.before, readings.after])
    room = ROOM * float(np.ptp(forces))
    limits = (float(forces.min()) - room, float(forces.max()) + room)
    return {
        "text": mounting_text(mounting),
        "notes": mounting.notes,
        "orders": [_row(trial, mounting.order) for trial in mounting.orders],
        "figures": (
            _curves("Readings in the sensor's axes", readings.time_s, readings.before,
                    mounting.before, limits, "three level lines: the sensor stood still."),
            _curves("Readings in the vehicle's axes", readings.time_s, readings.after,
                    mounting.after, limits, "x and y on zero, z on the magnitude of gravity."),
        ),
    }


def _row(trial: OrderTrial, used: str) -> tuple[str, ...]:
    """The order, roll, pitch, side of eq. (6) and the remainder of the levelled mean in mm/s²."""
    roll, pitch = (
        f"{with_sd(math.degrees(angle), math.degrees(sd))}°" if math.isfinite(sd)
        else NOT_DETERMINED
        for angle, sd in zip((trial.roll_rad, trial.pitch_rad), trial.sd_rad, strict=True)
    )
    name = f"{trial.order} (used)" if trial.order == used else trial.order
    return name, roll, pitch, f"{trial.margin:.4f}", f"{1e3 * trial.residual_m_s2:.2f}"


def _curves(
    title: str, time_s: FloatArray, force: FloatArray, mean: FloatArray,
    limits: tuple[float, float], good: str,
) -> Figure:
    """One line for each axis against the time, on a scale that both charts share."""
    chart = Chart(across(time_s), upward(*limits), "time [s]", "specific force [m/s²]")
    chart.axes()
    chart.level(0.0)
    for i, axis in enumerate(AXES):
        chart.line(time_s, force[:, i], f"axis{i}")
        chart.parts.append(f'<text class="title" x="{chart.right - NAME_PX * (2 - i):g}" '
                           f'y="{chart.y(mean[i]):.1f}" dy="-5" text-anchor="end">{axis}</text>')
    means = ", ".join(f"{axis} {value:.{DIGITS}f}"
                      for axis, value in zip(AXES, np.round(mean, DIGITS) + 0.0, strict=True))
    caption = with_minus_signs(f"{len(time_s)} single readings; means {means} m/s².")
    return Figure(title, chart.svg(f"{title}. {caption}"), good, caption)
