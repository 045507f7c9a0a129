"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default``, here, starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper``
(:mod:`calib.fit.least_squares.angrisano`) iterates the equations of Angrisano et al. in (alpha, b,
k). Both end in :func:`calib.fit.least_squares.finish.finish`, which judges whether the poses
determine the model at all.

Everything is computed for a stack of S sets: :func:`fit` is a stack of one, :func:`fit_sets` makes
stacks of many. A set that is refused leaves its stack; the others go on.

A fit with more effects than one at hand (:func:`extend`) is the same problem from a warmer start.

Shape parameters (the time constant of a warm-up) are unknowns like all others, started from the
most promising of the effect's starts. The memory of the previous pose is evaluated at an estimate
of the vector sensed in it, first at the start, then at the solution, until it is steady.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from calib.effects.catalogue import REFERENCE_DRIFT
from calib.effects.effect import EFFECTS, Effect
from calib.effects.variation import about_mean
from calib.errors import Undetermined
from calib.fit.least_squares.drawn_sizes import fit_with_drawn
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.square_start import square_start
from calib.fit.least_squares.stack_fits import (
    SETS_AT_ONCE,
    Fits,
    at_ellipsoids,
    fits_of_stack,
    from_best_shapes,
    most_promising,
    near_warm_start,
    only_fit,
)
from calib.fit.least_squares.widened import undated
from calib.fit.linear import combined
from calib.fit.model import Model
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

__all__ = ["Fit", "extend", "fit", "fit_sets"]

MEMORY_ROUNDS = 30  #: numerical limit
MEMORY_SD = 1e-3
"""Largest move of a row, in sds, at which a memory is steady. Numerical."""

