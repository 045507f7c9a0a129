"""Minima from the best of several starts of the shape parameters."""

from dataclasses import replace
from itertools import product
from math import prod

import numpy as np

from calib.fit.column_scaling import orthonormal_bases
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.rows.problem import Estimate, Precision, Problem, Solution
from calib.fit.small_systems import times
from calib.poses.imu_log import FloatArray

WEIGHING = Precision(30, step_sd=1e-2, idle_sd=1e-3)
"""Precision of a fit that is weighed against others: chi-square is then exact to 1e-4.
Numerical."""

STARTS_TOGETHER = 200
"""Combinations of starts that are all tried; of more, one shape is tried after another. A limit of
time."""

AGAIN = 3
"""Times that starts which do not move are tried again from where the last ended. Numerical."""

TURNS = 2  #: rounds in which one shape is tried after another; numerical

ENOUGH_MISFIT = 2.0
"""Chi-square per degree of freedom above which a warm start tries the shapes' other starts.
A judgement."""


def from_best_shapes(problem: Problem, start: Estimate) -> Solution:
    """From the first of the shapes' starts; then from the most promising."""
    if not problem.tried:
        return minimise(problem, start)
    held = minimise(problem.with_shapes_held(), start)
    best = minimise(problem, most_promising(replace(problem, weight=held.weight), held.at))
    for _ in range(AGAIN if len(problem.tried) > len(problem.free) else 0):
        at = most_promising(replace(problem, weight=best.weight), best.at, or_here=True)
        if at is best.at:
            break
        best = minimise(problem, at)
    return best


def near_warm_start(problem: Problem, start: Estimate) -> Solution:
    """Near a warm start, as far as ``WEIGHING``.

    Where the rows are not explained from there, the other starts of the shapes are tried.
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
    """``at`` with the combination of the shapes' starts that leaves least to first order.

    Where none has true vectors, or none leaves less than its own shapes ``or_here``, ``at`` itself.
    """
    best, sets = at, len(at.theta)
    least = _linear_cost(problem, at) if or_here else np.full(sets, np.inf)
    tried = problem.tried
    if len(tried) > 1 and prod(len(shape.starts) for shape in tried.values()) > STARTS_TOGETHER:
        for name, shape in [*tried.items()] * TURNS:
            here = replace(problem, tried={name: shape})
            best = most_promising(here, best, or_here=or_here or best is not at)
        return best
    for values in product(*(shape.starts for shape in tried.values())):
        starts = {name: np.full(sets, value)
                  for name, value in zip(tried, values, strict=True)}
        trial = Estimate.of(problem.equations, at.theta, at.eta, {**at.shapes, **starts})
        cost = _linear_cost(problem, trial)
        better = np.flatnonzero(cost < least)
        if not better.size:
            continue
        best, least = best.with_sets(better, trial.take(better)), np.minimum(cost, least)
    return best


def _linear_cost(problem: Problem, at: Estimate) -> FloatArray:
    """What the rows would leave at these shapes, all else fitted to first order, (S,)."""
    cost = np.full(len(at.theta), np.inf)
    solved = np.flatnonzero(at.rows.is_solved)
    root = np.sqrt(problem.weight[solved])
    jacobian = at.rows.jacobian[solved] @ problem.directions[solved]
    q = orthonormal_bases(jacobian * root[..., None])
    residual = at.rows.residual[solved] * root
    rest = residual - times(q, times(q.swapaxes(1, 2), residual))
    cost[solved] = (rest**2).sum(axis=1)
    return cost
