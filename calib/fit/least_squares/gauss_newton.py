"""The one minimiser: Gauss-Newton with the exact Jacobian over everything that is unknown.

``theta`` runs along the combinations of parameters that the poses can see, ``eta``, the common
errors, freely, and every shape parameter by its logarithm l within its bounds. A step eliminates
what is linear, or nearly so, by the QR decomposition of its scaled columns, J = QR, and solves

    (r_llᵀ r_l + Σ w r r_ll - PᵀP) dl = -(r_lᵀ r - Pᵀ Qᵀ r),     P = Qᵀ r_l + R⁻ᵀ Σ w r r_l,theta

for the shapes: Newton's step, since a shape bends the rows by as much as their residual; where its
matrix is not positive, that of Gauss and Newton, without the sums (Kaufman's form of the variable
projection of Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973). A step is halved while the cost
rises. The robust loss (Huber) reweights the rows until the weights are steady.

``scipy.optimize.least_squares`` with the same rows, Jacobian, starts and tolerances ends at the
same minima. For those of a diagnosis it takes 1.1 to 4 times as long, the most where a shape is
free (``python -m tests.bench.bench_diagnose``). Many sensors at once: :mod:`calib.fit.batch`.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import TypeVar

import numpy as np

from calib.effects.effect import Shape
from calib.errors import FitFailed
from calib.fit.column_scaling import RANK_TOLERANCE, unit_columns
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray

HALVINGS = 12  #: numerical limit: down to 1/4096 of a step
LONGEST_SHAPE_STEP = 1.0
"""Of the logarithm: a factor of e. Numerical."""

HUBER_SD = 1.5
"""Rows count in full up to here; beyond, their pull stays what it is here. At 1.5 the estimate is
3.6 % less efficient than least squares on pure noise. A judgement."""

ROBUST_ROUNDS = 30  #: numerical limit
STEADY_WEIGHT = 1e-6  #: largest change of a weight when the loss has settled; numerical


def minimise(problem: Problem, start: Estimate, precision: Precision = EXACT) -> Solution:
    """The minimum of ``problem`` next to ``start``.

    Parameters
    ----------
    problem : Problem
    start : Estimate
    precision : Precision

    Returns
    -------
    Solution
        Whether it converged is for the caller to judge.
    """
    solution = _descend(problem, start, problem.weight, precision)
    if not problem.robust:
        return solution
    iterations = solution.iterations
    for _ in range(ROBUST_ROUNDS):
        weight = problem.weight * huber_weight(solution.at.rows.residual)
        weight[problem.equations.data_count :] = 1.0
        change = float(np.abs(weight - solution.weight).max())
        solution = _descend(problem, solution.at, weight, precision)
        iterations += solution.iterations
        if change < STEADY_WEIGHT:
            break
    return replace(solution, iterations=iterations)


Cost = TypeVar("Cost", float, FloatArray)


def highest_cost(cost: Cost) -> Cost:
    """The largest sum of squares, of one set or of S, that is no rise from ``cost`` but rounding.
    """
    return cost * (1 + 1e-10) + 1e-12


def huber_weight(residual: FloatArray) -> FloatArray:
    """Weights of Huber's loss for residuals (r,) in sds: beyond ``HUBER_SD`` as 1/|residual|."""
    return np.asarray(np.minimum(1.0, HUBER_SD / np.maximum(np.abs(residual), NO_LENGTH)))


def _descend(
    problem: Problem, start: Estimate, weight: FloatArray, precision: Precision
) -> Solution:
    """Steps to the minimum, each halved while the cost rises."""
    at, cost, moved = start, start.cost(weight), np.inf
    for iteration in range(1, precision.steps + 1):
        step, row_step = step_from(problem, at, weight)
        if float(np.abs(row_step).max()) < precision.idle_sd:
            return Solution(at, weight, iteration, 0.0)
        share, trial = _longest_that_falls(problem, at, step, weight, cost)
        moved = share * float(np.abs(row_step).max())
        if trial is None:
            return Solution(at, weight, iteration, moved)
        at, cost = trial, trial.cost(weight)
        if moved < precision.step_sd:
            return Solution(at, weight, iteration, moved)
    return Solution(at, weight, precision.steps, moved)


def _longest_that_falls(
    problem: Problem, at: Estimate, step: FloatArray, weight: FloatArray, cost: float
) -> tuple[float, Estimate | None]:
    """The estimate after the largest of 1, 1/2, 1/4 ... of ``step`` that the cost does not rise by.

    None where it rises by all of them.
    """
    share = 1.0
    for _ in range(HALVINGS):
        for trial in _trials(problem, at, share * step, weight):
            if trial.cost(weight) <= highest_cost(cost):
                return share, trial
        share /= 2
    return share, None


