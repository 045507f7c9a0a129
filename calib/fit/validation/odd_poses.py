"""Poses that contradict all others, by the least misfit under any nine parameters.

They are found together, because one can mask the next: if three poses are wrong and one is left
out, the other two still spoil the fit. Every set of up to three is left out, and the least misfit
of the rest shows which set it is, by the log likelihood ratio ``d/2 ln(chi2_all / chi2_rest)``.

Where ``|M y + c| = m``, the readings y lie on a quadric, ``yᵀA y + bᵀy + d = λ m²`` with A = MᵀM,
linear in its coefficients once its size is fixed by ``trace A = 3``. To first order
``(|s|² - m²) / (2 m) = |s| - m``. Free d and λ and no null rows leave less than the fit does.
"""

from itertools import combinations

import numpy as np

from calib.errors import CalibrationError
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit
from calib.fit.linear import orthonormal_bases, times
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from calib.poses.pose_set import PoseSet

MOST_ODD = 3  #: poses; derived: what a set of 18 can lose before a direction is missing
MOST_SETS = 1000  #: sets of poses left out; a limit of time


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


def odd_poses(poses: PoseSet) -> BoolArray | None:
    """The poses that contradict all others, (n,); None where no small set of poses does."""
    columns, target = quadric(poses)
    n, unknowns = columns.shape
    kept = np.ones((1, n), dtype=bool)
    for size in range(1, min(MOST_ODD, n - unknowns - 1) + 1):
        out = np.array([*combinations(range(n), size)])
        if len(kept) - 1 + len(out) > MOST_SETS:
            break
        kept = np.concatenate([kept, ~(out[..., None] == np.arange(n)).any(axis=1)])
    if len(kept) == 1:
        return None
    chi2, dof = left_over(columns, target, kept)
    dof = np.maximum(dof[1:], 1)
    gained = dof / 2 * np.log(np.maximum(chi2[0], dof) / np.maximum(chi2[1:], dof))
    best = int(np.argmax(gained))
    if gained[best] < np.log(len(gained) / FALSE_ALARM):
        return None
    odd = np.zeros(len(poses), dtype=bool)
    odd[~poses.reference.is_null] = ~kept[1 + best]
    return odd


def few_odd_poses(fitted: Fit) -> tuple[str, ...]:
    """Labels of the few poses without which the model explains all others; none else.

    A function of the attitude would show in the others too.
    """
    odd = odd_poses(fitted.poses)
    if odd is None:
        return ()
    try:
        rest = fit(fitted.poses.take(~odd), fitted.model)
    except CalibrationError:
        return ()
    labels = zip(fitted.poses.label, odd, strict=True)
    explained = rest.p_value > MISFIT_P_VALUE
    return tuple(label for label, is_odd in labels if is_odd and explained)
