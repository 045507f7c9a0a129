"""Sets of effects added to a fit and everything refitted jointly, nonlinearly, from where it stood.

Scores before the refit also accuse innocent effects, the more so the stronger the missing one is:
the columns are linearised at a fit that the missing effect has biased. Shape parameters are fitted
with all the others. The weights of a robust fit stay as they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.effects.effect import Effect, Shape
from calib.errors import CalibrationError
from calib.fit.column_scaling import RANK_TOLERANCE, orthonormal_columns, unit_columns
from calib.fit.identifiability import visible_basis
from calib.fit.leave_one_out import left_out_residual
from calib.fit.model import Model
from calib.fit.residuals import Equations, WhitenedRows
from calib.fit.result import Fit, Solution, finish, with_common, with_shape_sd
from calib.fit.solver import MEMORY_SD, fit, memory_change
from calib.poses.imu_log import FloatArray

STEPS, HALVINGS = 30, 8
STEP_SD = 1e-4
"""Converged once the step moves no row by more than this part of its sd."""

ENOUGH_MISFIT = 2.0
"""Chi-square per degree of freedom above which other starts of the shapes are tried."""

LONGEST_STEP = 1.0
"""Of the logarithm of a shape parameter: a factor of e."""

SHAPE_STEP = 1e-4
MEMORY_ROUNDS = 5
"""Often enough for a size; the fit that is kept goes on until it is steady."""


@dataclass(frozen=True, eq=False)
class Refit:
    """A base fit with more effects, everything refitted.

    ``names`` of what was added, ``fit`` the joint fit, ``p_value`` whether it explains the rows,
    ``log_shape_width`` the log share of their range that the data leave to its shape parameters.
    """

    names: tuple[str, ...]
    fit: Fit
    p_value: float
    log_shape_width: float = 0.0

    @property
    def explains(self) -> bool:
        """Whether the poses' own noise explains what is left."""
        return self.p_value >= CONSTANTS.adequate_p_value


def linear_loo_rms(fit: Fit) -> float:
    """Leave-one-out error, SI, with the model linear about its solution: for comparisons only."""
    root = np.sqrt(fit.weight)
    equations = fit.equations
    out = left_out_residual(
        fit.rows.residual * root, fit.rows.jacobian * root[:, None], equations.row_pose
    )
    return float(np.sqrt(np.mean((equations.row_sd * out) ** 2)))


def refit(base: Fit, effects: Sequence[Effect]) -> Refit | None:
    """``effects`` added to ``base`` and everything refitted; None where the poses cannot carry it.

    A shape parameter begins at the first of its effect's starts.
    """
    try:
        if any(effect.in_square for effect in effects):
            joint = fit(base.poses, _sum(base.model, effects), robust=base.is_robust)
        else:
            joint = _refit(base, _sum(base.model, effects))
    except (CalibrationError, np.linalg.LinAlgError):
        return None
    if joint.dof < CONSTANTS.fewest_dof:
        return None
    names = tuple(effect.name for effect in effects)
    return Refit(names, joint, joint.bounded_p_value, _log_shape_width(joint, effects))


def _sum(model: Model, effects: Sequence[Effect]) -> Model:
    for effect in effects:
        model = model + effect
    return model


def _log_shape_width(joint: Fit, effects: Sequence[Effect]) -> float:
    """Log share of their range that the data leave to the shape parameters of ``effects``."""
    width = 0.0
    for effect in effects:
        if effect.shape is not None:
            sd = joint.shape_sd[effect.name] / joint.shapes[effect.name]
            span = float(np.log(effect.shape.bounds[1] / effect.shape.bounds[0]))
            if np.isfinite(sd):  # one that the rows do not feel keeps all of its range
                width += float(np.log(min(1.0, np.sqrt(2 * np.pi) * sd / span)))
    return width


def _refit(base: Fit, model: Model) -> Fit:
    free = {effect.name: effect.shape for effect in model.effects if effect.shape is not None}
    shapes = {name: base.shapes.get(name, shape.starts[0]) for name, shape in free.items()}
    theta = np.concatenate([base.theta, np.zeros(model.size - base.model.size)])
    eta, sensed = base.eta, base.sensed
    remembers = any("previous" in effect.needs for effect in model.effects)
    for _ in range(MEMORY_ROUNDS):
        equations = Equations(base.poses, model, sensed)
        rows = equations.rows(theta, eta, shapes)
        basis = visible_basis(equations, rows)
        start = _State(equations, theta, eta, shapes, rows)
        state, slope = _minimise(start, base.weight, basis, tuple(free), free)
        if free and not _is_explained(state, basis, base):
            other = _other_shapes(state, base.weight, basis, free)
            if other is not None:
                again, steeper = _minimise(other, base.weight, basis, tuple(free), free)
                if again.cost(base.weight) < state.cost(base.weight):
                    state, slope = again, steeper
        theta, eta, shapes = state.theta, state.eta, dict(state.shapes)
        solution = Solution(theta, eta, state.rows, base.weight, STEPS)
        joint = finish(equations, solution, basis, shapes)
        if not remembers or memory_change(joint) < MEMORY_SD:
            break
        sensed = joint.sensed
    if not free:
        return joint
    return with_shape_sd(joint, slope / np.array([shapes[name] for name in free]))


