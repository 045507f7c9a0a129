"""Starts of parameters on which a length depends only through their squares."""

from collections.abc import Sequence

import numpy as np

from calib.effects.effect import Effect
from calib.fit.linear import RANK_TOLERANCE, pseudo_inverse, times
from calib.fit.rows.residuals import Equations
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


def square_start(
    equations: Equations, theta: FloatArray, effects: Sequence[Effect]
) -> FloatArray:
    """Starts of ``effects`` whose derivative vanishes at zero, else 0, SI, (S, p).

    Either sign is right.

    A transverse error ``F r`` changes the length by ``|F r|² / 2|s|``, which is linear in the
    matrix ``r rᵀ``. That is fitted together with the model; its largest eigenvector is r, up to the
    sign.
    """
    start = np.zeros_like(theta)
    if not effects:
        return start
    sets = len(theta)
    rows = equations.rows(theta, np.zeros((sets, equations.common_count)), {})
    at = equations.conditions(rows.vector)
    for effect in effects:
        columns = square_columns(equations, effect, at)
        whitened = np.zeros((*rows.residual.shape, columns.shape[-1]))
        whitened[:, : len(equations.magnitude)] = columns / equations.magnitude_sd[..., None]
        where = equations.model.slices()[effect.name]
        others = np.delete(rows.jacobian, where, axis=2)
        design = np.concatenate([whitened, others], axis=2)
        solution = times(pseudo_inverse(design, RANK_TOLERANCE), rows.residual)
        k = len(effect.parameters)
        square = np.zeros((sets, k, k))
        i, j = np.triu_indices(k)
        square[:, i, j] = solution[:, : columns.shape[-1]]
        values, vectors = np.linalg.eigh((square + square.swapaxes(1, 2)) / 2)
        start[:, where] = np.sqrt(np.abs(values[:, -1:])) * vectors[:, :, -1]
    return start


def square_columns(equations: Equations, effect: Effect, at: Conditions) -> FloatArray:
    """Errors of the magnitude rows, SI, by the products r_i r_j of an effect's parameters.

    Parameters
    ----------
    equations : Equations
    effect : Effect
        Whose signal in a length begins with the square of its k parameters (``in_square``).
    at : Conditions
        Of the n poses of each set, with the corrected vectors.

    Returns
    -------
    array, shape (..., rows, k (k + 1) / 2)
        For i ≤ j in the order of ``numpy.triu_indices``: ``F_i·F_j / |s|``, half of it for i = j.
    """
    products = square_products(effect.evaluate(at), at.vector)
    *lead, _ = equations.magnitude_sd.shape
    return products.reshape(*lead, -1, products.shape[1])[..., equations.magnitude, :]


def square_products(columns: FloatArray, vector: FloatArray) -> FloatArray:
    """``F_i·F_j / |s|`` of columns F (n, 3, k) on vectors s (n, 3), half of it for i = j.

    Shape (n, k (k + 1) / 2), SI, for i ≤ j in the order of ``numpy.triu_indices``.
    """
    size = np.sqrt((vector**2).sum(axis=1))
    i, j = np.triu_indices(columns.shape[2])
    products = (columns[:, :, i] * columns[:, :, j]).sum(axis=1)
    share = np.where(size > 0, size, np.inf)[:, None] * np.where(i == j, 2.0, 1.0)
    return np.asarray(products / share)
