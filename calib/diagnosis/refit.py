"""Sets of effects added to a fit and everything refitted jointly, nonlinearly, from where it stood.

Scores before the refit also accuse innocent effects, the more so the stronger the missing one is:
the columns are linearised at a fit that the missing effect has biased. Shape parameters are fitted
with all the others. The weights of a robust fit stay as they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from calib.diagnosis.constants import CONSTANTS
from calib.effects.effect import Effect, Shape
from calib.errors import CalibrationError
from calib.fit.column_scaling import RANK_TOLERANCE, unit_columns
from calib.fit.identifiability import require_determined, require_enough, visible_basis
from calib.fit.residuals import Equations, Rows
from calib.fit.result import Fit, require_size, with_common
from calib.fit.solver import remembers_alike
from calib.poses.imu_log import FloatArray

STEPS, HALVINGS = 12, 5
STEP_SD = 1e-4
"""Converged once the step moves no row by more than this part of its sd."""

LONGEST_STEP = 1.0
"""Of the logarithm of a shape parameter: a factor of e."""

SHAPE_STEP = 1e-4
MEMORY_ROUNDS = 3


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


def p_value_of(fit: Fit) -> float:
    """Probability of a residual this large when the model and the stated sds are right."""
    chi2 = float(fit.weight @ fit.rows.residual**2)
    return float(fdtrc(fit.dof, fit.poses.noise_dof, chi2 / max(fit.dof, 1)))


def refit(base: Fit, effects: Sequence[Effect]) -> Refit | None:
    """``effects`` added to ``base`` and everything refitted; None where the poses cannot carry it.

    A shape parameter begins at the first of its effect's starts.
    """
    try:
        fit, width = _refit(base, effects)
        require_enough(fit.equations, fit.basis.shape[1] + len(fit.shapes))
        require_determined(fit.equations, fit.rows, fit.basis)
        require_size(fit.equations, fit.rows)
    except (CalibrationError, np.linalg.LinAlgError):
        return None
    if fit.dof < CONSTANTS.fewest_dof:
        return None
    return Refit(tuple(effect.name for effect in effects), fit, p_value_of(fit), width)


def _refit(base: Fit, effects: Sequence[Effect]) -> tuple[Fit, float]:
    model = base.model
    for effect in effects:
        model = model + effect
    shapes = {**base.shapes}
    free = {effect.name: effect.shape for effect in effects if effect.shape is not None}
    shapes |= {name: shape.starts[0] for name, shape in free.items()}
    theta = np.concatenate([base.theta, np.zeros(model.size - base.model.size)])
    eta, pushed = base.eta, base.pushed
    for _ in range(MEMORY_ROUNDS):
        equations = Equations(base.poses, model, pushed=pushed)
        rows = equations.rows(theta, eta, shapes)
        basis = visible_basis(equations, rows)
        state = _State(equations, theta, eta, shapes, rows)
        state, slope = _minimise(state, base.weight, basis, tuple(free), free)
        theta, eta, shapes = state.theta, state.eta, dict(state.shapes)
        fit = replace(
            base, model=model, theta=theta, eta=eta, shapes=shapes, equations=equations,
            rows=state.rows, basis=basis,
        )
        if remembers_alike(fit):
            break
        pushed = fit.pushed
    cov, shape_sd = _covariance(fit, basis, slope, base.weight)
    named_sd = {**base.shape_sd}
    width = 0.0
    for (name, shape), sd in zip(free.items(), shape_sd, strict=True):
        named_sd[name] = float(sd * shapes[name])
        span = float(np.log(shape.bounds[1] / shape.bounds[0]))
        width += float(np.log(min(1.0, np.sqrt(2 * np.pi) * sd / span)))
    return replace(fit, cov=cov, shape_sd=named_sd), width


@dataclass(frozen=True, eq=False)
class _State:
    equations: Equations
    theta: FloatArray
    eta: FloatArray
    shapes: dict[str, float]
    rows: Rows

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


def _step(rows: Rows, weight: FloatArray, basis: FloatArray) -> FloatArray:
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


def _covariance(
    fit: Fit, basis: FloatArray, slope: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) of the parameters, and the sds of the shapes' logarithms."""
    q, k, p = len(fit.eta), slope.shape[1], fit.model.size
    full = with_common(basis, q)
    jacobian = np.hstack([fit.rows.jacobian @ full, slope]) * np.sqrt(weight)[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    cov = inverse @ inverse.T
    fitted = full.shape[1]
    linear = (full @ cov[:fitted, :fitted] @ full.T)[:p, :p]
    return linear, np.sqrt(np.diag(cov)[fitted : fitted + k])
