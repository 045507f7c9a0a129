"""The one minimiser: Gauss-Newton with the exact Jacobian over all unknowns.

``theta`` runs along the combinations of parameters that the poses can see, ``eta``, the common
errors, freely, and every shape parameter by its logarithm l within its bounds. A step eliminates
what is linear, or nearly so, by the QR decomposition of its scaled columns, J = QR, and solves

    (r_llᵀ r_l + Σ w r r_ll - PᵀP) dl = -(r_lᵀ r - Pᵀ Qᵀ r),     P = Qᵀ r_l + R⁻ᵀ Σ w r r_l,theta

for the shapes: Newton's step, since a shape bends the rows by as much as their residual; where its
matrix is not positive, that of Gauss and Newton, without the sums (Kaufman's form of the variable
projection of Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973). A step is halved while the cost
rises. The robust loss (Huber) reweights the rows until the weights are steady.

``scipy.optimize.least_squares`` with the same rows, Jacobian, starts and tolerances ends at the
same minima. For those of a diagnosis it takes 1 to 3.2 times as long, the most where a shape is
free (``python -m tests.bench.bench_diagnose``). All S sets of a stack go side by side, each until
it rests.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from calib.effects.effect import Shape
from calib.fit.linear import RANK_TOLERANCE, times, triangle_solutions, unit_columns
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray

HALVINGS = 12  #: numerical limit: down to 1/4096 of a step
LONGEST_SHAPE_STEP = 1.0
"""Longest step of a logarithm: a factor of e. Numerical."""

HUBER_SD = 1.5
"""Residual up to which rows count in full; beyond, their influence stays constant. At 1.5 the
estimate is 3.6 % less efficient than least squares on pure noise. A judgement."""

ROBUST_ROUNDS = 30  #: numerical limit
STEADY_WEIGHT = 1e-6  #: largest change of a weight when the loss has settled; numerical


def minimise(problem: Problem, start: Estimate, precision: Precision = EXACT) -> Solution:
    """The minimum of ``problem`` next to ``start``, for each of its S sets.

    Returns
    -------
    Solution
        Whether it converged is for the caller to judge.
    """
    solution = _descend(problem, start, precision)
    if not problem.robust:
        return solution
    going, weight = np.arange(len(solution.iterations)), problem.weight
    for _ in range(ROBUST_ROUNDS):
        part, latest = problem.take(going), solution.take(going)
        weight = part.weight * huber_weight(latest.at.rows.residual)
        weight[:, problem.equations.data_count :] = 1.0
        change = np.abs(weight - latest.weight).max(axis=1)
        again = _descend(replace(part, weight=weight), latest.at, precision)
        again = replace(again, iterations=latest.iterations + again.iterations)
        solution = solution.with_sets(going, again)
        going = going[change >= STEADY_WEIGHT]
        if not going.size:
            break
    return solution


def huber_weight(residual: FloatArray) -> FloatArray:
    """Weights of Huber's loss for residuals (..., r) in sds: beyond ``HUBER_SD`` 1/|residual|."""
    return np.asarray(np.minimum(1.0, HUBER_SD / np.maximum(np.abs(residual), NO_LENGTH)))


def _descend(problem: Problem, start: Estimate, precision: Precision) -> Solution:
    """Steps to the minimum of each set, halved while its cost rises."""
    sets = len(start.theta)
    solution = Solution(start, problem.weight, np.full(sets, precision.steps),
                        np.full(sets, np.inf))
    going, part, at = np.arange(sets), problem, start
    for iteration in range(1, precision.steps + 1):
        step, row_step = step_from(part, at)
        largest = np.abs(row_step).max(axis=1)
        rests = largest < precision.idle_sd
        moved, falls = np.zeros(len(going)), np.zeros(len(going), dtype=bool)
        if not rests.all():
            trial, share, falls = _longest_that_falls(part, at, step)
            moved, falls = np.where(rests, 0.0, share * largest), falls & ~rests
            down = np.flatnonzero(falls)
            at = trial if falls.all() else at.with_sets(down, trial.take(down))
        ends = ~falls | (moved < precision.step_sd)
        iterations = np.where(ends, iteration, precision.steps)
        latest = Solution(at, part.weight, iterations, moved)
        solution = latest if len(going) == sets else solution.with_sets(going, latest)
        if ends.all():
            break
        if ends.any():
            on = np.flatnonzero(~ends)
            going, part, at = going[on], part.take(on), at.take(on)
    return solution


def _longest_that_falls(
    problem: Problem, at: Estimate, step: FloatArray
) -> tuple[Estimate, FloatArray, BoolArray]:
    """The estimates after the largest of 1, 1/2, 1/4 ... of each ``step`` by which no cost rises.

    With these shares (S,), and whether there is one.
    """
    trial, falls = _trial(problem, at, step)
    share = np.ones(len(step))
    for _ in range(HALVINGS):
        on = np.flatnonzero(~falls)
        if not on.size:
            break
        share[on] /= 2
        if share[on[0]] <= 2.0**-HALVINGS:
            break
        part, falls[on] = _trial(problem.take(on), at.take(on), share[on, None] * step[on])
        trial = trial.with_sets(on, part)
    return trial, share, falls


