"""Fit of effects whose columns hold a nonlinear shape parameter (the warm-up time constant).

The shape is found by profile: for each trial value everything else is fitted, and a golden-section
search on its logarithm follows the chi-square down from the best of the effect's starts. Its
uncertainty then enters the covariance through its own column.
"""

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from calib.equations import Equations
from calib.errors import FitFailed, Undetermined
from calib.fit import Fit, finish, with_shape_sd
from calib.gauss_newton import minimise, with_common
from calib.identifiability import require_enough
from calib.imu_log import FloatArray

GOLDEN = (math.sqrt(5) - 1) / 2
LOG_TOLERANCE = 1e-4
DIFFERENCE_STEP = 1e-4


def minimise_log(cost: Callable[[float], float], low: float, high: float) -> float:
    """The minimum of a unimodal ``cost`` over ``low`` .. ``high`` (> 0), by golden section."""
    a, b = math.log(low), math.log(high)
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    at_c, at_d = cost(math.exp(c)), cost(math.exp(d))
    while b - a > LOG_TOLERANCE:
        if at_c < at_d:
            b, d, at_d = d, c, at_c
            c = b - GOLDEN * (b - a)
            at_c = cost(math.exp(c))
        else:
            a, c, at_c = c, d, at_d
            d = a + GOLDEN * (b - a)
            at_d = cost(math.exp(d))
    return math.exp((a + b) / 2)


def fit_with_shapes(
    equations: Equations, start: FloatArray, basis: FloatArray, robust: bool
) -> Fit:
    """Fit a model that has shape parameters; see :func:`calib.solver.fit` for errors.

    ``start`` (p,) are the linear parameters to start from, ``basis`` (p, v) what the poses see.
    """
    shapes = {e.name: e.shape.starts[0] for e in equations.model.effects if e.shape}
    require_enough(equations, basis.shape[1] + len(shapes))

    def chi2_at(name: str, value: float) -> float:
        try:
            _, _, rows, weight, _ = minimise(
                equations, start, {**shapes, name: value}, basis, robust
            )
        except (FitFailed, Undetermined):
            return math.inf
        return float(weight @ rows.residual**2)

    for effect in equations.model.effects:
        if effect.shape is None:
            continue
        name = effect.name
        tried = sorted(effect.shape.starts)
        costs = [chi2_at(name, value) for value in tried]
        best = int(np.argmin(costs))
        low = tried[best - 1] if best > 0 else effect.shape.bounds[0]
        high = tried[best + 1] if best + 1 < len(tried) else effect.shape.bounds[1]
        shapes[name] = minimise_log(partial(chi2_at, name), low, high)
    theta, eta, rows, weight, iterations = minimise(equations, start, shapes, basis, robust)
    found = finish(equations, theta, eta, rows, weight, basis, iterations, shapes)
    return _widen(found)


def _widen(found: Fit) -> Fit:
    """Covariance with the shape parameters as further unknowns."""
    equations, root = found.equations, np.sqrt(found.weight)
    columns = []
    for name, value in found.shapes.items():
        step = DIFFERENCE_STEP * value
        up = equations.rows(found.theta, found.eta, {**found.shapes, name: value + step})
        down = equations.rows(found.theta, found.eta, {**found.shapes, name: value - step})
        columns.append((up.residual - down.residual) / (2 * step))
    full = with_common(found.basis, len(found.eta))
    jacobian = np.column_stack([found.rows.jacobian @ full, *columns]) * root[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    cov = inverse @ inverse.T
    p, fitted = equations.model.size, full.shape[1]
    sd = np.sqrt(np.diag(cov)[fitted:])
    linear = (full @ cov[:fitted, :fitted] @ full.T)[:p, :p]
    return with_shape_sd(found, linear, dict(zip(found.shapes, map(float, sd), strict=True)))
