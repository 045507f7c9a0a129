"""What any nine parameters leave of a set of poses at least, by linear least squares.

Where ``|M y + c| = m``, the readings y lie on a quadric, ``yᵀA y + bᵀy + d = λ m²`` with A = MᵀM,
linear in its coefficients once its size is fixed by ``trace A = 3``. To first order
``(|s|² - m²) / (2 m) = |s| - m``. Free d and λ, all common errors free of cost and no null rows
leave less than the fit does, so what they leave bounds its chi-square from below.
"""

from collections.abc import Sequence

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


def least_chi2(sets: Sequence[PoseSet]) -> FloatArray:
    """Chi-square, no unit, that a fit of bias, scale and misalignment leaves at least, (k,).

    Parameters
    ----------
    sets : sequence of PoseSet, length k

    Returns
    -------
    array, shape (k,)
        To first order of the misfit over the reference, and for gains that are those of the data
        sheet. Sds count as the largest of the three axes.
    """
    least = []
    for poses in sets:
        columns, target = quadric(poses)
        turning = ~poses.reference.is_null
        free = poses.reference.common[turning] / _sd(poses)[:, None]
        least.append(left_over(np.hstack([columns, free]), target)[0])
    return np.array(least)


def quadric(poses: PoseSet) -> tuple[FloatArray, FloatArray]:
    """Columns (m, 10) and target (m,) of the quadric through the poses not at rest, in sds."""
    turning = ~poses.reference.is_null
    y, magnitude = poses.reading[turning], poses.reference.magnitude[turning]
    squares = y**2
    columns = np.column_stack([squares[:, :2] - squares[:, 2:], y * np.roll(y, 1, axis=1), y,
                               np.ones(len(y)), magnitude**2])
    weight = 1 / (2 * magnitude * _sd(poses))
    return columns * weight[:, None], squares.sum(axis=1) * weight


def left_over(columns: FloatArray, target: FloatArray) -> tuple[float, int]:
    """Chi-square that a fit of the columns leaves of the target, and its degrees of freedom."""
    solution, _, rank, _ = np.linalg.lstsq(columns, target)
    return float(((target - columns @ solution) ** 2).sum()), len(target) - int(rank)


def _sd(poses: PoseSet) -> FloatArray:
    """Sds of the magnitudes of the poses not at rest, (m,)."""
    turning = ~poses.reference.is_null
    return np.asarray(np.hypot(poses.sd[turning].max(axis=1), poses.reference.sd[turning]))
