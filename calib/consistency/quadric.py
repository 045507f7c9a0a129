"""Least misfit of a set of poses under any nine parameters, by linear least squares.

Where ``|M y + c| = m``, the readings y lie on a quadric, ``yᵀA y + bᵀy + d = λ m²`` with A = MᵀM,
linear in its coefficients once its size is fixed by ``trace A = 3``. To first order
``(|s|² - m²) / (2 m) = |s| - m``. Free d and λ and no null rows leave less than the fit does.
"""

import numpy as np

from calib.fit.linear import orthonormal_bases, times
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from calib.poses.pose_set import PoseSet


def quadric(poses: PoseSet) -> tuple[FloatArray, FloatArray]:
    """Columns (m, 10) and target (m,) of the quadric through the poses not at rest, in sds."""
    turning = ~poses.reference.is_null
    sd = np.hypot(poses.sd[turning].max(axis=1), poses.reference.sd[turning])
    y, magnitude = poses.reading[turning], poses.reference.magnitude[turning]
    squares = y**2
    columns = np.column_stack([squares[:, :2] - squares[:, 2:], y * np.roll(y, 1, axis=1), y,
                               np.ones(len(y)), magnitude**2])
    weight = 1 / (2 * magnitude * sd)
    return columns * weight[:, None], squares.sum(axis=1) * weight


def left_over(
    columns: FloatArray, target: FloatArray, kept: BoolArray | None = None
) -> tuple[FloatArray, IntArray]:
    """Chi-square (s,) of the target after fits, and degrees of freedom (s,), no unit.

    Each of s fits uses the rows that are ``kept`` (s, m); by default one fit uses all of them.
    """
    kept = np.ones((1, len(target)), dtype=bool) if kept is None else kept
    design = columns * kept[..., None]
    basis = orthonormal_bases(design)
    rest = target * kept
    rest = rest - times(basis, times(basis.swapaxes(1, 2), rest))
    rank = basis.any(axis=1).sum(axis=1)
    return (rest**2).sum(axis=1), kept.sum(axis=1) - rank
