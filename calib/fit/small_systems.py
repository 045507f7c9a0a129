"""Stacks of small systems of linear equations, some of which may be singular."""

from collections.abc import Callable

import numpy as np

from calib.fit.column_scaling import RANK_TOLERANCE, unit_columns
from calib.poses.imu_log import FloatArray


def inverses(matrices: FloatArray) -> FloatArray:
    """Inverses of matrices (..., k, k) of any unit, NaN for each that is singular."""
    return _one_by_one(np.linalg.inv, matrices)


def choleskys(matrices: FloatArray) -> FloatArray:
    """Lower Cholesky factors (..., k, k) of matrices of any unit, NaN if not positive definite."""
    return _one_by_one(np.linalg.cholesky, matrices)


def solutions(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions (..., k, c) of systems, right sides (..., k, c) of any unit, NaN where singular."""
    return _one_by_one(np.linalg.solve, matrices, right)


def triangle_solutions(triangles: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions x (S, k, c) of ``R x = b`` for triangles R (S, k, k) of unit columns.

    In any unit; the shortest solutions where the columns are dependent.
    """
    diagonal = np.abs(np.einsum("sii->si", triangles))
    sound = diagonal.min(axis=1, initial=1.0) > RANK_TOLERANCE * diagonal.max(axis=1, initial=0.0)
    if sound.all():
        return np.asarray(np.linalg.solve(triangles, right))
    result = np.empty_like(right)
    for i, one in enumerate(triangles):
        result[i] = (np.linalg.solve(one, right[i]) if sound[i]
                     else np.linalg.lstsq(one, right[i], rcond=RANK_TOLERANCE)[0])
    return result


def _one_by_one(operation: Callable[..., FloatArray], *stacks: FloatArray) -> FloatArray:
    """``operation`` on the matrices of a stack, NaN where one cannot be decomposed.

    LAPACK refuses a whole stack because of one such matrix: the stack is halved until it is alone.
    """
    try:
        return np.asarray(operation(*stacks))
    except np.linalg.LinAlgError:
        if stacks[0].ndim == 2 or len(stacks[0]) == 0:
            return np.full_like(stacks[-1], np.nan)
        if len(stacks[0]) == 1:
            return _one_by_one(operation, *(stack[0] for stack in stacks))[None]
        half = len(stacks[0]) // 2
        halves = [_one_by_one(operation, *(stack[part] for stack in stacks))
                  for part in (slice(half), slice(half, None))]
        return np.concatenate(halves)


def inverse_square(matrix: FloatArray) -> FloatArray:
    """``(AᵀA)⁻¹`` (..., k, k) of matrices (..., r, k) of full rank, of any unit, by their QR form.

    A column of zeros is left out: its row and its column are zero. NaN where the rank is not full.
    """
    unit, norm = unit_columns(matrix)
    triangle = np.asarray(np.linalg.qr(unit, mode="r"))
    nothing = np.asarray((unit == 0).all(axis=-2))
    triangle = triangle + nothing[..., None] * np.eye(norm.shape[-1])
    inverse = inverses(triangle) / norm[..., :, None]
    square = inverse @ inverse.swapaxes(-1, -2)
    return np.where(nothing[..., None, :] | nothing[..., None], 0.0, square)


def times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Matrices (..., r, k) times vectors (..., k), shape (..., r), of any unit."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])


def combined(columns: FloatArray, sizes: FloatArray) -> FloatArray:
    """Errors (..., n, 3), SI, from columns (..., n, 3, k) and parameters (..., k)."""
    *lead, n, axes, k = columns.shape
    return times(columns.reshape(*lead, n * axes, k), sizes).reshape(*lead, n, axes)
