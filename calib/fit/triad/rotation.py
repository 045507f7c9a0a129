"""Rotation matrices and vectors without :mod:`scipy.spatial`, a tenth of a second of every run."""

import numpy as np

from calib.poses.imu_log import FloatArray


def cross_matrix(vector: FloatArray) -> FloatArray:
    """The matrix of ``vector ×``, shape (3, 3), in its unit."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def nearest_rotation(matrix: FloatArray) -> FloatArray:
    """The rotation R that maximises tr(Rᵀ ``matrix``).

    Parameters
    ----------
    matrix : array, shape (3, 3)
        For ``Σ f nᵀ`` over pairs of directions it is the rotation that takes n nearest to f.

    Returns
    -------
    array, shape (3, 3)

    Source
    ------
    Markley, *J. Astronaut. Sci.* 36 (1988), on Wahba's problem, eq. (12) to (14).
    """
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Axis times angle of a rotation by up to half a turn.

    Parameters
    ----------
    rotation : array, shape (3, 3)

    Returns
    -------
    array, shape (3,)
        rad.

    Source
    ------
    Bar-Itzhack, *J. Guidance* 23 (2000): the quaternion is the dominant eigenvector of a symmetric
    matrix, without a case for small angles or for half a turn.
    """
    trace = np.trace(rotation)
    matrix = np.zeros((4, 4))
    matrix[0, 0] = trace
    matrix[1:, 1:] = rotation + rotation.T - trace * np.eye(3)
    across = rotation - rotation.T
    matrix[0, 1:] = matrix[1:, 0] = across[2, 1], across[0, 2], across[1, 0]
    quaternion = np.linalg.eigh(matrix)[1][:, -1]
    quaternion *= np.copysign(1.0, quaternion[0])
    sine = float(np.linalg.norm(quaternion[1:]))
    per_sine = 2 * np.arctan2(sine, quaternion[0]) / sine if sine > 0 else 2.0
    return np.asarray(quaternion[1:] * per_sine)