WEIGHING_MEMORY_ROUNDS = 5  #: a limit of time; numerical

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

    Raises
    ------
    Undetermined
        The poses do not determine the model; the message says which directions are missing.
    FitFailed
        The iteration did not converge.
    Contradiction
        No gain fits all poses: their readings or references contradict each other.
    """
    poses = poses.as_stated
    model = model.within(poses.conditions(poses.reading))
    if model.acting_on("noise"):
        return fit_with_drawn(poses, model, partial(_fit_as_stated, robust=robust))
    return _fit_as_stated(poses, model, robust)


def _fit_as_stated(poses: PoseSet, model: Model, robust: bool) -> Fit:
    """The fit with the sds and common errors of ``poses``, widened by drawn effects or not."""
    return only_fit(_cold_fits((poses,), model, robust))


def fit_sets(
    sets: Sequence[PoseSet], model: Model, *, robust: bool = False, precision: Precision = EXACT
) -> Iterator[Fits]:
    """Fit ``model`` to each of ``sets``, those of one shape in stacks.

    Parameters
    ----------
    sets : sequence of PoseSet
        Of any numbers of poses, each fitted as :func:`fit` does.
    model : Model
    robust : bool
    precision : Precision
        Below ``EXACT`` a set that has not converged has the fit it came to.

    Yields
    ------
    Fits
        Together every set once. Sets that rest in the same poses, have rings with the same waves
        in the same, as many common errors and the same columns and runs share a stack; an effect
        with memory or one that begins with a square takes fits one after another, and its sets go
        one by one.
    """
    if drawn := model.acting_on("noise"):
        alone_only = Undetermined(
            f"the size of '{drawn[0].name}' is estimated in a session by itself: take it out of "
            f"the model of a lot")
        yield Fits(np.arange(len(sets)), None, dict.fromkeys(range(len(sets)), alone_only))
        return
    alone = any(effect.in_square or "previous" in effect.needs or effect.starts_in is not None
                or (effect.shape is not None and effect.name not in EFFECTS)
                for effect in model.effects)
    groups: dict[object, list[int]] = {}
    for i, poses in enumerate(sets):
        key = (poses.reference.is_null.tobytes(), len(poses.reference.common_names),
               tuple(poses.columns), tuple(dict.fromkeys(poses.run)),
               None if poses.ring is None else (poses.ring.place.tobytes(),
                                                poses.ring.twice.tobytes()))
        groups.setdefault(key, []).append(i)
    for indices in groups.values():
        size = 1 if alone else SETS_AT_ONCE
        for first in range(0, len(indices), size):
            index = np.array(indices[first : first + size])
            of_set = model.within(sets[index[0]].conditions(sets[index[0]].reading))
            fits = _cold_fits([sets[i] for i in index], of_set, robust, precision)
            yield Fits(index[fits.index], fits.fitted,
                       {int(index[k]): error for k, error in fits.refusals.items()})


def extend(base: Fit, effects: Sequence[Effect]) -> Fit:
    """Fit the model of ``base`` with more effects, all parameters anew, from its solution.

    Meant for weighing sets of effects: it goes as far as ``WEIGHING``, and the weights of a robust
    fit stay as they are.

    Parameters
    ----------
    base : Fit
    effects : sequence of Effect
        What to add, their shapes from the first of their starts on. What follows something is in
        the fit about its mean: with a distant zero it is all but a bias or a gain.

    Raises
    ------
    CalibrationError
        An effect is in the model already.
    Undetermined
        The poses do not determine the model with them.
    FitFailed
        The effects are larger than the readings, or the gains went to nothing.
    """
    at_reading, poses = base.equations.at_reading, base.equations.conditions(base.rows.vector)
    effects = [about_mean(effect.within(at_reading), base.model.names, poses)
               for effect in effects]
    equations = base.remembering.extended(effects).take(None)
    starts = {e.name: e.shape.starts[0] for e in effects if e.shape is not None}
    more = equations.model.size - base.model.size
    theta, weight = np.concatenate([base.theta, np.zeros(more)])[None], base.weight[None]

    def weighed(start: FloatArray) -> Fits:
        shapes = _of_stack({**base.shapes, **starts})
        at = Estimate.of(equations, start, base.eta[None], shapes)
        return fits_of_stack(equations, at, weight, near_warm_start)

    def again(latest: Fit) -> Fits:
        return fits_of_stack(*_remembering(latest), weight, near_warm_start)

    squares = [effect for effect in effects if effect.in_square]
    first = _from_either_sign(weighed, theta, square_start(equations, theta, squares))
    return only_fit(_with_steady_memory(first, again, WEIGHING_MEMORY_ROUNDS))


def memory_change(fit: Fit) -> float:
    """Number of sds by which a row moves if the poses before are taken from the solution."""
    equations, terms = fit.equations, fit.equations.terms
    solved = fit.poses.conditions(fit.rows.vector, fit.sensed).previous
    at = equations.conditions(fit.rows.vector)
    before, after = (
        sensor_columns(terms.sensor.effects, replace(at, previous=previous), fit.shapes,
                       fit.rows.axes)
        for previous in (equations.at_start.previous, solved)
    )
    error = combined(after - before, fit.theta[terms.sensor.index])
    return float(np.abs(equations.whitened(error[..., None], fit.rows.vector)).max())


def _of_stack(shapes: Mapping[str, float]) -> dict[str, FloatArray]:
    """The shape parameters of one set as those of a stack of one, each (1,)."""
    return {name: np.array([value]) for name, value in shapes.items()}


def _remembering(latest: Fit) -> tuple[Equations, Estimate]:
    """The rows after the vectors sensed in the poses before, by a fit, and the fit there."""
    equations = latest.remembering.take(None)
    at = Estimate.of(equations, latest.theta[None], latest.eta[None], _of_stack(latest.shapes))
    return equations, at


def _cold_fits(
    sets: Sequence[PoseSet], model: Model, robust: bool, precision: Precision = EXACT
) -> Fits:
    """The fits of a stack from the ellipsoids; of a drifting rate with what its clips leave open.
    """
    fits = _as_stated(Equations.of_sets(sets, model), robust, precision)
    drift = model.slices().get(REFERENCE_DRIFT)
    for with_misfit in (1, 0) if drift is not None else ():
        if (fitted := fits.fitted) is None:
            break
        wider = [undated(poses, 0.0) for poses in sets]
        for k, i in enumerate(fits.index):
            one = fitted.one(k)
            per_h = np.sqrt((one.theta[drift] ** 2 + np.diag(one.cov)[drift]).item())
            wider[i] = undated(
                sets[i], per_h / SECONDS_PER_HOUR, with_misfit * one.relative_misfit)
        fits = _as_stated(Equations.of_sets(wider, model), robust, precision)
    return fits


def _as_stated(equations: Equations, robust: bool, precision: Precision) -> Fits:
    """The fits of a stack from the ellipsoids, with the common errors of its poses."""
    nearest_to_best = partial(from_best_shapes, precision=precision)

    def cold(start: FloatArray) -> Fits:
        at = at_ellipsoids(equations, start)
        return fits_of_stack(equations, at, None, nearest_to_best, robust, precision == EXACT)

    def again(latest: Fit) -> Fits:
        def nearest(problem: Problem, at: Estimate) -> Solution:
            weighted = replace(problem, weight=latest.weight[None])
            return minimise(problem, most_promising(weighted, at, or_here=True))

        return fits_of_stack(*_remembering(latest), None, nearest, robust, exact=True)

    theta = equations.start.theta(equations.model)
    squares = [effect for effect in equations.model.effects if effect.in_square]
    first = _from_either_sign(cold, theta, square_start(equations, theta, squares))
    return _with_steady_memory(first, again, MEMORY_ROUNDS)


def _from_either_sign(
    fits_from: Callable[[FloatArray], Fits], theta: FloatArray, offset: FloatArray
) -> Fits:
    """The better of the fits from ``theta`` (1, p) plus and minus ``offset``.

    Only one fit, of any number of sets, where the offset is zero.
    """
    if not offset.any():
        return fits_from(theta)
    up, down = fits_from(theta + offset), fits_from(theta - offset)
    if up.fitted is None or down.fitted is None:
        return down if up.fitted is None and down.fitted is not None else up
    return min((up, down), key=_chi2_of_one)


def _chi2_of_one(fits: Fits) -> float:
    return np.inf if fits.fitted is None else float(fits.fitted.chi2[0])


def _with_steady_memory(first: Fits, again: Callable[[Fit], Fits], rounds: int) -> Fits:
    """``first`` fitted ``again``, each time with the vectors sensed in the poses before.

    A stack of one, or one without memory.
    """
    best = latest = first
    if first.fitted is None or not any(
        "previous" in effect.needs for effect in first.fitted.model.effects
    ):
        return first
    for _ in range(rounds):
        fitted = only_fit(latest)
        if memory_change(fitted) < MEMORY_SD:
            return latest
        latest = again(fitted)
        if latest.fitted is None:
            return latest
        best = min(best, latest, key=_chi2_of_one)
    return best  # the sign of an axis near zero flips with noise: the better of both
