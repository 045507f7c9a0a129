"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper``
(:mod:`calib.fit.least_squares.angrisano`) walks the equations of Angrisano et al. in (alpha, b, k).
Both end in :func:`calib.fit.least_squares.result.finish`, which judges whether the poses determine
the model at all.

A fit with more effects than one at hand (:func:`extend`) is the same problem from a warmer start.

Shape parameters (the time constant of a warm-up) are unknowns beside all others, from the most
promising of the effect's starts. What a pose remembers of the one before is evaluated at an
estimate of what the axes sensed in it, first at the start, then at the solution, until it is
steady.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import product

import numpy as np

from calib.effects.effect import Effect
from calib.errors import CalibrationError, FitFailed, Remedy
from calib.fit.column_scaling import orthonormal_columns
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.identifiability import (
    require_determined,
    require_enough,
    visible_basis,
)
from calib.fit.least_squares.result import Fit, finish
from calib.fit.least_squares.square_start import square_start
from calib.fit.model import Model
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

__all__ = ["Fit", "extend", "fit"]

MEMORY_ROUNDS = 30  #: numerical limit
MEMORY_SD = 1e-3
"""A memory is steady once no row moves by more than this part of its sd. Numerical."""

WEIGHING = Precision(30, step_sd=1e-2, idle_sd=1e-3)
"""Of a fit that is to be weighed against others: chi-square is then exact to 1e-4. Numerical."""

WEIGHING_MEMORY_ROUNDS = 5  #: a limit of time; numerical
ENOUGH_MISFIT = 2.0
"""Chi-square per degree of freedom above which a warm start tries the shapes' other starts.
A judgement."""


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
    Contradiction
        No gain fits all poses: their readings or references contradict each other.
    """
    equations = Equations(poses, model)
    theta = equations.start.theta(model)

    def cold(start: FloatArray) -> Fit:
        basis = basis_at(equations, start)
        problem = Problem.of(equations, basis, robust)
        require_enough(equations, basis.shape[1] + len(problem.free))
        return _converged(problem, _from_best_shapes(problem, start))

    def again(latest: Fit) -> Fit:
        after = latest.remembering
        problem = Problem.of(after, basis_at(after, theta), robust)
        at = Estimate.of(after, latest.theta, latest.eta, latest.shapes)
        start = _most_promising(problem, [at, *_at_starts(problem, at)], latest.weight)
        return _converged(problem, minimise(problem, start))

    squares = [effect for effect in model.effects if effect.in_square]
    first = _from_either_sign(cold, theta, square_start(equations, theta, squares))
    return _with_steady_memory(first, again, MEMORY_ROUNDS)


def extend(base: Fit, effects: Sequence[Effect]) -> Fit:
    """Fit the model of ``base`` and more effects, everything anew, from where it stood.

    Meant for weighing sets of effects: it goes as far as ``WEIGHING``, and the weights of a robust
    fit stay as they are.

    Parameters
    ----------
    base : Fit
    effects : sequence of Effect
        What to add, their shapes from the first of their starts on. None acts ``in_square``: where
        such a parameter is zero, its derivative is.

    Returns
    -------
    Fit

    Raises
    ------
    CalibrationError
        An effect is in the model already.
    Undetermined
        The poses do not determine the model with them.
    FitFailed
        The effects are larger than the readings, or the gains went to nothing.
    """
    model = base.model
    for effect in effects:
        model = model + effect
    starts = {e.name: e.shape.starts[0] for e in effects if e.shape is not None}
    shapes = {**base.shapes, **starts}
    theta = np.concatenate([base.theta, np.zeros(model.size - base.model.size)])
    first_sensed = base.remembering.extended(effects)

    def weighed(start: FloatArray) -> Fit:
        return _weighed(first_sensed, start, base.eta, shapes, base.weight)

    def again(latest: Fit) -> Fit:
        equations = latest.remembering
        return _weighed(equations, latest.theta, latest.eta, latest.shapes, base.weight)

    squares = [effect for effect in effects if effect.in_square]
    first = _from_either_sign(weighed, theta, square_start(first_sensed, theta, squares))
    return _with_steady_memory(first, again, WEIGHING_MEMORY_ROUNDS)


def _from_either_sign(
    fit_from: Callable[[FloatArray], Fit], theta: FloatArray, offset: FloatArray
) -> Fit:
    """The better of the fits from ``theta`` plus and minus ``offset``; one where that is zero."""
    if not offset.any():
        return fit_from(theta)
    fits: list[Fit] = []
    refused: CalibrationError | None = None
    for start in (theta + offset, theta - offset):
        try:
            fits.append(fit_from(start))
        except CalibrationError as error:
            refused = refused or error
    if not fits:
        assert refused is not None
        raise refused
    return min(fits, key=lambda each: each.chi2)


def _from_best_shapes(problem: Problem, theta: FloatArray) -> Solution:
    """From ``theta`` (p,) and the first of the shapes' starts; then from the most promising."""
    first = {name: shape.starts[0] for name, shape in problem.free.items()}
    eta = np.zeros(problem.equations.common.shape[1])
    start = Estimate.of(problem.equations, theta, eta, first)
    if not problem.free:
        return minimise(problem, start)
    held = minimise(problem.with_shapes_held(), start)
    starts = _at_starts(problem, held.at) or [held.at]
    return minimise(problem, _most_promising(problem, starts, held.weight))


