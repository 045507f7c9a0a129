"""The ellipsoids that many fits start from: :mod:`calib.fit.rows.initial_estimate` for a stack."""

import numpy as np

from calib.fit.batch.linear_algebra import choleskys, inverses, times
from calib.fit.batch.pose_stack import PoseStack
from calib.fit.rows.initial_estimate import UNKNOWNS, Start
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.reference import SAME_MAGNITUDE

WELL_DETERMINED = 1e3
"""Condition number of the ellipsoid's design up to which its normal equations are solved: they lose
its square, 1e-10 of the start, which moves an estimate by less than 1e-11 of an sd. Derived.
Numerical."""


def starts_of(stack: PoseStack) -> Start:
    """The ellipsoid of each set, or the data sheet where too few poses share a magnitude.

    Returns
    -------
    Start
        Of S sets; NaN where an ellipsoid is too badly determined for the normal equations.
    """
    sets = len(stack)
    matrix, offset = np.tile(np.eye(3), (sets, 1, 1)), np.zeros((sets, 3))
    if stack.turning < UNKNOWNS:
        return Start(matrix, offset)
    alike = _of_one_magnitude(stack.magnitude)
    enough = alike.sum(axis=1) >= UNKNOWNS
    if enough.any():
        m = (stack.magnitude * alike).sum(axis=1) / alike.sum(axis=1)
        y = stack.reading[:, : stack.turning] / m[:, None, None]
        upper, shift = _ellipsoids(y[enough], alike[enough])
        matrix[enough], offset[enough] = upper, shift * m[enough, None]
    return Start(matrix, offset)


def _of_one_magnitude(magnitude: FloatArray) -> BoolArray:
    """Which poses (S, k) are of the magnitude that most poses of their set share."""
    if (magnitude == magnitude[:, :1]).all():
        return np.ones(magnitude.shape, dtype=bool)
    alike = np.abs(magnitude[:, :, None] / magnitude[:, None, :] - 1) < SAME_MAGNITUDE
    most = alike.sum(axis=1).argmax(axis=1)
    return np.asarray(np.take_along_axis(alike, most[:, None, None], axis=2)[:, :, 0])


def _ellipsoids(x: FloatArray, alike: BoolArray) -> tuple[FloatArray, FloatArray]:
    """M (S, 3, 3) and c (S, 3) of ``yᵀQ'y - 2 v'ᵀy = 1`` through readings (S, k, 3) over m."""
    products = 2 * x[..., [0, 0, 1]] * x[..., [1, 2, 2]]
    design = np.concatenate([x**2, products, -2 * x], axis=2) * alike[..., None]
    transposed = np.swapaxes(design, 1, 2)
    normal = transposed @ design
    inverse = inverses(normal)
    # The condition number squared is at most the trace of both.
    bound = np.trace(normal, axis1=1, axis2=2) * np.trace(inverse, axis1=1, axis2=2)
    solution = times(inverse, design.sum(axis=1))
    solution[~(bound < WELL_DETERMINED**2)] = np.nan
    q = solution[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    centre = times(inverses(q), solution[:, 6:])
    size = 1 + (centre * times(q, centre)).sum(axis=1)
    upper = np.swapaxes(choleskys(q / size[:, None, None]), 1, 2)
    return upper, -times(upper, centre)
