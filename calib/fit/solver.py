"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper``
(:mod:`calib.fit.angrisano`) walks the equations of Angrisano et al. in (alpha, b, k). Both end in
:func:`calib.fit.result.finish`, which judges whether the poses determine the model at all.
"""

import numpy as np

from calib.fit.gauss_newton import minimise
from calib.fit.identifiability import require_enough, visible_basis
from calib.fit.model import Model
from calib.fit.residuals import Equations
from calib.fit.result import Fit, finish
from calib.fit.variable_projection import fit_with_shapes
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

__all__ = ["Fit", "fit"]

MEMORY_ROUNDS = 3
"""What a pose remembers of the one before is a sign, judged at the start; it is judged again at the
solution, where readings near zero may have changed theirs."""


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
    found = _fit(Equations(poses, model), robust)
    for _ in range(MEMORY_ROUNDS):
        if remembers_alike(found):
            break
        found = _fit(Equations(poses, model, pushed=found.pushed), robust)
    return found


def remembers_alike(found: Fit) -> bool:
    """Whether at the solution every effect remembers the poses before as it did at the start."""
    equations = found.equations
    if not equations.on_sensor:
        return True
    before = equations.at_start
    after = found.poses.conditions(before.vector, found.pushed)
    return all(
        np.array_equal(effect.evaluate(before), effect.evaluate(after))
        for effect in equations.on_sensor
    )


def _fit(equations: Equations, robust: bool) -> Fit:
    model = equations.model
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
