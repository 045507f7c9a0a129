"""Linear algebra of columns of any unit, and of stacks of small systems that may be singular.

Parameters have units of their own (counts, radians, per kelvin squared), so that the columns of a
Jacobian differ by many powers of ten. With ``J = U diag(n)``, n the lengths of the columns, the
decompositions work on U, whose condition number speaks of the poses and not of the units.
"""

from collections.abc import Callable

import numpy as np

from calib.poses.imu_log import FloatArray

RANK_TOLERANCE = 1e-9
"""Singular value of unit columns, relative to the largest, below which they are dependent: far
above rounding (1e-15), far below what the refused condition numbers (25 and 625) correspond to.
Numerical."""

NORM_FLOOR = 1e-9
"""Share of the largest column of an effect below which a column is zero. Numerical: rounding."""


def unit_columns(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The columns of a matrix, or of each matrix of a stack, at unit length, and their lengths.

    Parameters
    ----------
    matrix : array, shape (..., r, k)

    Returns
    -------
    unit : array, shape (..., r, k)
        Unit vectors as columns; a column of zeros stays one.
    norm : array, shape (..., k)
        Their lengths, in their units, 1 for a column of zeros:
        ``matrix == unit * norm[..., None, :]``.
    """
    norm = np.sqrt((matrix**2).sum(axis=-2))
    norm[norm == 0] = 1.0
    return np.asarray(matrix / norm[..., None, :]), np.asarray(norm)


def orthonormal_columns(matrix: FloatArray) -> FloatArray:
    """Orthonormal basis of the space that the columns of a matrix span.

    Parameters
    ----------
    matrix : array, shape (r, k)

    Returns
    -------
    array, shape (r, rank)
        The rank is that of the unit columns, by :data:`RANK_TOLERANCE`.
    """
    u, singular, _ = np.linalg.svd(unit_columns(matrix)[0], full_matrices=False)
    return np.asarray(u[:, singular > RANK_TOLERANCE * singular.max(initial=0.0)])


def orthonormal_bases(matrices: FloatArray) -> FloatArray:
    """:func:`orthonormal_columns` of one matrix or of each of a stack.

    Parameters
    ----------
    matrices : array, shape (..., r, k)

    Returns
    -------
    array, shape (..., r, min(r, k))
        Orthonormal but for columns of zeros, which stand for what a matrix lacks in rank.
    """
    u, singular, _ = np.linalg.svd(unit_columns(matrices)[0], full_matrices=False)
    least = RANK_TOLERANCE * singular.max(axis=-1, initial=0.0)
    return np.asarray(u * (singular > least[..., None])[..., None, :])


def pseudo_inverse(matrix: FloatArray, tolerance: float = 1e-15) -> FloatArray:
    """Pseudo-inverse of a matrix of any unit, or of each of a stack, its rank judged on the unit
    columns.

    Parameters
    ----------
    matrix : array, shape (..., r, k)
    tolerance : float
        Singular value of the unit columns, relative to the largest, that counts as zero.

    Returns
    -------
    array, shape (..., k, r)
    """
    unit, norm = unit_columns(matrix)
    return np.asarray(np.linalg.pinv(unit, rcond=tolerance) / norm[..., :, None])


def pseudo_inverse_square(matrix: FloatArray) -> FloatArray:
    """``(AᵀA)⁻¹`` (..., k, k) of matrices A (..., r, k) of any rank and any unit, by their
    pseudo-inverse.
    """
    inverse = pseudo_inverse(matrix)
    return np.asarray(inverse @ inverse.swapaxes(-1, -2))


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