def _is_explained(state: "_State", basis: FloatArray, base: Fit) -> bool:
    """Whether the rows leave about as much as their noise does."""
    dof = state.equations.data_count - basis.shape[1] - len(state.shapes)
    return bool(state.cost(base.weight) < ENOUGH_MISFIT * max(dof, 1))


def _other_shapes(
    state: "_State", weight: FloatArray, basis: FloatArray, free: Mapping[str, Shape]
) -> "_State | None":
    """The most promising of the shapes' other starts, everything else fitted linearly."""
    root, full = np.sqrt(weight), with_common(basis, len(state.eta))
    best, promise = None, np.inf
    for values in product(*(shape.starts for shape in free.values())):
        shapes = {**state.shapes, **dict(zip(free, values, strict=True))}
        try:
            rows = state.equations.rows(state.theta, state.eta, shapes)
        except CalibrationError:
            continue
        q = orthonormal_columns(rows.jacobian @ full * root[:, None])
        residual = rows.residual * root
        rest = float(residual @ residual - (q.T @ residual) @ (q.T @ residual))
        if rest < promise:
            promise = rest
            best = _State(state.equations, state.theta, state.eta, shapes, rows)
    return best


@dataclass(frozen=True, eq=False)
class _State:
    equations: Equations
    theta: FloatArray
    eta: FloatArray
    shapes: dict[str, float]
    rows: WhitenedRows

    def cost(self, weight: FloatArray) -> float:
        """Weighted sum of squares."""
        return float(weight @ self.rows.residual**2)

    def moved(self, step: FloatArray, free: Sequence[str]) -> "_State":
        """One step on, its last entries those of the shapes' logarithms."""
        p, q = len(self.theta), len(self.eta)
        shapes = {**self.shapes}
        for name, change in zip(free, step[p + q :], strict=True):
            shapes[name] = float(shapes[name] * np.exp(change))
        theta, eta = self.theta + step[:p], self.eta + step[p : p + q]
        return _State(self.equations, theta, eta, shapes, self.equations.rows(theta, eta, shapes))


def _minimise(
    state: _State,
    weight: FloatArray,
    basis: FloatArray,
    free: Sequence[str],
    shapes: Mapping[str, Shape],
) -> tuple[_State, FloatArray]:
    """Gauss-Newton over parameters, common errors and the logarithms of shapes, with halving."""
    full = with_common(basis, len(state.eta) + len(free))
    slope = _slope(state, free)
    for _ in range(STEPS):
        rows = replace(state.rows, jacobian=np.hstack([state.rows.jacobian, slope]))
        step = _step(rows, weight, full)
        step = _within(step, state, free, shapes)
        cost = float(weight @ state.rows.residual**2)
        trial = state
        for _ in range(HALVINGS):
            try:
                trial = state.moved(step, free)
            except CalibrationError:
                step = step / 2
                continue
            if float(weight @ trial.rows.residual**2) <= cost * (1 + 1e-9) + 1e-9:
                break
            step = step / 2
        else:
            break
        state = trial
        slope = _slope(state, free)
        if float(np.abs(rows.jacobian @ step).max()) < STEP_SD:
            break
        gained = cost - float(weight @ state.rows.residual**2)
        if gained < STEP_SD:
            break
    return state, slope


def _step(rows: WhitenedRows, weight: FloatArray, basis: FloatArray) -> FloatArray:
    """Gauss-Newton step along ``basis``, column-scaled, by QR."""
    root = np.sqrt(weight)
    unit, scale = unit_columns((rows.jacobian @ basis) * root[:, None])
    q, r = np.linalg.qr(unit)
    diagonal = np.abs(np.diag(r))
    if diagonal.min() > RANK_TOLERANCE * diagonal.max():
        step = np.linalg.solve(r, -(q.T @ (rows.residual * root)))
    else:  # the shape of an effect that is still zero leaves no trace
        step = np.linalg.lstsq(unit, -rows.residual * root, rcond=RANK_TOLERANCE)[0]
    return np.asarray(basis @ (step / scale))


def _within(
    step: FloatArray, state: _State, free: Sequence[str], shapes: Mapping[str, Shape]
) -> FloatArray:
    """``step`` with the shapes kept within their bounds and to a factor of e."""
    step = step.copy()
    for i, name in enumerate(free):
        at, (low, high) = np.log(state.shapes[name]), np.log(shapes[name].bounds)
        place = len(step) - len(free) + i
        change = float(np.clip(step[place], -LONGEST_STEP, LONGEST_STEP))
        step[place] = np.clip(at + change, low, high) - at
    return step


def _slope(state: _State, free: Sequence[str]) -> FloatArray:
    """Derivative of the residual by the logarithm of every free shape, (r, k)."""
    columns = np.zeros((len(state.rows.residual), len(free)))
    for i, name in enumerate(free):
        shapes = {**state.shapes, name: state.shapes[name] * (1 + SHAPE_STEP)}
        up = state.equations.rows(state.theta, state.eta, shapes).residual
        columns[:, i] = (up - state.rows.residual) / SHAPE_STEP
    return columns
