"""More effects added to many fits: :func:`calib.fit.least_squares.solver.extend` for all at once.

Fits of one model with the same effects added are a stack. What does not go straight to its minimum
is extended by itself, so that results and refusals are the same.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.batch.joint_basis import visible_bases
from calib.fit.batch.joint_descent import JointEstimate, JointProblem, descend_jointly
from calib.fit.batch.joint_equations import JointEquations, is_listed, is_mark
from calib.fit.batch.joint_finish import finish_jointly
from calib.fit.batch.linear_algebra import times
from calib.fit.column_scaling import orthonormal_bases
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import (
    ENOUGH_MISFIT,
    MEMORY_SD,
    WEIGHING,
    WEIGHING_MEMORY_ROUNDS,
    extend,
    memory_change,
)
from calib.fit.rows.problem import with_common
from calib.fit.rows.residuals import Equations
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Extension:
    """Asks for ``effects`` added to ``base`` and everything fitted anew, from where it stood."""

    base: Fit
    effects: tuple[Effect, ...]

    @property
    def shape(self) -> tuple[object, ...] | None:
        """What extensions share that are one stack; None of one that is made by itself."""
        base = self.base
        kinds = [_kind(each, base) for each in (*base.model.effects, *self.effects)]
        if base.is_robust or None in kinds:
            return None
        return (
            base.rows.residual.shape, base.equations.magnitude.tobytes(),
            tuple(base.poses.columns), *kinds,
        )


def _kind(effect: Effect, base: Fit) -> tuple[object, ...] | None:
    """What effects of one stack share in one place of their models; None of one that has none."""
    if effect.in_square or (effect.acts_on != "sensor" and effect.shape is not None):
        return None
    if is_listed(effect):
        return (effect.name, effect.shape and len(effect.shape.starts))
    return ("mark", effect.parameters) if is_mark(effect, base.equations.at_start) else None


def extend_many(requests: Sequence[Extension]) -> list[Fit | None]:
    """The fits with more effects; None where one is refused.

    Parameters
    ----------
    requests : sequence of Extension
        Of one :attr:`Extension.shape`.

    Returns
    -------
    list of Fit or None
        Those of :func:`calib.fit.least_squares.solver.extend`, within the precision that fits are
        weighed with.
    """
    if requests[0].shape is None or len(requests) == 1:
        return [_alone(each) for each in requests]
    cases = []
    for each, equations in zip(requests, _extended(requests), strict=True):
        base = each.base
        more = {e.name: e.shape.starts[0] for e in each.effects if e.shape is not None}
        size = sum(len(e.parameters) for e in each.effects)
        cases.append(_WarmStart(
            equations,
            np.concatenate([base.theta, np.zeros(size)]), base.eta, {**base.shapes, **more},
        ))
    fits = _weighed(dict(enumerate(cases)))
    if any("previous" in e.needs for e in (*requests[0].base.model.effects, *requests[0].effects)):
        fits = _with_steady_memory(fits)
    return [fits[i] if i in fits else _alone(each) for i, each in enumerate(requests)]


def _extended(requests: Sequence[Extension]) -> list[Equations]:
    """The rows of the larger models, each after what its axes sensed at its base."""
    first = requests[0].base.remembering.extended(requests[0].effects)
    if not all(is_listed(effect) for effect in first.model.effects):
        return [first, *(each.base.remembering.extended(each.effects) for each in requests[1:])]
    return [first, *(each.base.remembering.extended_as(first, each.effects)
                     for each in requests[1:])]


def _alone(request: Extension) -> Fit | None:
    try:
        return extend(request.base, request.effects)
    except (CalibrationError, np.linalg.LinAlgError):
        return None


@dataclass(frozen=True, eq=False)
class _WarmStart:
    """Equations and the estimate that a fit starts from: theta (p,), eta (q,) and shapes."""

    equations: Equations
    theta: FloatArray
    eta: FloatArray
    shapes: Mapping[str, float]


Fits = dict[int, Fit | None]
"""Fits by the numbers of their cases: None where one is refused, missing where one went astray."""


def _with_steady_memory(first: Fits) -> Fits:
    """Each fitted again, after what the axes sensed in the poses before, until that is steady."""
    best, latest = dict(first), dict(first)
    for _ in range(WEIGHING_MEMORY_ROUNDS):
        moving = {i: fit for i, fit in latest.items()
                  if fit is not None and memory_change(fit) >= MEMORY_SD}
        again = _weighed({
            i: _WarmStart(fit.remembering, fit.theta, fit.eta, fit.shapes)
            for i, fit in moving.items()
        })
        for i in latest.keys() - moving.keys():
            best[i] = latest.pop(i)  # it is steady, or refused
        for i in moving:
            fit = again.get(i)
            if i not in again:
                del best[i], latest[i]
            elif fit is None:
                best[i] = latest[i] = None
            else:
                latest[i], known = fit, best[i]
                best[i] = fit if known is None or fit.chi2 < known.chi2 else known
        if not latest:
            break
    return best


def _weighed(cases: Mapping[int, _WarmStart]) -> Fits:
    """The fits near their starts, as far as ``WEIGHING``."""
    if not cases:
        return {}
    fits: Fits = {}
    numbers = list(cases)
    equations = JointEquations([cases[i].equations for i in numbers])
    names = cases[numbers[0]].shapes
    at = JointEstimate.of(
        equations,
        np.array([cases[i].theta for i in numbers]),
        np.array([cases[i].eta for i in numbers]),
        {name: np.array([cases[i].shapes[name] for i in numbers]) for name in names},
    )
    bases: dict[int, list[tuple[int, FloatArray]]] = {}
    sound = np.flatnonzero(at.rows.is_solved & np.isfinite(at.rows.jacobian).all(axis=(1, 2)))
    part = at.take(sound)
    each = visible_bases(equations.take(sound), part.rows, part.shapes) if len(sound) else []
    for k, basis in zip(map(int, sound), each, strict=True):
        if basis is None:
            fits[numbers[k]] = None
        else:
            bases.setdefault(basis.shape[1], []).append((k, basis))
    for alike in bases.values():
        which = np.array([k for k, _ in alike])
        some = _minimised(equations.take(which), at.take(which), [basis for _, basis in alike])
        fits |= {numbers[which[k]]: fit for k, fit in some.items()}
    return fits


def _minimised(
    equations: JointEquations, start: JointEstimate, bases: Sequence[FloatArray]
) -> Fits:
    """The fits of sets that move along equally many combinations, by their place here."""
    q = start.eta.shape[1]
    free = {e.name: e.shape for e in equations.one.model.effects if e.shape is not None}
    directions = np.array([with_common(basis, q) for basis in bases])
    problem = JointProblem(equations, directions, free)
    at, iterations = descend_jointly(problem, start, WEIGHING)
    dof = max(equations.one.data_count - bases[0].shape[1] - len(free), 1)
    badly = np.flatnonzero((iterations > 0) & (at.rows.cost > ENOUGH_MISFIT * dof))
    if free and badly.size:
        # From the most promising of the other starts of the shapes.
        part, known = problem.take(badly), at.take(badly)
        other, steps = descend_jointly(part, _most_promising(part, known), WEIGHING)
        better = (steps > 0) & (other.rows.cost < known.rows.cost)
        iterations[badly[steps == 0]] = 0
        iterations[badly[better]] = steps[better]
        place = np.zeros(len(iterations), dtype=int)
        place[badly] = np.arange(len(badly))
        chosen = np.zeros(len(iterations), dtype=bool)
        chosen[badly[better]] = True
        at = other.take(place).where(chosen, at)
    ended = np.flatnonzero(iterations)
    if not ended.size:
        return {}
    fits = finish_jointly(problem.take(ended), at.take(ended), iterations[ended])
    return dict(zip(map(int, ended), fits, strict=True))


def _most_promising(problem: JointProblem, at: JointEstimate) -> JointEstimate:
    """``at`` with the combination of the shapes' starts that leaves least to first order."""
    each = problem.equations.each
    best, least = at, np.full(len(each), np.inf)
    for places in product(*(range(len(shape.starts)) for shape in problem.free.values())):
        shapes = dict(at.shapes)
        for name, place in zip(problem.free, places, strict=True):
            shapes[name] = np.array([_starts(e, name)[place] for e in each])
        trial = JointEstimate.of(problem.equations, at.theta, at.eta, shapes)
        cost = _linear_cost(problem, trial)
        best, least = trial.where(cost < least, best), np.minimum(cost, least)
    return best


def _starts(equations: Equations, name: str) -> tuple[float, ...]:
    return next(e.shape.starts for e in equations.model.effects
                if e.name == name and e.shape is not None)


def _linear_cost(problem: JointProblem, at: JointEstimate) -> FloatArray:
    """What the rows would leave at these shapes, everything else fitted to first order, (S,)."""
    jacobian = np.where(at.rows.is_solved[:, None, None], at.rows.jacobian, 0.0)
    columns = jacobian @ problem.directions
    u = orthonormal_bases(columns)
    residual = at.rows.residual
    rest = residual - times(u, times(u.swapaxes(1, 2), residual))
    return np.where(at.rows.is_solved, (rest**2).sum(axis=1), np.inf)
