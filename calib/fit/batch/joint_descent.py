"""Steps of :mod:`calib.fit.least_squares.gauss_newton` for a stack, shape parameters among them.

A set of which a step finds no true vectors by fixed point is not followed further: the solver of
one set goes on by Newton's steps, and fits it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Shape
from calib.fit.batch.joint_equations import JointEquations, Shapes
from calib.fit.batch.joint_rows import JointRows, either
from calib.fit.batch.linear_algebra import each_solved, times
from calib.fit.column_scaling import RANK_TOLERANCE, unit_columns
from calib.fit.least_squares.gauss_newton import HALVINGS, highest_cost, within_bounds
from calib.fit.rows.problem import Precision
from calib.fit.rows.shape_derivatives import DIFFERENCE_STEP
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class JointEstimate:
    """``theta`` (S, p), ``eta`` (S, q), the shape parameters, and the rows there."""

    theta: FloatArray
    eta: FloatArray
    shapes: Shapes
    rows: JointRows

    @classmethod
    def of(
        cls, equations: JointEquations, theta: FloatArray, eta: FloatArray, shapes: Shapes
    ) -> "JointEstimate":
        """The estimates at these parameters."""
        with np.errstate(all="ignore"):  # such a set leaves the stack
            return cls(theta, eta, shapes, equations.rows(theta, eta, shapes))

    def where(self, chosen: BoolArray, other: "JointEstimate") -> "JointEstimate":
        """These estimates in the ``chosen`` sets (S,), the ``other`` ones elsewhere."""
        return JointEstimate(
            either(chosen, self.theta, other.theta), either(chosen, self.eta, other.eta),
            {name: either(chosen, value, other.shapes[name])
             for name, value in self.shapes.items()},
            self.rows.where(chosen, other.rows),
        )

    def take(self, sets: IntArray) -> "JointEstimate":
        """The estimates of these sets alone."""
        return JointEstimate(
            self.theta[sets], self.eta[sets],
            {name: value[sets] for name, value in self.shapes.items()}, self.rows.take(sets),
        )


@dataclass(frozen=True, eq=False)
class JointProblem:
    """S sets of which each moves along combinations of its own.

    Parameters
    ----------
    equations : JointEquations
    directions : array, shape (S, p + q, v + q)
        What theta and eta move along.
    free : mapping of effect name to Shape
        The h shape parameters that move.
    """

    equations: JointEquations
    directions: FloatArray
    free: dict[str, Shape]

    def take(self, sets: IntArray) -> "JointProblem":
        """That of these sets alone."""
        return JointProblem(self.equations.take(sets), self.directions[sets], self.free)

    def with_shapes_held(self) -> "JointProblem":
        """The same with no shape parameter free."""
        return replace(self, free={})


def descend_jointly(
    problem: JointProblem, start: JointEstimate, precision: Precision
) -> tuple[JointEstimate, IntArray]:
    """Steps from ``start``, each halved while its cost rises, until the rows of every set rest.

    Returns
    -------
    at : JointEstimate
    iterations : array of int, shape (S,)
        0 for a set that did not come to rest, or of which a step found no true vectors.
    """
    at = start
    iterations = np.zeros(len(start.theta), dtype=int)
    active, part, here = np.arange(len(iterations)), problem, start
    for iteration in range(1, precision.steps + 1):
        step, row_step = joint_step(part, here)
        largest = np.abs(row_step).max(axis=1)
        rests = largest < precision.idle_sd
        trial, share = _longest_that_falls(part, here, step)
        goes = (share > 0) & ~rests
        here = trial.where(goes, here)
        ends = rests | (share == 0) | (goes & (share * largest < precision.step_sd))
        iterations[active[ends & np.isfinite(share)]] = iteration
        at = _put(at, active, here)
        on = np.flatnonzero(goes & ~ends)
        if not on.size:
            break
        if len(on) < len(active):
            active, part, here = active[on], part.take(on), here.take(on)
    return at, iterations


def _put(at: JointEstimate, sets: IntArray, part: JointEstimate) -> JointEstimate:
    """``at`` with the estimates of ``sets`` replaced by ``part``."""
    if not len(sets):
        return at
    if len(sets) == len(at.theta):
        return part
    place = np.zeros(len(at.theta), dtype=int)
    place[sets] = np.arange(len(sets))
    chosen = np.zeros(len(at.theta), dtype=bool)
    chosen[sets] = True
    return part.take(place).where(chosen, at)


def _longest_that_falls(
    problem: JointProblem, at: JointEstimate, step: FloatArray
) -> tuple[JointEstimate, FloatArray]:
    """The estimates after the largest of 1, 1/2, 1/4 ... of each ``step`` by which no cost rises.

    With these shares (S,): 0 where the cost rises by all of them, NaN where a whole step finds no
    true vectors.
    """
    trial, falls = _trial(problem, at, step)
    share = np.where(falls | np.isfinite(trial.rows.cost), 1.0, np.nan)
    for _ in range(HALVINGS - 1):
        on = np.flatnonzero(~falls & np.isfinite(share))
        if not on.size:
            break
        share[on] /= 2
        part, falls[on] = _trial(problem.take(on), at.take(on), share[on, None] * step[on])
        trial = _put(trial, on, part)
    share[~falls & np.isfinite(share)] = 0.0
    return trial, share


def _trial(
    problem: JointProblem, at: JointEstimate, step: FloatArray
) -> tuple[JointEstimate, BoolArray]:
    """The estimates one ``step`` on, or with their shapes and all else fitted; and which fall."""
    most = highest_cost(at.rows.cost)
    p = at.theta.shape[1] + at.eta.shape[1]
    shapes = dict(at.shapes)
    for j, name in enumerate(problem.free):
        shapes[name] = shapes[name] * np.exp(step[:, p + j])
    trial = _moved(problem, at, step[:, :p], shapes)
    falls = trial.rows.cost <= most
    off = np.flatnonzero(~falls)
    if problem.free and off.size:
        part = problem.take(off)
        stretched = {name: value[off] for name, value in shapes.items()}
        beside = _moved(part, at.take(off), np.zeros((len(off), p)), stretched)
        with np.errstate(all="ignore"):
            linear, _ = joint_step(part.with_shapes_held(), beside)
        second = _moved(part, beside, linear, stretched)
        falls[off] = second.rows.cost <= most[off]
        trial = _put(trial, off[falls[off]], second.take(np.flatnonzero(falls[off])))
    return trial, np.asarray(falls & np.isfinite(most))


def _moved(
    problem: JointProblem, at: JointEstimate, linear: FloatArray, shapes: Shapes
) -> JointEstimate:
    p = at.theta.shape[1]
    linear = np.where(np.isfinite(linear), linear, 0.0)
    return JointEstimate.of(
        problem.equations, at.theta + linear[:, :p], at.eta + linear[:, p:], shapes
    )


def joint_step(problem: JointProblem, at: JointEstimate) -> tuple[FloatArray, FloatArray]:
    """The step (S, p + q + h) from an estimate, SI, and of the rows, (S, r), in sds."""
    residual = at.rows.residual
    linear = np.where(np.isfinite(at.rows.jacobian), at.rows.jacobian, 0.0) @ problem.directions
    unit, norm = unit_columns(linear)
    q, r = np.linalg.qr(unit)
    onto = times(q.swapaxes(1, 2), residual)
    row_step, shape_step = np.zeros_like(residual), np.zeros((len(residual), 0))
    if problem.free:
        slope, shape_step, coupling = _shape_step(problem, at, q, r, norm)
        onto = onto + times(coupling, shape_step)
        row_step = times(slope, shape_step)
    solution = -each_solved(r, onto[..., None])[..., 0] / norm
    step = np.concatenate([times(problem.directions, solution), shape_step], axis=1)
    return step, row_step + times(linear, solution)


def _shape_step(
    problem: JointProblem, at: JointEstimate, q: FloatArray, r: FloatArray, norm: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slope of the rows (S, r, h), step (S, h) of the shapes' logarithms, P (S, v + q, h)."""
    residual = at.rows.residual
    slope, curvature, mixed = joint_shape_derivatives(problem.equations, at, list(problem.free))
    pulled = np.einsum("sr,srph->sph", residual, mixed)
    full = np.zeros((*problem.directions.shape[:2], slope.shape[2]))
    full[:, : pulled.shape[1]] = pulled
    along = problem.directions.swapaxes(1, 2) @ full / norm[:, :, None]
    onto = q.swapaxes(1, 2) @ slope
    coupling = onto + each_solved(r.swapaxes(1, 2), along)
    transposed = slope.swapaxes(1, 2)
    matrix = transposed @ slope - coupling.swapaxes(1, 2) @ coupling
    matrix += np.einsum("sr,srh->sh", residual, curvature)[:, :, None] * np.eye(matrix.shape[2])
    matrix = np.where(np.isfinite(matrix), matrix, 0.0)
    projected = times(q.swapaxes(1, 2), residual)
    pull = times(transposed, residual) - times(coupling.swapaxes(1, 2), projected)
    newton = np.asarray((np.linalg.eigvalsh(matrix) > 0).all(axis=1))
    step = -each_solved(matrix, pull[..., None])[..., 0]
    if not newton.all():
        beside = np.nan_to_num(slope - q @ onto)
        inverse = np.asarray(np.linalg.pinv(beside, rcond=RANK_TOLERANCE), dtype=float)
        short = times(inverse, -residual)
        coupling = np.where(newton[:, None, None], coupling, onto)
        step = np.where(newton[:, None], step, short)
    return slope, within_bounds(problem.free, at.shapes, step), coupling


def joint_shape_derivatives(
    equations: JointEquations, at: JointEstimate, names: Sequence[str]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slope, curvature (S, r, h) and mixed derivatives (S, r, p, h) of whitened rows by shapes.

    As of :func:`calib.fit.rows.shape_derivatives.shape_derivatives`.
    """
    one, rows = equations.one, at.rows
    (sets, r), p = rows.residual.shape, at.theta.shape[1]
    d, k = one.data_count, len(one.magnitude)
    slope, curvature = np.zeros((2, sets, r, len(names)))
    mixed = np.zeros((sets, r, p, len(names)))
    true_share = np.ones((sets, d))
    true_share[:, :k] = 1 - times(equations.common_relative, at.eta)
    for j, effect in enumerate(e for name in names for e in one.model.effects if e.name == name):
        where = one.model.positions((effect,))
        first, second = (
            equations.whitened(each, rows.vector) * true_share[:, :, None]
            for each in equations.by_shape(effect, rows, at.shapes[effect.name], DIFFERENCE_STEP)
        )
        mixed[:, :d, where, j] = -first
        slope[:, :d, j] = -times(first, at.theta[:, where])
        curvature[:, :d, j] = -times(second, at.theta[:, where])
    return slope, curvature, mixed
