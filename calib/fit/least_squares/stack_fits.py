"""The fits of one stack of sets, from the best of several starts of their shape parameters."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any

import numpy as np

from calib.effects.effect import EFFECTS
from calib.errors import FitFailed, Remedy
from calib.fit.least_squares.finish import finish
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.identifiability import Refusals, too_few, undetermined_sets
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.visible_basis import visible_bases
from calib.fit.linear import orthonormal_bases, times
from calib.fit.model import Model
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import too_large_effects
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.rows import taken

WEIGHING = Precision(30, step_sd=1e-2, idle_sd=1e-3)
"""Precision of a fit that is compared with others: chi-square is then exact to 1e-4. Numerical."""

SETS_AT_ONCE = 500
"""Sets in one stack, which then stays in a processor's cache. Tuned on ``python -m
tests.bench.bench_lot``. A limit of memory."""

STARTS_TOGETHER = 200
"""Combinations of starts that are all tried; if there are more, one shape is tried after another. A
limit of time."""

AGAIN = 3
"""Number of repeated trials, from where the last ended, of starts that do not move. Numerical."""

TURNS = 2  #: rounds in which one shape is tried after another; numerical

ENOUGH_MISFIT = 2.0
"""Chi-square per degree of freedom above which a warm start tries the shapes' other starts.
A judgement."""


def from_best_shapes(
    problem: Problem, start: Estimate, precision: Precision = EXACT
) -> Solution:
    """Fit from the first of the shapes' starts; then from the most promising."""
    if not problem.tried:
        return minimise(problem, start, precision)
    held = minimise(problem.with_shapes_held(), start, precision)
    promising = most_promising(replace(problem, weight=held.weight), held.at)
    best = minimise(problem, promising, precision)
    for _ in range(AGAIN if len(problem.tried) > len(problem.free) else 0):
        at = most_promising(replace(problem, weight=best.weight), best.at, or_here=True)
        if at is best.at:
            break
        best = minimise(problem, at, precision)
    return best


def near_warm_start(problem: Problem, start: Estimate) -> Solution:
    """Fit near a warm start, to the precision ``WEIGHING``.

    If the rows are not explained from there, the other starts of the shapes are tried.
    """
    solution = minimise(problem, start, WEIGHING)
    if not problem.tried:
        return solution
    dof = problem.equations.data_count - problem.moves - len(problem.free)
    badly = np.flatnonzero(solution.cost > ENOUGH_MISFIT * np.maximum(dof, 1))
    if badly.size:
        part, known = problem.take(badly), solution.take(badly)
        other = minimise(part, most_promising(part, known.at), WEIGHING)
        better = np.flatnonzero(other.cost < known.cost)
        solution = solution.with_sets(badly[better], other.take(better))
    return solution


