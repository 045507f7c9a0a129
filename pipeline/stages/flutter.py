"""Wow and flutter of a platter: from its clip, or from a gyroscope that turns with it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.poses.imu_log import ImuLog
from pipeline.errors import UnreadableInput
from vision.rate.aes6_flutter import (
    PlatterFlutter,
    SpeedCourse,
    course_of_clip,
    course_of_rates,
    platter_flutter,
)

if TYPE_CHECKING:
    from vision.rate.measure import RateMeasurement

SLOWEST_RAD_S = 0.5  #: fact: 5 rpm, a third of the slowest record
AGREES = 0.1
"""Largest relative difference of a gyroscope's mean from the clip's rate. A judgement: data sheets
allow 3 % of scale, and a bias of 20 °/s is a tenth of 33 rpm."""


@dataclass(frozen=True, eq=False)
class MeasuredFlutter:
    """Flutter figures and the speed course that they come from.

    Attributes
    ----------
    source : str
        The clip or the log.
    by_gyroscope : bool
    course : SpeedCourse
    figures : PlatterFlutter
    scale_error : float
        How far the gyroscope's mean is off the clip's rate, relative: the figures err by as much;
        NaN where it was not compared.
    """

    source: str
    by_gyroscope: bool
    course: SpeedCourse
    figures: PlatterFlutter
    scale_error: float = float("nan")


def flutter_of_clip(source: str, rate: "RateMeasurement") -> MeasuredFlutter:
    """Figures from the angles of a clip.

    Raises
    ------
    RateRefused
        It is too short, or has too few frames per second.
    """
    course = course_of_clip(rate)
    return MeasuredFlutter(source, False, course, platter_flutter(course, source))


def flutter_of_gyroscope(log: ImuLog, rate: "RateMeasurement | None" = None) -> MeasuredFlutter:
    """Figures from the readings of a gyroscope that lies on the turning platter.

    Its component along the mean is taken, without noise across the axis and a tilted table. The
    mean stands for the rate: a scale error of the gyroscope cancels, its bias does not.

    Parameters
    ----------
    log : ImuLog
        In rad/s.
    rate : RateMeasurement, optional
        Of a clip of the same setting, which the mean must agree with.

    Raises
    ------
    UnreadableInput
        The log has no gyroscope, or it does not turn with a platter at the clip's rate.
    RateRefused
        It is too short, or has too few samples per second.
    """
    if not log.has("gyroscope"):
        raise UnreadableInput(f"{log.label}: has no gyroscope columns (gyr_x, gyr_y, gyr_z); those "
                              f"are needed to see how evenly the platter turns.")
    readings = log.gyroscope[np.isfinite(log.gyroscope).all(axis=1)]
    time_s = log.time_s[np.isfinite(log.gyroscope).all(axis=1)]
    mean = readings.mean(axis=0)
    size = float(np.linalg.norm(mean))
    if size < SLOWEST_RAD_S:
        raise UnreadableInput(
            f"{log.label}: its gyroscope turns by {np.degrees(size):.2f} °/s on average; a platter "
            f"turns by {np.degrees(SLOWEST_RAD_S):.0f} °/s and more. Log the sensor on the turning "
            f"platter, and state its units (--config)."
        )
    off = float("nan") if rate is None else size / rate.rate_rad_s - 1
    if abs(off) > AGREES:
        raise UnreadableInput(
            f"{log.label}: its gyroscope turns at {np.degrees(size):.4g} °/s, the plate in the "
            f"clip at {np.degrees(size / (1 + off)):.4g} °/s. They belong to different speeds, or "
            f"the units of the log are others (--config)."
        )
    axes = np.linalg.svd(mean[None] / size)[2]  # (3, 3): the axis of the platter, and two across
    course = course_of_rates(time_s, readings @ (mean / size), readings @ axes[1:].T)
    return MeasuredFlutter(log.label, True, course, platter_flutter(course, log.label), off)
