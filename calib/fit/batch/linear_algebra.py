"""Solutions of many small systems, of which some may be singular."""

from collections.abc import Callable

import numpy as np

from calib.fit.column_scaling import unit_columns
from calib.poses.imu_log import FloatArray


def inverses(matrices: FloatArray) -> FloatArray:
    """Inverses of S matrices of any unit, NaN for each that is singular, (S, k, k)."""
    return _each(np.linalg.inv, matrices)


def choleskys(matrices: FloatArray) -> FloatArray:
    """Lower Cholesky factors (S, k, k) of matrices of any unit, NaN if not positive definite."""
    return _each(np.linalg.cholesky, matrices)


def solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (S, k) of S systems with right sides (S, k) of any unit, NaN where singular."""
    return each_solved(matrices, right[..., None])[..., 0]


def each_solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (S, k, c) of S systems, right sides (S, k, c) of any unit, NaN where singular."""
    return _each(np.linalg.solve, matrices, right)


def _each(operation: Callable[..., FloatArray], *stacks: FloatArray) -> FloatArray:
    """``operation`` on the matrices of a stack, NaN where one cannot be decomposed.

    LAPACK refuses a whole stack for one such matrix: the stack is halved until it is alone.
    """
    try:
        return np.asarray(operation(*stacks))
    except np.linalg.LinAlgError:
        sets = len(stacks[0])
        if sets == 1:
            return np.full_like(stacks[-1], np.nan)
        halves = [_each(operation, *(each[part] for each in stacks))
                  for part in (slice(sets // 2), slice(sets // 2, None))]
        return np.concatenate(halves)


def times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """S matrices (S, r, k) times S vectors (S, k), shape (S, r), of any unit."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])


def scaled_information(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """``UᵀU`` (S, k, k) of the unit columns U of S Jacobians (S, r, k), and their lengths (S, k).

    A column of zeros stays one, and has the length 1. The lengths are in their units.
    """
    unit, norm = unit_columns(jacobian)
    return np.swapaxes(unit, 1, 2) @ unit, norm