def most_promising(problem: Problem, at: Estimate, or_here: bool = False) -> Estimate:
    """``at`` with the combination of the shapes' starts of least cost to first order.

    ``at`` itself where none has true vectors, or none costs less than its own shapes ``or_here``.
    """
    best, sets = at, len(at.theta)
    least = _linear_cost(problem, at) if or_here else np.full(sets, np.inf)
    tried = problem.tried
    if len(tried) > 1 and prod(len(shape.starts) for shape in tried.values()) > STARTS_TOGETHER:
        for name, shape in [*tried.items()] * TURNS:
            here = replace(problem, tried={name: shape})
            best = most_promising(here, best, or_here=or_here or best is not at)
        return best
    combinations = np.array(list(product(*(shape.starts for shape in tried.values()))))
    together = max(1, SETS_AT_ONCE // sets) if EFFECTS.keys() >= tried.keys() else 1
    for first in range(0, len(combinations) if tried else 0, together):
        values = np.repeat(combinations[first : first + together], sets, axis=0)
        which = np.tile(np.arange(sets), len(values) // sets)
        here, known = (problem, at) if len(which) == sets else (problem.take(which), at.take(which))
        starts = dict(zip(tried, values.T, strict=True))
        trial = Estimate.of(here.equations, known.theta, known.eta, {**known.shapes, **starts})
        cost = _linear_cost(here, trial).reshape(-1, sets)
        lowest = cost.argmin(axis=0)
        cost = cost.min(axis=0)
        better = np.flatnonzero(cost < least)
        best = best.with_sets(better, trial.take(lowest[better] * sets + better))
        least = np.minimum(cost, least)
    return best


def _linear_cost(problem: Problem, at: Estimate) -> FloatArray:
    """Cost of the rows at these shapes with all else fitted to first order, (S,)."""
    cost = np.full(len(at.theta), np.inf)
    solved = np.flatnonzero(at.rows.is_solved)
    root = np.sqrt(problem.weight[solved])
    jacobian = at.rows.jacobian[solved] @ problem.directions[solved]
    q = orthonormal_bases(jacobian * root[..., None])
    residual = at.rows.residual[solved] * root
    rest = residual - times(q, times(q.swapaxes(1, 2), residual))
    cost[solved] = (rest**2).sum(axis=1)
    return cost


@dataclass(frozen=True, eq=False)
class Fits:
    """The fits of one stack out of many sets.

    Parameters
    ----------
    index : array of int, shape (S,)
        Which of all sets they are.
    fitted : Fit or None
        Their fits; None where all are refused.
    refusals : dict of int to CalibrationError
        Why other sets of the stack have none: what :func:`fit` raises for them.
    """

    index: IntArray
    fitted: Fit | None
    refusals: Refusals


class _NoneLeft(Exception):
    """All sets of a stack are refused."""


class _Stack:
    """Sets of a stack that continue (``index``), and why others have left it."""

    def __init__(self, sets: int) -> None:
        self.index: IntArray = np.arange(sets)
        self.refusals: Refusals = {}

    def without(self, refused: Refusals, *parts: Any) -> Any:
        """Records and arrays ``parts`` of the sets that continue, without ``refused``."""
        if refused:
            self.refusals |= {int(self.index[k]): error for k, error in refused.items()}
            on = np.array([k for k in range(len(self.index)) if k not in refused], dtype=int)
            self.index, parts = self.index[on], tuple(taken(part, on) for part in parts)
            if not on.size:
                raise _NoneLeft
        return parts


def fits_of_stack(
    equations: Equations, at: Estimate, weight: FloatArray | None,
    minimum: Callable[[Problem, Estimate], Solution], robust: bool = False, exact: bool = False,
) -> Fits:
    """The fits of a stack that start ``at``, by what finds their ``minimum``.

    ``weight`` (S, r) is that of the rows; ``exact`` fits must have converged.
    """
    stack, fitted = _Stack(len(at.theta)), None
    with suppress(_NoneLeft):
        wild: Refusals = {int(k): too_large_effects() for k in np.flatnonzero(~at.rows.is_solved)}
        equations, at, weight = stack.without(wild, equations, at, weight)
        basis, blind = visible_bases(equations, at.rows, at.shapes)
        problem, at = stack.without(blind, Problem.of(equations, basis, robust, weight), at)
        few = too_few(problem.equations, problem.moves + len(problem.free))
        problem, at = stack.without(few, problem, at)
        solution = minimum(problem, at)
        if exact:
            problem, solution = stack.without(_restless(problem, solution), problem, solution)
        fitted, refused = finish(problem, solution)
        (fitted,) = stack.without(refused, fitted)
    return Fits(stack.index, fitted if stack.index.size else None, stack.refusals)


def _restless(problem: Problem, solution: Solution) -> Refusals:
    """The sets whose iteration did not converge."""
    triad = problem.equations.poses.triad
    restless = np.flatnonzero(~solution.is_converged)
    if not restless.size:
        return {}
    part = problem.take(restless)
    why = undetermined_sets(part.equations, solution.at.take(restless), part.basis)
    failed = FitFailed(
        f"the fit of the {triad} did not converge in {EXACT.steps} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check the {triad}'s data sheet.",
        Remedy("data_sheet", triad),
    )
    return {int(k): why.get(i, failed) for i, k in enumerate(restless)}


def at_ellipsoids(equations: Equations, theta: FloatArray) -> Estimate:
    """The estimates at ``theta`` (S, p), SI, and the first of the shapes' starts."""
    shapes = {e.name: np.full(len(theta), e.shape.starts[0])
              for e in equations.model.effects if e.shape is not None}
    eta = np.zeros((len(theta), equations.common_count))
    return Estimate.of(equations, theta, eta, shapes)


def require_determinable(poses: PoseSet, model: Model) -> None:
    """Refuse poses that cannot determine ``model``, judged at the start of the fit.

    Raises
    ------
    Undetermined
        Too few poses, none that turns, or combinations of parameters that they do not show.
    """
    equations = Equations.of_sets((poses,), model)
    at = at_ellipsoids(equations, equations.start.theta(model))
    basis, blind = visible_bases(equations, at.rows, at.shapes)
    problem = Problem.of(equations, basis)
    for refusals in (blind, too_few(equations, problem.moves + len(problem.free)),
                     undetermined_sets(equations, at, basis)):
        for error in refusals.values():
            raise error


def only_fit(fits: Fits) -> Fit:
    """The fit of a stack of one; raises the reason if it is refused."""
    if fits.fitted is None:
        raise fits.refusals[0]
    return fits.fitted.one(0)
