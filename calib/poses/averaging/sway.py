"""Gravity that a pose at rest lost because it was shaken.

A sensor that rocks by the angle φ about its mean attitude senses ``f cos φ`` along it on average:
the length of its mean is short by ``g φ²/2``, which the scatter of batch means does not show. Both
triads bound φ from above: gravity sweeps over the accelerometer's axes and scatters its samples by
``g² φ²``, all axes together, and the gyroscope turns by φ. Vibration along a line scatters the
samples without rotation: it averages out.
"""

from collections.abc import Sequence

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.errors import Undetermined
from calib.numbers import NO_LENGTH
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.checks.pose_checks import LARGEST_STILL_SHIFT
from calib.poses.imu_log import FloatArray
from calib.poses.reference import PLAUSIBLE_RATIO


def sway_square(rates: FloatArray, duration_s: float) -> float:
    """Mean square of the angle by which a pose rocks, all axes together, rad².

    Parameters
    ----------
    rates : array, shape (t, 3)
        Samples of the gyroscope in equal steps, rad/s; their mean counts as bias.
    duration_s : float
        From the first sample to the last.
    """
    step_s = duration_s / max(len(rates) - 1, 1)
    angle = np.cumsum(rates - rates.mean(axis=0), axis=0) * step_s
    return float(angle.var(axis=0).sum())


def check_calm(label: str, scatter: FloatArray, sway: float, gravity: float, limit: float) -> None:
    """Refuse a pose that rocked so much that its mean is short by more than ``limit``, m/s².

    Parameters
    ----------
    scatter : array, shape (3,)
        Variance of the accelerometer's samples, (m/s²)².
    sway : float
        Of :func:`sway_square`, rad²; NaN where the gyroscope was not logged.
    gravity : float
        Length of the accelerometer's mean, m/s². Readings that are no gravity say nothing: their
        unit is wrong.
    """
    ratio = gravity / STANDARD_GRAVITY_M_S2
    if not 1 / PLAUSIBLE_RATIO < ratio < PLAUSIBLE_RATIO:
        return
    short = float(np.min([scatter.sum() / (2 * gravity), gravity * sway / 2]))
    if short > limit:  # not where either triad was not logged
        raise Undetermined(
            f"{label}: the sensor was shaken: by gyroscope and accelerometer it rocks by "
            f"{np.degrees(np.sqrt(sway)):.2g}° (rms) within the pose, so that its mean is up to "
            f"{short:.2g} m/s² short of gravity, where {limit:.2g} m/s² is accepted. Record the "
            f"pose again, or cut the log to the part in which it lay still."
        )


NOTICEABLE_M_S2 = LARGEST_STILL_SHIFT["accelerometer"]
"""Loss of gravity. Derived: as much as a still pose may stray."""


def shortfall(means: Sequence[PoseMean]) -> FloatArray:
    """Largest gravity that the mean of each pose at rest of a run may lack, m/s², (n,).

    The scatter of the median pose is the sensor's noise; only what exceeds it can be rocking.
    """
    _, _, swept = _swept(means)
    turned = [np.linalg.norm(mean.accelerometer.mean) * mean.sway_rad2 / 2 for mean in means]
    return np.asarray(np.fmin(swept, turned))


def shaken(means: Sequence[PoseMean], run: str) -> str | None:
    """Note on poses of a run that scatter far more than the others, or None.

    Rocking by as much would make them ``NOTICEABLE_M_S2`` short.

    Parameters
    ----------
    means : sequence of PoseMean
        The poses at rest of the run.
    run : str
        Its name.
    """
    scatter, usual, swept = _swept(means)
    odd = np.flatnonzero(swept > NOTICEABLE_M_S2)
    if not odd.size:
        return None
    worst = int(odd[np.argmax(swept[odd])])
    others = f" (and {odd.size - 1} others)" if odd.size > 1 else ""
    return (
        f"{run}: in {means[worst].label}{others} the accelerometer's samples scatter by "
        f"{np.sqrt(scatter[worst]):.2g} m/s², in a typical pose by {np.sqrt(usual):.2g} m/s²: it "
        f"was shaken, or the log is faulty. Record the pose again, or take it out of the list."
    )


def _swept(means: Sequence[PoseMean]) -> tuple[FloatArray, float, FloatArray]:
    """Scatter of all axes (n,), its median, and gravity lost if the excess were rocking, (n,)."""
    scatter = np.array([mean.accelerometer.scatter.sum() for mean in means])
    gravity = np.linalg.norm([mean.accelerometer.mean for mean in means], axis=1)
    usual = float(np.median(scatter))
    return scatter, usual, np.maximum(scatter - usual, 0.0) / (2 * np.maximum(gravity, NO_LENGTH))
