"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper``
(:mod:`calib.fit.angrisano`) walks the equations of Angrisano et al. in (alpha, b, k). Both end in
:func:`calib.fit.result.finish`, which judges whether the poses determine the model at all.

``scipy.optimize.least_squares`` on the same rows ends at the same minimum (to 4e-8) and takes seven
times as long, 4.5 against 0.66 ms with the covariance for 18 poses (``tests/bench/bench_fit``); a
diagnosis refits dozens of times, and many sensors will want these steps in batches.

Shape parameters (the time constant of a warm-up) are fitted by variable projection (Golub & Pereyra
1973, in Kaufman's form): everything else is fitted at each trial value, and the part of the
residual's derivative by the logarithm of the shape that the rest of the model cannot take up gives
the Gauss-Newton step. It begins at the most promising of the effect's starts. The uncertainty then
enters the covariance through the shape's own column.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from calib.effects.effect import Effect
from calib.errors import CalibrationError, FitFailed, Undetermined
from calib.fit.column_scaling import RANK_TOLERANCE, orthonormal_columns, unit_columns
from calib.fit.gauss_newton import minimise
from calib.fit.identifiability import require_enough, visible_basis
from calib.fit.model import Model
from calib.fit.residuals import Equations, WhitenedRows
from calib.fit.result import Fit, Solution, finish, with_common, with_shape_sd
from calib.fit.sensitive_axes import sensor_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

__all__ = ["Fit", "fit"]


SHAPE_STEPS = 40
SHAPE_HALVINGS = 8
LONGEST_SHAPE_STEP = 1.0
"""Of the logarithm: a factor of e."""

SHAPE_STEP_SD = 1e-4
"""Converged once the step moves no row by more than this part of its sd."""

DIFFERENCE_STEP = 1e-4
AT_BOUND = 1e-3
"""Relative distance within which a shape parameter is at its bound."""

MEMORY_ROUNDS = 30
MEMORY_SD = 1e-3
"""What a pose remembers of the one before is evaluated at an estimate of what that one felt, first
at the start, then at the solution, until no row moves by more than this part of its sd."""


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

    Returns
    -------
    Fit

    Raises
    ------
    Undetermined
        The poses do not determine the model; the message says which directions are missing.
    FitFailed
        The iteration did not converge.
    """
    best = _fit(Equations(poses, model), robust)
    if not any("previous" in effect.needs for effect in model.effects):
        return best
    latest = best
    for _ in range(MEMORY_ROUNDS):
        if memory_change(latest) < MEMORY_SD:
            return latest
        latest = _fit(Equations(poses, model, latest.sensed), robust)
        best = min(best, latest, key=lambda each: each.chi2)
    return best  # an axis near zero whose sign noise flips: the better of both


def memory_change(fit: Fit) -> float:
    """By how many sds a row moves if the poses before are taken from the solution."""
    equations = fit.equations
    effects = equations.on_sensor
    theta = fit.theta[equations.sensor_index]
    felt = [equations.at_start.previous, fit.poses.conditions(fit.rows.vector, fit.sensed).previous]
    at = equations.conditions(fit.rows.vector)
    before, after = (
        sensor_columns(effects, at.with_previous(each), fit.shapes, fit.rows.axes) for each in felt
    )
    moved = equations.whitened(((after - before) @ theta)[:, :, None], fit.rows.vector)
    return float(np.abs(moved).max())


def _fit(equations: Equations, robust: bool) -> Fit:
    model = equations.model
    start = equations.start.theta(model)
    if any(effect.in_square for effect in model.effects):
        return _fit_both_signs(equations, start, robust)
    return _fit_from(equations, start, robust)


def _fit_from(equations: Equations, start: FloatArray, robust: bool) -> Fit:
    basis = basis_at(equations, start)
    if any(effect.shape for effect in equations.model.effects):
        return fit_with_shapes(equations, start, basis, robust)
    require_enough(equations, basis.shape[1])
    return finish(equations, minimise(equations, start, {}, basis, robust), basis)


def _fit_both_signs(equations: Equations, start: FloatArray, robust: bool) -> Fit:
    """The better of two fits, from either sign of what the length shows squared only."""
    fits: list[Fit] = []
    refused: CalibrationError | None = None
    offset = square_start(equations, start)
    for sign in (1.0, -1.0):
        try:
            fits.append(_fit_from(equations, start + sign * offset, robust))
        except CalibrationError as error:
            refused = refused or error
    if not fits:
        assert refused is not None
        raise refused
    return min(fits, key=lambda each: each.chi2)


def basis_at(equations: Equations, theta: FloatArray) -> FloatArray:
    """The combinations of parameters that the poses can see, judged at ``theta``, (p, v)."""
    if len(equations.reading_index) == equations.model.size:
        return np.eye(equations.model.size)
    at_start = equations.rows(theta, np.zeros(equations.common.shape[1]), {})
    return visible_basis(equations, at_start)


def fit_with_shapes(
    equations: Equations, start: FloatArray, basis: FloatArray, robust: bool
) -> Fit:
    """Fit a model that has shape parameters; see :func:`fit` for errors.

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
        beginning = best

        def promise(values: tuple[float, ...]) -> float:
            shapes = dict(zip(shaped, values, strict=True))
            at = equations.rows(beginning.theta, beginning.eta, shapes)
            return float((_left(at, beginning.weight, basis, at.residual[:, None]) ** 2).sum())

        x = np.log(min((first, *others), key=promise))
        best = minimise(equations, best.theta, named(x), basis, robust)
    for _ in range(SHAPE_STEPS):
        slope = _left(best.rows, best.weight, basis, _shape_columns(equations, best, named(x)))
        step = np.linalg.lstsq(slope, -np.sqrt(best.weight) * best.rows.residual)[0]
        step = np.clip(x + np.clip(step, -LONGEST_SHAPE_STEP, LONGEST_SHAPE_STEP), low, high) - x
        if float(np.abs(slope @ step).max()) < SHAPE_STEP_SD:
            break
        for _ in range(SHAPE_HALVINGS):
            try:
                trial = minimise(equations, best.theta, named(x + step), basis, robust)
            except (FitFailed, Undetermined):
                step = step / 2
                continue
            if trial.cost < best.cost:
                break
            step = step / 2
        else:
            break
        x, best = x + step, trial
    return _with_shape_sd(finish(equations, best, basis, named(x)), best)


def _left(
    rows: WhitenedRows, weight: FloatArray, basis: FloatArray, columns: FloatArray
) -> FloatArray:
    """Weighted ``columns`` (r, k) less what the fitted parameters can take up."""
    root = np.sqrt(weight)[:, None]
    full = with_common(basis, rows.jacobian.shape[1] - len(basis))
    q = orthonormal_columns(rows.jacobian @ full * root)
    return np.asarray(columns * root - q @ (q.T @ (columns * root)))


def _shape_columns(equations: Equations, at: Solution, shapes: Mapping[str, float]) -> FloatArray:
    """Derivative of the residual by the logarithm of every shape parameter, (r, k)."""
    columns = []
    for name, value in shapes.items():
        up = equations.rows(at.theta, at.eta, {**shapes, name: value * (1 + DIFFERENCE_STEP)})
        down = equations.rows(at.theta, at.eta, {**shapes, name: value * (1 - DIFFERENCE_STEP)})
        columns.append((up.residual - down.residual) / (2 * DIFFERENCE_STEP))
    return np.stack(columns, axis=1)


def _with_shape_sd(fitted: Fit, solution: Solution) -> Fit:
    """The fit with its shape parameters as further unknowns of the covariance."""
    value = np.array(list(fitted.shapes.values()))
    columns = _shape_columns(fitted.equations, solution, fitted.shapes) / value
    shapes = [effect.shape for effect in fitted.model.effects if effect.shape]
    # At a bound the value is the bound's: nothing is known of it, and nothing else depends on it.
    held = [
        not low * (1 + AT_BOUND) < at < high * (1 - AT_BOUND)
        for at, (low, high) in zip(value, (shape.bounds for shape in shapes), strict=True)
    ]
    columns[:, held] = 0.0
    return with_shape_sd(fitted, columns)


def square_start(equations: Equations, theta: FloatArray) -> FloatArray:
    """Where to start parameters whose derivative vanishes at zero, else 0, (p,); either sign.

    The length feels a transverse error ``F r`` by ``|F r|² / 2|s|``, which is linear in the matrix
    ``r rᵀ``. That is fitted together with the model; its largest eigenvector is r, up to the sign.
    """
    start = np.zeros(equations.model.size)
    rows = equations.rows(theta, np.zeros(equations.common.shape[1]), {})
    at = equations.conditions(rows.vector)
    for effect in equations.model.effects:
        if not effect.in_square:
            continue
        columns = square_columns(equations, effect, at)
        whitened = np.zeros((len(rows.residual), columns.shape[1]))
        whitened[: len(equations.magnitude)] = columns / equations.magnitude_sd[:, None]
        where = equations.model.slices()[effect.name]
        others = np.delete(rows.jacobian, where, axis=1)
        unit, norm = unit_columns(np.hstack([whitened, others]))
        solution = np.linalg.lstsq(unit, rows.residual, rcond=RANK_TOLERANCE)[0] / norm
        k = len(effect.parameters)
        square = np.zeros((k, k))
        square[np.triu_indices(k)] = solution[: columns.shape[1]]
        values, vectors = np.linalg.eigh((square + square.T) / 2)
        start[where] = np.sqrt(np.abs(values[-1])) * vectors[:, -1]
    return start


def square_columns(equations: Equations, effect: Effect, at: Conditions) -> FloatArray:
    """Errors of the magnitude rows, SI, by the products r_i r_j of an effect's parameters.

    Parameters
    ----------
    equations : Equations
    effect : Effect
        Whose signal in a length begins with the square of its k parameters (``in_square``).
    at : Conditions
        Of the n poses, with the corrected vectors.

    Returns
    -------
    array, shape (rows, k (k + 1) / 2)
        For i ≤ j in the order of ``numpy.triu_indices``: ``F_i·F_j / |s|``, half of it for i = j.
    """
    chosen = equations.magnitude
    columns = effect.evaluate(at)[chosen]
    size = np.linalg.norm(at.vector[chosen], axis=1)
    i, j = np.triu_indices(columns.shape[2])
    products = (columns[:, :, i] * columns[:, :, j]).sum(axis=1)
    return np.asarray(products / size[:, None] / np.where(i == j, 2.0, 1.0))