def _weighed(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Mapping[str, float],
    weight: FloatArray,
) -> Fit:
    """The fit near a warm start, as far as ``WEIGHING``.

    Where the rows are not explained from there, the other starts of the shapes are tried.
    """
    at = Estimate.of(equations, theta, eta, shapes)
    basis = visible_basis(equations, at.rows, shapes)
    problem = replace(Problem.of(equations, basis), weight=weight)
    solution = minimise(problem, at, WEIGHING)
    dof = max(equations.data_count - basis.shape[1] - len(problem.free), 1)
    if problem.free and solution.cost > ENOUGH_MISFIT * dof:
        starts = _at_starts(problem, solution.at) or [solution.at]
        start = _most_promising(problem, starts, weight)
        solution = min(solution, minimise(problem, start, WEIGHING), key=lambda each: each.cost)
    return finish(problem, solution)


def _at_starts(problem: Problem, at: Estimate) -> list[Estimate]:
    """``at`` with every combination of the shapes' starts that has true vectors."""
    estimates = []
    for values in product(*(shape.starts for shape in problem.free.values())):
        shapes = {**at.shapes, **dict(zip(problem.free, values, strict=True))}
        with suppress(FitFailed):
            estimates.append(Estimate.of(problem.equations, at.theta, at.eta, shapes))
    return estimates


def _most_promising(
    problem: Problem, estimates: Sequence[Estimate], weight: FloatArray
) -> Estimate:
    """That of the estimates which leaves least when all but its shapes is fitted."""
    return min(estimates, key=lambda each: _linear_cost(problem, each, weight))


def _linear_cost(problem: Problem, at: Estimate, weight: FloatArray) -> float:
    """What the rows would leave at these shapes, everything else fitted to first order."""
    root = np.sqrt(weight)
    q = orthonormal_columns(at.rows.jacobian @ problem.directions * root[:, None])
    residual = at.rows.residual * root
    rest = residual - q @ (q.T @ residual)
    return float(rest @ rest)


def _converged(problem: Problem, solution: Solution) -> Fit:
    """The fit of a solution that came to rest; raises FitFailed or Undetermined of another."""
    if solution.is_converged:
        return finish(problem, solution)
    triad = problem.equations.poses.triad
    require_determined(problem.equations, solution.at.rows, problem.basis, solution.at.shapes)
    raise FitFailed(
        f"the fit of the {triad} did not converge in {EXACT.steps} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check the {triad}'s data sheet.",
        Remedy("data_sheet", triad),
    )


def _with_steady_memory(first: Fit, again: Callable[[Fit], Fit], rounds: int) -> Fit:
    """``first`` fitted ``again``, each time after what the axes sensed in the poses before."""
    if not any("previous" in effect.needs for effect in first.model.effects):
        return first
    best = latest = first
    for _ in range(rounds):
        if memory_change(latest) < MEMORY_SD:
            return latest
        latest = again(latest)
        best = min(best, latest, key=lambda each: each.chi2)
    return best  # an axis near zero whose sign noise flips: the better of both


def require_determinable(poses: PoseSet, model: Model) -> None:
    """Refuse poses that cannot determine ``model``, judged where the fit would start.

    Raises
    ------
    Undetermined
        Too few poses, none that turns, or combinations of parameters that they do not show.
    """
    equations = Equations(poses, model)
    theta = equations.start.theta(model)
    basis = basis_at(equations, theta)
    problem = Problem.of(equations, basis)
    require_enough(equations, basis.shape[1] + len(problem.free))
    shapes = {name: shape.starts[0] for name, shape in problem.free.items()}
    rows = equations.rows(theta, np.zeros(equations.common.shape[1]), shapes)
    require_determined(equations, rows, basis, shapes)


def memory_change(fit: Fit) -> float:
    """By how many sds a row moves if the poses before are taken from the solution."""
    equations = fit.equations
    effects = equations.on_sensor
    theta = fit.theta[equations.sensor_index]
    solved = fit.poses.conditions(fit.rows.vector, fit.sensed).previous
    at = equations.conditions(fit.rows.vector)
    before, after = (
        sensor_columns(effects, at.with_previous(each), fit.shapes, fit.rows.axes)
        for each in (equations.at_start.previous, solved)
    )
    moved = equations.whitened(((after - before) @ theta)[:, :, None], fit.rows.vector)
    return float(np.abs(moved).max())


def basis_at(equations: Equations, theta: FloatArray) -> FloatArray:
    """The combinations of parameters that the poses see at ``theta``, in their units, (p, v)."""
    if len(equations.reading_index) == equations.model.size:
        return np.eye(equations.model.size)
    at_start = equations.rows(theta, np.zeros(equations.common.shape[1]), {})
    return visible_basis(equations, at_start, {})
