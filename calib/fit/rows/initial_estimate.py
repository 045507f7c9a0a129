"""A start that needs no values from the user: the ellipsoid on which the readings lie.

Readings of one magnitude m satisfy ``(y - b)ᵀ Q (y - b) = m²`` with ``Q = MᵀM``. Divided by
``m² - bᵀQb`` this is linear in nine unknowns, ``yᵀQ'y - 2 v'ᵀy = 1``, so one linear least squares
gives M (the Cholesky factor of Q, upper triangular) and c = -M b. Where the poses are too few or
too alike for that, the data sheet is the start.
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.linear import choleskys, inverses, solutions, times
from calib.fit.model import Model
from calib.fit.stacked import Stacked
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.reference import SAME_MAGNITUDE

UNKNOWNS = 9  #: coefficients of a quadric of one size; definition
LARGEST_CONDITION = 1e6
"""Condition number (of Frobenius norms) beyond which poses span no ellipsoid. Numerical: far above
what a fit accepts."""


@dataclass(frozen=True, eq=False)
class Start(Stacked):
    """The linear form ``M y + c`` that fits start from.

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
        """The nominal reading at which the corrected vector is zero, SI, shape (..., 3)."""
        return np.asarray(np.linalg.solve(self.matrix, -self.offset[..., None])[..., 0])

    def corrected(self, reading: FloatArray) -> FloatArray:
        """``M y + c`` of readings (..., n, 3), SI."""
        return np.asarray(reading @ self.matrix.swapaxes(-1, -2) + self.offset[..., None, :])

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


def starts_of(reading: FloatArray, magnitude: FloatArray) -> Start:
    """The ellipsoids of S sets of poses where they span one, else the data sheet.

    Parameters
    ----------
    reading : array, shape (S, k, 3)
        Readings of the poses with a magnitude, SI.
    magnitude : array, shape (S, k)
        Their references, SI.

    Returns
    -------
    Start
        Of S sets.
    """
    sets = len(reading)
    matrix, offset = np.tile(np.eye(3), (sets, 1, 1)), np.zeros((sets, 3))
    chosen = _of_one_magnitude(magnitude)
    enough = np.flatnonzero(chosen.sum(axis=1) >= UNKNOWNS)
    if enough.size:
        chosen = chosen[enough]
        m = (magnitude[enough] * chosen).sum(axis=1) / chosen.sum(axis=1)
        upper, shift = _ellipsoids(reading[enough] / m[:, None, None], chosen)
        spans = np.isfinite(upper).all(axis=(1, 2)) & np.isfinite(shift).all(axis=1)
        matrix[enough[spans]], offset[enough[spans]] = upper[spans], (shift * m[:, None])[spans]
    return Start(matrix, offset)


def _of_one_magnitude(magnitude: FloatArray) -> BoolArray:
    """Poses (S, k) of the magnitude that is most frequent in their set."""
    if (magnitude == magnitude[:, :1]).all():
        return np.ones(magnitude.shape, dtype=bool)
    near = np.abs(magnitude[:, :, None] / magnitude[:, None, :] - 1) < SAME_MAGNITUDE
    most = near.sum(axis=1).argmax(axis=1)
    return np.asarray(np.take_along_axis(near, most[:, None, None], axis=2)[:, :, 0])


def _ellipsoids(x: FloatArray, chosen: BoolArray) -> tuple[FloatArray, FloatArray]:
    """M (S, 3, 3) and c (S, 3) through the ``chosen`` readings (S, k, 3) over m.

    NaN where the poses span no ellipsoid but a paraboloid or worse.
    """
    products = 2 * x[..., [0, 0, 1]] * x[..., [1, 2, 2]]
    design = np.concatenate([x**2, products, -2 * x], axis=2) * chosen[..., None]
    q, r = np.linalg.qr(design)
    inverse = inverses(r)
    condition = np.linalg.norm(r, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2))
    solution = times(inverse, times(q.swapaxes(1, 2), chosen.astype(float)))
    solution[~(condition < LARGEST_CONDITION)] = np.nan
    quadric = solution[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    centre = solutions(quadric, solution[:, 6:, None])[..., 0]
    size = 1 + (centre * times(quadric, centre)).sum(axis=1)
    upper = choleskys(quadric / size[:, None, None]).swapaxes(1, 2)
    return upper, -times(upper, centre)
