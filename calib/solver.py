"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper`` (:mod:`calib.paper`) walks
the equations of Angrisano et al. in (alpha, b, k). Both end in :func:`calib.fit.finish`, which
judges whether the poses determine the model at all.
"""

import numpy as np

from calib.equations import Equations
from calib.fit import Fit, finish
from calib.gauss_newton import minimise
from calib.identifiability import require_enough, visible_basis
from calib.imu_log import FloatArray
from calib.model import Model
from calib.poses import PoseSet
from calib.shapes import fit_with_shapes

__all__ = ["Fit", "fit"]


def fit(poses: PoseSet, model: Model, *, robust: bool = False) -> Fit:
    """Fit ``model`` to ``poses`` from the ellipsoid start.

    Parameters
    ----------
    poses : PoseSet
        All runs of the triad.
    model : Model
        Effects to fit jointly.
    robust : bool
        Huber's loss instead of plain squares, so that a few bad poses pull less.

    Raises
    ------
    Undetermined
        The poses do not determine the model; the message says which directions are missing.
    FitFailed
        The iteration did not converge.
    """
    equations = Equations(poses, model)
    start = equations.start.theta(model)
    basis = basis_at(equations, start)
    if any(effect.shape for effect in model.effects):
        return fit_with_shapes(equations, start, basis, robust)
    require_enough(equations, basis.shape[1])
    theta, eta, rows, weight, iterations = minimise(equations, start, {}, basis, robust)
    return finish(equations, theta, eta, rows, weight, basis, iterations)


def basis_at(equations: Equations, theta: FloatArray) -> FloatArray:
    """The combinations of parameters that the poses can see, judged at ``theta``, (p, v)."""
    if len(equations.reading_index) == equations.model.size:
        return np.eye(equations.model.size)
    at_start = equations.rows(theta, np.zeros(equations.common.shape[1]), {})
    return visible_basis(equations, at_start)
