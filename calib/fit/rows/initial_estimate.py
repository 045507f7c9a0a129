"""A start that needs no values from the user: the ellipsoid on which the readings lie.

Readings of one magnitude m satisfy ``(y - b)ᵀ Q (y - b) = m²`` with ``Q = MᵀM``. Divided by
``m² - bᵀQb`` this is linear in nine unknowns, ``yᵀQ'y - 2 v'ᵀy = 1``, so one linear least squares
gives M (the Cholesky factor of Q, upper triangular) and c = -M b. Where the poses are too few or
too alike for that, the data sheet is the start.
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import SAME_MAGNITUDE

UNKNOWNS = 9  #: coefficients of a quadric of one size; definition
SMALLEST_SINGULAR_VALUE = 1e-6  #: relative to the largest; numerical, far below what a fit accepts


@dataclass(frozen=True, eq=False)
class Start:
    """The linear form ``M y + c`` that fits start from; of many sets with leading axes.

    Parameters
    ----------
    matrix : array, shape (..., 3, 3)
        M, upper triangular, without a unit.
    offset : array, shape (..., 3)
        c, m/s² or rad/s.
    """

    matrix: FloatArray
    offset: FloatArray

    @property
    def bias(self) -> FloatArray:
        """The nominal reading at which the corrected vector is zero, SI, shape (3,)."""
        return np.asarray(np.linalg.solve(self.matrix, -self.offset))

    def theta(self, model: Model) -> FloatArray:
        """Values of the parameters of a model to start from.

        Parameters
        ----------
        model : Model
            Of p parameters.

        Returns
        -------
        array, shape (..., p)
            Bias, scale and misalignment of the ellipsoid, SI, 0 for every other effect.
        """
        upper = self.matrix
        values = {
            "bias": -self.offset,
            "scale": 1 - np.einsum("...kk->...k", upper),
            "misalignment": -upper[..., [1, 0, 0], [2, 2, 1]],
        }
        theta = np.zeros((*self.offset.shape[:-1], model.size))
        for name, where in model.slices().items():
            if name in values:
                theta[..., where] = values[name]
        return theta


def start_of(poses: PoseSet) -> Start:
    """The ellipsoid of the poses where they span one, else the data sheet.

    Parameters
    ----------
    poses : PoseSet

    Returns
    -------
    Start
        Of single arrays, shapes (3, 3) and (3,).
    """
    ellipsoid = _ellipsoid(*_one_magnitude(poses))
    return Start(np.eye(3), np.zeros(3)) if ellipsoid is None else Start(*ellipsoid)


def _one_magnitude(poses: PoseSet) -> tuple[FloatArray, float]:
    """Readings of the magnitude that most poses share, and that magnitude."""
    m = poses.reference.magnitude
    turning = m[m > 0]
    if turning.size == 0:
        return np.zeros((0, 3)), 0.0
    alike = np.abs(m[:, None] / turning - 1) < SAME_MAGNITUDE
    chosen = alike[:, int(np.argmax(alike.sum(axis=0)))]
    return poses.reading[chosen], float(m[chosen].mean())


def _ellipsoid(y: FloatArray, m: float) -> tuple[FloatArray, FloatArray] | None:
    """M (3, 3) upper triangular and c (3,) of the ellipsoid through ``y`` (n, 3), or None."""
    if len(y) < UNKNOWNS:
        return None
    x = y / m
    products = 2 * x[:, [0, 0, 1]] * x[:, [1, 2, 2]]
    design = np.concatenate([x**2, products, -2 * x], axis=1)
    solution, _, rank, singular = np.linalg.lstsq(design, np.ones(len(x)), rcond=None)
    if rank < UNKNOWNS or singular[-1] < SMALLEST_SINGULAR_VALUE * singular[0]:
        return None
    xx, yy, zz, xy, xz, yz = solution[:6]
    q = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    try:
        centre = np.linalg.solve(q, solution[6:])
        upper = np.linalg.cholesky(q / (1 + centre @ q @ centre)).T
    except np.linalg.LinAlgError:  # a paraboloid or worse: the poses do not span an ellipsoid
        return None
    return upper, -upper @ centre * m
