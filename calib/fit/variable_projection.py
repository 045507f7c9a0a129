"""Fit of effects whose columns hold a nonlinear shape parameter (the warm-up time constant).

Variable projection (Golub & Pereyra 1973, in Kaufman's form): everything else is fitted at each
trial value, and the part of the residual's derivative by the logarithm of the shape that the rest
of the model cannot take up gives the Gauss-Newton step. It begins at the most promising of the
effect's starts. The uncertainty then enters the covariance through the shape's own column.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from calib.errors import FitFailed, Undetermined
from calib.fit.gauss_newton import minimise, with_common
from calib.fit.identifiability import require_enough
from calib.fit.leave_one_out import orthonormal_columns
from calib.fit.residuals import Equations, Rows
from calib.fit.result import Fit, finish, with_shape_sd
from calib.poses.imu_log import FloatArray

STEPS = 40
HALVINGS = 8
LONGEST_STEP = 1.0
"""Of the logarithm: a factor of e."""

STEP_SD = 1e-4
"""Converged once the step moves no row by more than this part of its sd."""

DIFFERENCE_STEP = 1e-4


def fit_with_shapes(
    equations: Equations, start: FloatArray, basis: FloatArray, robust: bool
) -> Fit:
    """Fit a model that has shape parameters; see :func:`calib.fit.solver.fit` for errors.

    ``start`` (p,) are the linear parameters to start from, ``basis`` (p, v) what the poses see.
    """
    shaped = {effect.name: effect.shape for effect in equations.model.effects if effect.shape}
    require_enough(equations, basis.shape[1] + len(shaped))
    low, high = np.log([shape.bounds for shape in shaped.values()]).T

    def named(log_shape: FloatArray) -> dict[str, float]:
        return dict(zip(shaped, map(float, np.exp(log_shape)), strict=True))

    first, *others = product(*(shape.starts for shape in shaped.values()))
    x = np.log(first)
    best = minimise(equations, start, named(x), basis, robust)
    if others:
        theta, eta, _, weight, _ = best

        def promise(values: tuple[float, ...]) -> float:
            at = equations.rows(theta, eta, dict(zip(shaped, values, strict=True)))
            return float((_left(at, weight, basis, at.residual[:, None]) ** 2).sum())

        x = np.log(min((first, *others), key=promise))
        best = minimise(equations, theta, named(x), basis, robust)
    for _ in range(STEPS):
        theta, eta, rows, weight, _ = best
        slope = _left(rows, weight, basis, _shape_columns(equations, theta, eta, named(x)))
        step = np.linalg.lstsq(slope, -np.sqrt(weight) * rows.residual)[0]
        step = np.clip(x + np.clip(step, -LONGEST_STEP, LONGEST_STEP), low, high) - x
        if float(np.abs(slope @ step).max()) < STEP_SD:
            break
        cost = float(weight @ rows.residual**2)
        for _ in range(HALVINGS):
            try:
                trial = minimise(equations, theta, named(x + step), basis, robust)
            except (FitFailed, Undetermined):
                step = step / 2
                continue
            if float(trial[3] @ trial[2].residual ** 2) < cost:
                break
            step = step / 2
        else:
            break
        x, best = x + step, trial
    theta, eta, rows, weight, iterations = best
    found = finish(equations, theta, eta, rows, weight, basis, iterations, named(x))
    return _widen(found)


def _left(rows: Rows, weight: FloatArray, basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Weighted ``columns`` (r, k) less what the fitted parameters can take up."""
    root = np.sqrt(weight)[:, None]
    full = with_common(basis, rows.jacobian.shape[1] - len(basis))
    q = orthonormal_columns(rows.jacobian @ full * root)
    return np.asarray(columns * root - q @ (q.T @ (columns * root)))


def _shape_columns(
    equations: Equations, theta: FloatArray, eta: FloatArray, shapes: Mapping[str, float]
) -> FloatArray:
    """Derivative of the residual by the logarithm of every shape parameter, (r, k)."""
    columns = []
    for name, value in shapes.items():
        up = equations.rows(theta, eta, {**shapes, name: value * (1 + DIFFERENCE_STEP)})
        down = equations.rows(theta, eta, {**shapes, name: value * (1 - DIFFERENCE_STEP)})
        columns.append((up.residual - down.residual) / (2 * DIFFERENCE_STEP))
    return np.stack(columns, axis=1)


def _widen(found: Fit) -> Fit:
    """Covariance with the shape parameters as further unknowns."""
    equations, root = found.equations, np.sqrt(found.weight)
    value = np.array(list(found.shapes.values()))
    columns = _shape_columns(equations, found.theta, found.eta, found.shapes) / value
    full = with_common(found.basis, len(found.eta))
    jacobian = np.column_stack([found.rows.jacobian @ full, columns]) * root[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    cov = inverse @ inverse.T
    p, fitted = equations.model.size, full.shape[1]
    sd = np.sqrt(np.diag(cov)[fitted:])
    linear = (full @ cov[:fitted, :fitted] @ full.T)[:p, :p]
    return with_shape_sd(found, linear, dict(zip(found.shapes, map(float, sd), strict=True)))