def _trial(problem: Problem, at: Estimate, step: FloatArray) -> tuple[Estimate, BoolArray]:
    """The estimates one ``step`` on, and which of them cost no more (S,).

    Where one costs more, its shapes are kept and everything else is fitted to them: shapes can lie
    in a valley so curved that a straight step leaves it.
    """
    most = at.cost(problem.weight) * (1 + 1e-10) + 1e-12  # up to which it is rounding
    p = at.theta.shape[1] + at.eta.shape[1]
    shapes = {name: value * np.exp(change) for (name, value), change in
              zip(((name, at.shapes[name]) for name in problem.free), step[:, p:].T, strict=True)}
    shapes = {**at.shapes, **shapes}
    trial = _moved(problem, at, step[:, :p], shapes)
    falls = trial.cost(problem.weight) <= most
    if not problem.free or falls.all():
        return trial, falls
    off = np.flatnonzero(~falls)
    stretched = {name: value[off] for name, value in shapes.items()}
    part = problem.take(off)
    beside = _moved(part, at.take(off), np.zeros((len(off), p)), stretched)
    solved = np.flatnonzero(beside.rows.is_solved)
    if solved.size:
        off, part, beside = off[solved], part.take(solved), beside.take(solved)
        linear, _ = step_from(part.with_shapes_held(), beside)
        second = _moved(part, beside, linear, beside.shapes)
        better = np.flatnonzero(second.cost(part.weight) <= most[off])
        trial = trial.with_sets(off[better], second.take(better))
        falls[off[better]] = True
    return trial, falls


def _moved(
    problem: Problem, at: Estimate, linear: FloatArray, shapes: Mapping[str, FloatArray]
) -> Estimate:
    """The estimates with theta and eta one step (S, p + q) on, at these shapes."""
    p = at.theta.shape[1]
    return Estimate.of(problem.equations, at.theta + linear[:, :p], at.eta + linear[:, p:], shapes)


def step_from(problem: Problem, at: Estimate) -> tuple[FloatArray, FloatArray]:
    """The step from an estimate.

    Parameters
    ----------
    problem : Problem
        Of S sets with h free shape parameters.
    at : Estimate

    Returns
    -------
    step : array, shape (S, p + q + h)
        Of theta (SI), eta (in sds) and the logarithms of the shapes, these at most
        ``LONGEST_SHAPE_STEP`` and within their bounds, everything else solved for the step that
        they are left.
    row_step : array, shape (S, r)
        What it moves the rows by to first order, sds.
    """
    root = np.sqrt(problem.weight)
    linear = at.rows.jacobian @ problem.directions
    unit, norm = unit_columns(linear * root[..., None])
    q, r = np.linalg.qr(unit)
    onto = times(q.swapaxes(1, 2), at.rows.residual * root)
    row_step, shape_step = np.zeros_like(root), np.zeros((len(root), 0))
    if problem.free:
        slope, shape_step, coupling = _shape_step(problem, at, (q, r, norm))
        onto = onto + times(coupling, shape_step)
        row_step = times(slope, shape_step)
    solution = -triangle_solutions(r, onto[..., None])[..., 0] / norm
    step = np.concatenate([times(problem.directions, solution), shape_step], axis=1)
    return step, row_step + times(linear, solution)


def _shape_step(
    problem: Problem, at: Estimate, decomposition: tuple[FloatArray, FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slope of the rows (S, r, h), step (S, h) of the shapes' logarithms, and P (S, v + q, h)."""
    q, r, norm = decomposition
    root = np.sqrt(problem.weight)
    residual = at.rows.residual * root
    by_shape = at.shape_derivatives(problem.equations, problem.free)
    slope = by_shape.slope * root[..., None]
    pull = problem.weight * at.rows.residual
    mixed = np.zeros((*problem.directions.shape[:2], slope.shape[2]))
    mixed[:, : at.theta.shape[1]] = np.einsum("sr,srph->sph", pull, by_shape.mixed)
    along = problem.directions.swapaxes(1, 2) @ mixed / norm[..., None]
    onto, transposed = q.swapaxes(1, 2) @ slope, slope.swapaxes(1, 2)
    coupling = onto + triangle_solutions(r.swapaxes(1, 2), along)
    curved = np.einsum("sr,srh->sh", pull, by_shape.curvature)[..., None] * np.eye(slope.shape[2])
    matrix = transposed @ slope + curved - coupling.swapaxes(1, 2) @ coupling
    projected = times(q.swapaxes(1, 2), residual)
    newton = (np.linalg.eigvalsh(matrix) > 0).all(axis=1)
    step = np.empty((len(root), slope.shape[2]))
    if newton.any():
        full = times(transposed, residual) - times(coupling.swapaxes(1, 2), projected)
        step[newton] = -np.linalg.solve(matrix[newton], full[newton][..., None])[..., 0]
    for i in np.flatnonzero(~newton):
        coupling[i] = onto[i]
        step[i] = np.linalg.lstsq(slope[i] - q[i] @ onto[i], -residual[i], rcond=RANK_TOLERANCE)[0]
    return by_shape.slope, _within_bounds(problem.free, at.shapes, step), coupling


def _within_bounds(
    free: Mapping[str, Shape], values: Mapping[str, FloatArray], change: FloatArray
) -> FloatArray:
    """The allowed part of a change (S, h) of the logarithms of the free shapes, no unit.

    At most ``LONGEST_SHAPE_STEP``, within the bounds of each; ``values`` (S,) are the current ones.
    """
    value = np.log(np.array([values[name] for name in free])).T
    low, high = np.log([shape.bounds for shape in free.values()]).T
    change = np.clip(change, -LONGEST_SHAPE_STEP, LONGEST_SHAPE_STEP)
    return np.asarray(np.clip(change, low - value, high - value))
