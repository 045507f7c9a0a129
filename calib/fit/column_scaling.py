"""Scaling of columns to unit length before they are decomposed, and back.

Parameters have units of their own (counts, radians, per kelvin squared), so that the columns of a
Jacobian differ by many powers of ten. With ``J = U diag(n)``, n the lengths of the columns, the
decompositions work on U, whose condition number speaks of the poses and not of the units.
"""

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
