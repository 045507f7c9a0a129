"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper``
(:mod:`calib.fit.angrisano`) walks the equations of Angrisano et al. in (alpha, b, k). Both end in
:func:`calib.fit.result.finish`, which judges whether the poses determine the model at all.

One step solves the column-scaled rows by QR; it is halved while the cost rises. The combinations of
parameters that the poses cannot see stay where they are: steps run along ``basis``. The robust
loss reweights the rows until the weights are steady.

Shape parameters (the time constant of a warm-up) are fitted by variable projection (Golub & Pereyra
1973, in Kaufman's form): everything else is fitted at each trial value, and the part of the
residual's derivative by the logarithm of the shape that the rest of the model cannot take up gives
the Gauss-Newton step. It begins at the most promising of the effect's starts. The uncertainty then
enters the covariance through the shape's own column.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from calib.errors import FitFailed, Undetermined
from calib.fit.column_scaling import orthonormal_columns, pseudo_inverse, unit_columns
from calib.fit.identifiability import require_determined, require_enough, visible_basis
from calib.fit.model import Model
from calib.fit.residuals import Equations, Rows
from calib.fit.result import Fit, finish, with_common, with_shape_sd
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

ITERATIONS = 60
STEP_SD = 1e-7
"""Converged once no parameter moves by more than this part of its own sd; Gauss-Newton then is
closer to the minimum by another factor of the relative residual, below 1e-9 in every parameter."""
HALVINGS = 12
HUBER_SD = 1.5
ROBUST_ROUNDS = 30

SHAPE_STEPS = 40
SHAPE_HALVINGS = 8
LONGEST_SHAPE_STEP = 1.0
"""Of the logarithm: a factor of e."""
SHAPE_STEP_SD = 1e-4
"""Converged once the step moves no row by more than this part of its sd."""
DIFFERENCE_STEP = 1e-4

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


def minimise(
    equations: Equations,
    theta: FloatArray,
    shapes: Mapping[str, float],
    basis: FloatArray,
    robust: bool,
) -> tuple[FloatArray, FloatArray, Rows, FloatArray, int]:
    """The minimum at given shape parameters; reweighted until steady with the robust loss."""
    eta = np.zeros(equations.common.shape[1])
    weight = np.ones(equations.data_count + len(eta))
    theta, eta, rows, iterations = iterate(equations, theta, eta, shapes, weight, basis)
    if robust:
        for _ in range(ROBUST_ROUNDS):
            new = huber_weight(rows.residual)
            new[equations.data_count :] = 1.0
            change = float(np.abs(new - weight).max())
            weight = new
            theta, eta, rows, more = iterate(equations, theta, eta, shapes, weight, basis)
            iterations += more
            if change < 1e-6:
                break
    return theta, eta, rows, weight, iterations


def iterate(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Mapping[str, float],
    weight: FloatArray,
    basis: FloatArray,
) -> tuple[FloatArray, FloatArray, Rows, int]:
    """Gauss-Newton with step halving from ``theta``, ``eta`` to the minimum along ``basis``.

    Raises
    ------
    FitFailed
        Not converged within ``ITERATIONS``, or no finite value was left.
    Undetermined
        The same, because the poses do not determine the model.
    """
    p = equations.model.size
    parameters, basis = basis, with_common(basis, len(eta))
    rows = equations.rows(theta, eta, shapes)
    cost = float(weight @ rows.residual**2)
    for iteration in range(1, ITERATIONS + 1):
        step = step_of(rows, weight, basis)
        for _ in range(HALVINGS):
            try:
                trial = equations.rows(theta + step[:p], eta + step[p:], shapes)
                trial_cost = float(weight @ trial.residual**2)
            except FitFailed:
                trial_cost = np.inf
            if trial_cost <= cost * (1 + 1e-10) + 1e-12:
                break
            step = step / 2
        else:
            break
        theta, eta, rows, cost = theta + step[:p], eta + step[p:], trial, trial_cost
        if float(np.abs(rows.jacobian @ step).max()) < STEP_SD:
            return theta, eta, rows, iteration
    if np.isfinite(cost) and float(np.abs(rows.jacobian @ step).max()) < 1e-3:
        return theta, eta, rows, iteration
    require_determined(equations, rows, parameters)
    raise FitFailed(
        f"the fit of the {equations.poses.triad} did not converge in {ITERATIONS} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check sensor.{equations.poses.triad}."
    )


def step_of(rows: Rows, weight: FloatArray, basis: FloatArray) -> FloatArray:
    """Gauss-Newton step for theta and eta along ``basis``, column-scaled, by QR."""
    root = np.sqrt(weight)
    jacobian = (rows.jacobian @ basis) * root[:, None]
    unit, scale = unit_columns(jacobian)
    q, r = np.linalg.qr(unit)
    diagonal = np.abs(np.diag(r))
    if diagonal.min() < 1e-12 * diagonal.max():
        # Singular here; require_determined says so in words once the iteration has ended.
        step = np.linalg.lstsq(unit, -rows.residual * root, rcond=1e-10)[0]
    else:
        step = np.linalg.solve(r, -(q.T @ (rows.residual * root)))
    return np.asarray(basis @ (step / scale))


def huber_weight(residual: FloatArray) -> FloatArray:
    """Weights of Huber's loss: rows beyond ``HUBER_SD`` count in proportion to 1/|residual|."""
    return np.asarray(np.minimum(1.0, HUBER_SD / np.maximum(np.abs(residual), 1e-300)))


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
    for _ in range(SHAPE_STEPS):
        theta, eta, rows, weight, _ = best
        slope = _left(rows, weight, basis, _shape_columns(equations, theta, eta, named(x)))
        step = np.linalg.lstsq(slope, -np.sqrt(weight) * rows.residual)[0]
        step = np.clip(x + np.clip(step, -LONGEST_SHAPE_STEP, LONGEST_SHAPE_STEP), low, high) - x
        if float(np.abs(slope @ step).max()) < SHAPE_STEP_SD:
            break
        cost = float(weight @ rows.residual**2)
        for _ in range(SHAPE_HALVINGS):
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
    inverse = pseudo_inverse(jacobian)
    cov = inverse @ inverse.T
    p, fitted = equations.model.size, full.shape[1]
    sd = np.sqrt(np.diag(cov)[fitted:])
    linear = (full @ cov[:fitted, :fitted] @ full.T)[:p, :p]
    return with_shape_sd(found, linear, dict(zip(found.shapes, map(float, sd), strict=True)))