def _trials(
    problem: Problem, at: Estimate, step: FloatArray, weight: FloatArray
) -> Iterator[Estimate]:
    """The estimate one ``step`` on; then that with its shapes, and everything else fitted to them.

    Shapes can lie in a valley so curved that a straight step leaves it. Where no true vectors
    belong to an estimate, a shorter step has some.
    """
    p = len(at.theta) + len(at.eta)
    shapes = dict(at.shapes)
    for name, change in zip(problem.free, step[p:], strict=True):
        shapes[name] = float(shapes[name] * np.exp(change))
    with suppress(FitFailed):
        yield _moved(problem, at, step[:p], shapes)
    if problem.free:
        with suppress(FitFailed):
            beside = _moved(problem, at, np.zeros(p), shapes)
            linear, _ = step_from(problem.with_shapes_held(), beside, weight)
            yield _moved(problem, beside, linear, shapes)


def _moved(
    problem: Problem, at: Estimate, linear: FloatArray, shapes: Mapping[str, float]
) -> Estimate:
    """The estimate with theta and eta one step (p + q,) on, at these shapes."""
    p = len(at.theta)
    return Estimate.of(problem.equations, at.theta + linear[:p], at.eta + linear[p:], shapes)


def step_from(
    problem: Problem, at: Estimate, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The step from an estimate.

    Parameters
    ----------
    problem : Problem
        With h free shape parameters.
    at : Estimate
    weight : array, shape (r,)

    Returns
    -------
    step : array, shape (p + q + h,)
        Of theta (SI), eta (in sds) and the logarithms of the shapes, these at most
        ``LONGEST_SHAPE_STEP`` and within their bounds, everything else solved for the step that
        they are left.
    row_step : array, shape (r,)
        What it moves the rows by to first order, sds.
    """
    root = np.sqrt(weight)
    linear = at.rows.jacobian @ problem.directions
    unit, norm = unit_columns(linear * root[:, None])
    q, r = np.linalg.qr(unit)
    onto = q.T @ (at.rows.residual * root)
    row_step, shape_step = np.zeros(len(root)), np.zeros(0)
    if problem.free:
        slope, shape_step, coupling = _shape_step(problem, at, weight, (q, r, norm))
        onto = onto + coupling @ shape_step
        row_step = slope @ shape_step
    solution = -_solved(r, onto) / norm
    step = np.concatenate([problem.directions @ solution, shape_step])
    return step, row_step + linear @ solution


def _shape_step(
    problem: Problem,
    at: Estimate,
    weight: FloatArray,
    decomposition: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slope of the rows (r, h), step (h,) of the shapes' logarithms, and P (v + q, h)."""
    q, r, norm = decomposition
    root = np.sqrt(weight)
    residual = at.rows.residual * root
    by_shape = at.shape_derivatives(problem)
    slope = by_shape.slope * root[:, None]
    pull = weight * at.rows.residual
    mixed = np.zeros((len(problem.directions), slope.shape[1]))
    mixed[: len(at.theta)] = np.einsum("r,rph->ph", pull, by_shape.mixed)
    coupling = q.T @ slope + _solved(r.T, problem.directions.T @ mixed / norm[:, None])
    matrix = slope.T @ slope + np.diag(pull @ by_shape.curvature) - coupling.T @ coupling
    if (np.linalg.eigvalsh(matrix) > 0).all():
        step = -np.linalg.solve(matrix, slope.T @ residual - coupling.T @ (q.T @ residual))
    else:
        coupling = q.T @ slope
        step = np.linalg.lstsq(slope - q @ coupling, -residual, rcond=RANK_TOLERANCE)[0]
    return by_shape.slope, within_bounds(problem.free, at.shapes, np.asarray(step, float)), coupling


def within_bounds(
    free: Mapping[str, Shape], values: Mapping[str, float | FloatArray], change: FloatArray
) -> FloatArray:
    """What of a change of the logarithms of the free shapes, which have no unit, is allowed.

    Parameters
    ----------
    free : mapping of effect name to Shape
        The h shape parameters that move.
    values : mapping of effect name to float, or to array, shape (S,)
        Where they stand, of one set or of S sets.
    change : array, shape (h,) or (S, h)

    Returns
    -------
    array, shape (h,) or (S, h)
        At most ``LONGEST_SHAPE_STEP``, within the bounds of each; no unit.
    """
    value = np.log(np.array([values[name] for name in free])).T
    low, high = np.log([shape.bounds for shape in free.values()]).T
    change = np.clip(change, -LONGEST_SHAPE_STEP, LONGEST_SHAPE_STEP)
    return np.asarray(np.clip(change, low - value, high - value))


def _solved(triangle: FloatArray, right: FloatArray) -> FloatArray:
    """Solution of ``triangle x = right``, the shortest where unit columns are dependent."""
    diagonal = np.abs(np.diag(triangle))
    if diagonal.min() > RANK_TOLERANCE * diagonal.max():
        return np.asarray(np.linalg.solve(triangle, right))
    return np.asarray(np.linalg.lstsq(triangle, right, rcond=RANK_TOLERANCE)[0])
