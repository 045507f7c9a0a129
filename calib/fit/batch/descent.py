"""Gauss-Newton steps as :mod:`calib.fit.least_squares.gauss_newton` for a stack, masked per set.

A set whose cost rises by a full step is not followed further: the solver of one set halves its
steps, and fits it.
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.batch.linear_algebra import scaled_information, solved, times
from calib.fit.batch.stacked_rows import StackedEquations
from calib.fit.least_squares.gauss_newton import highest_cost
from calib.fit.rows.problem import EXACT
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class StackedSolution:
    """``theta`` (S, p), ``eta`` (S, q), ``iterations`` (S,), and which sets came to rest (S,)."""

    theta: FloatArray
    eta: FloatArray
    iterations: IntArray
    converged: BoolArray


def descend(equations: StackedEquations, theta: FloatArray) -> StackedSolution:
    """Full steps from ``theta`` (S, p), each set until no row of it moves any more."""
    sets, p = theta.shape
    solution = StackedSolution(
        theta.copy(), np.zeros((sets, equations.common_relative.shape[2])),
        np.zeros(sets, dtype=int), np.zeros(sets, dtype=bool),
    )
    active = np.arange(sets)
    part = equations
    rows = part.rows(solution.theta, solution.eta)
    for iteration in range(1, EXACT.steps + 1):
        step = _steps(rows.jacobian, rows.residual)
        moved = np.abs(times(rows.jacobian, step)).max(axis=1)
        at = np.hstack([solution.theta[active], solution.eta[active]]) + step
        trial = part.rows(at[:, :p], at[:, p:])
        falls = trial.cost <= highest_cost(rows.cost)  # False for NaN
        solution.theta[active[falls]] = at[falls, :p]
        solution.eta[active[falls]] = at[falls, p:]
        solution.iterations[active[falls]] = iteration
        rests = falls & (moved < EXACT.step_sd)
        solution.converged[active[rests]] = True
        goes_on = np.flatnonzero(falls & ~rests)
        if not goes_on.size:
            break
        rows = trial
        if len(goes_on) < len(active):
            active, part = active[goes_on], part.take(goes_on)
            rows = part.rows(solution.theta[active], solution.eta[active])
    return solution


def _steps(jacobian: FloatArray, residual: FloatArray) -> FloatArray:
    """The step (S, p + q) of each set, by the normal equations of its unit columns.

    They lose the square of the condition number, which a step does not feel: the minimum is where
    ``Jᵀr`` vanishes.
    """
    information, norm = scaled_information(jacobian)
    pull = times(np.swapaxes(jacobian, 1, 2), residual) / norm
    return -solved(information, pull) / norm
