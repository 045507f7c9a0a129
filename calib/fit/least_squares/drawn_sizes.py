"""Sizes of drawn effects: the noise beyond that which the samples of the poses show.

With J what the fit is free along, r the residual and K the covariance of the rows by the stated
sds and ``τ² Z Zᵀ`` of every drawn effect, the sizes maximise the restricted likelihood (Patterson
and Thompson, Biometrika 58, 1971)

    -½ (log det K + log det JᵀK⁻¹J + rᵀP r),    P = K⁻¹ - K⁻¹J (JᵀK⁻¹J)⁻¹ JᵀK⁻¹
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from calib.effects.effect import Effect
from calib.effects.needs import LACKING, unavailable
from calib.errors import Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.widened import WANDERS, Drawn, times_apart, widened
from calib.fit.model import Model
from calib.fit.rows.whitened_rows import Whitening
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

ROUNDS = 8  #: numerical limit
STEADY = 0.01  #: relative change of a size that ends the rounds; numerical
LEAST = 1e-2
"""Smallest size that differs from zero, relative to that which alone makes one sd in a typical row.
Numerical: the variance of a row changes by 1e-4."""

LARGEST_LOG = float(np.log(1e5))  #: logarithm of the largest, in the same unit; numerical limit
FIRST_SHARE = 0.2  #: share of the session at which a correlation time starts; numerical
DIFFERENCE = 0.05  #: step of a logarithm, for the curvature of the likelihood; numerical
SIZES = 2.0 ** np.arange(8)
"""Sizes over which an evidence is averaged, relative to that which makes one sd in a typical row.
Numerical."""

START_SHARES = (1.0, 0.1)  #: shares of the misfit at which every size starts; numerical


@dataclass(frozen=True, eq=False)
class Likelihood:
    """The restricted likelihood of sizes about one fit.

    Parameters
    ----------
    residual, jacobian : array, shapes (r,) and (r, v)
        Whitened as the fit has them, what drawn effects took put back; data rows first.
    variance : array, shape (d,)
        Of the data rows without any drawn effect, in the fit's own.
    parts : tuple of callable
        Of each drawn effect: the covariance of the data rows by unit size, (d,) or (d, d), at a
        shape parameter.
    """

    residual: FloatArray
    jacobian: FloatArray
    variance: FloatArray
    parts: tuple[Callable[[float], FloatArray], ...]

    @classmethod
    def about(cls, fit: Fit, effects: Sequence[Effect]) -> "Likelihood":
        """The likelihood of the sizes of ``effects``, whatever sizes ``fit`` has."""
        d, names = fit.equations.data_count, fit.poses.reference.common_names
        wanders = np.array([name.startswith(WANDERS) for name in names], bool)
        p = fit.model.size
        # ``directions`` has the common errors first, one column for each.
        along = fit.directions[:, np.concatenate([~wanders, np.ones(fit.basis.shape[1], bool)])]
        rows = np.concatenate([np.ones(d, bool), ~wanders])
        residual = fit.rows.residual - fit.rows.jacobian[:, p:][:, wanders] @ fit.eta[wanders]
        stated = stated_row_sd(fit)
        variance = np.ones(d)
        variance[: len(stated)] = (stated / fit.equations.row_sd[: len(stated)]) ** 2
        return cls(residual[rows], (fit.rows.jacobian @ along)[rows], variance / fit.weight[:d],
                   tuple(_part(fit, effect) for effect in effects))

    def log_density(self, sizes: Sequence[float], shapes: Sequence[float]) -> float:
        """Restricted log likelihood, up to a constant; -inf where no such covariance exists."""
        d = len(self.variance)
        of_parts = [size**2 * part(shape)
                    for part, size, shape in zip(self.parts, sizes, shapes, strict=True)]
        diagonal = self.variance + sum(each for each in of_parts if each.ndim == 1)
        both = np.column_stack([self.jacobian, self.residual])
        if alike := [each for each in of_parts if each.ndim == 2]:
            try:
                factor = np.linalg.cholesky(np.diag(diagonal) + sum(alike))
            except np.linalg.LinAlgError:
                return -np.inf
            both[:d] = solve_triangular(factor, both[:d], lower=True, check_finite=False)
            root = np.diag(factor)
        else:
            root = np.sqrt(diagonal)
            both[:d] /= root[:, None]
        q, r = np.linalg.qr(both[:, :-1])
        rest = both[:, -1] - q @ (q.T @ both[:, -1])
        length = np.abs(np.diag(r))
        seen = length > np.finfo(float).eps * length.max(initial=1.0)
        return float(-np.log(root).sum() - np.log(length[seen]).sum() - 0.5 * rest @ rest)

    def units(self, shapes: Sequence[float]) -> FloatArray:
        """The size of each part, SI, that makes one sd in a typical row of those it shows in, (m,).
        """
        parts = [part(shape) for part, shape in zip(self.parts, shapes, strict=True)]
        shown = [part if part.ndim == 1 else np.diag(part) for part in parts]
        return np.array([1 / np.sqrt(np.median(each[each > 0])) if each.any() else 1.0
                         for each in shown])


def _part(fit: Fit, effect: Effect) -> Callable[[float], FloatArray]:
    """The covariance of the data rows, whitened, by an effect of unit size."""
    equations, pose = fit.equations, fit.equations.row_pose
    errors = effect.evaluate(equations.at_reading)[pose, :, 0]
    shown = equations.directions(fit.rows.vector) * errors
    if effect.drawn == "in_time":
        apart, alike = times_apart(fit.poses), shown @ shown.T
        return lambda tau_s: np.asarray(alike * np.exp(-apart / tau_s)[np.ix_(pose, pose)])
    if effect.drawn == "as_noise":
        shown = shown * fit.poses.as_stated.sd[pose]
    squares = (shown**2).sum(axis=1)
    return lambda _shape: np.asarray(squares)


def likeliest(
    likelihood: Likelihood, effects: Sequence[Effect], starts: Sequence[Drawn]
) -> dict[str, Drawn]:
    """The likeliest sizes and shapes with their sds.

    The search begins at the sizes and shapes ``starts``, and where a size is 0 at shares of the
    misfit.
    """
    from scipy.optimize import minimize  # few models have drawn sizes

    at = [each.shape for each in starts]
    units = likelihood.units(at)
    bounds = [(np.log(LEAST), LARGEST_LOG)] * len(effects)
    shaped = [i for i, effect in enumerate(effects) if effect.shape is not None]
    bounds += [tuple(np.log(effects[i].shape.bounds)) for i in shaped]  # type: ignore[union-attr]

    def unpacked(x: FloatArray) -> tuple[Sequence[float], list[float]]:
        shapes = [*at]
        for i, value in zip(shaped, np.exp(x[len(effects):]), strict=True):
            shapes[i] = float(value)
        return [*map(float, units * np.exp(x[: len(effects)]))], shapes

    def cost(x: FloatArray) -> float:
        return -likelihood.log_density(*unpacked(x))

    misfit = float(likelihood.residual @ likelihood.residual) / max(
        len(likelihood.residual) - likelihood.jacobian.shape[1], 1)
    begin = 0.5 * np.log(np.clip((misfit - 1) / len(effects), LEAST, np.exp(LARGEST_LOG)))
    tries = []
    for share in START_SHARES[: 1 if any(each.size for each in starts) else None]:
        x = np.array([np.log(each.size / unit) if each.size else begin + np.log(share)
                      for each, unit in zip(starts, units, strict=True)]
                     + [np.log(at[i]) for i in shaped])
        x = np.clip(x, *np.array(bounds).T)
        tries.append(minimize(cost, x, method="L-BFGS-B", bounds=bounds))
    best = min(tries, key=lambda each: each.fun)
    sizes, shapes = unpacked(best.x)
    none = best.x[: len(effects)] <= np.log(LEAST) + DIFFERENCE
    spread = _spread(cost, best.x, [i for i in range(len(best.x)) if i >= len(none) or not none[i]])
    drawn = {}
    for i, effect in enumerate(effects):
        size = 0.0 if none[i] else float(sizes[i])
        sd = (size * spread[i] if i in spread
              else _largest_of_one_sd(cost, best.x, i, best.fun) * float(units[i]))
        drawn[effect.name] = Drawn(size, sd, shapes[i], effect)
    return drawn


def _spread(
    cost: Callable[[FloatArray], float], x: FloatArray, which: Sequence[int]
) -> dict[int, float]:
    """Sds of the logarithms ``which`` of ``x``, all others held; none where the cost is flat."""
    steps = DIFFERENCE * np.eye(len(x))[list(which)]
    curvature = np.array([[
        (cost(x + a + b) - cost(x + a - b) - cost(x - a + b) + cost(x - a - b))
        / (4 * DIFFERENCE**2) for b in steps] for a in steps]).reshape(len(steps), len(steps))
    variance = np.diag(np.linalg.pinv(curvature, hermitian=True))
    return {i: float(np.sqrt(v)) for i, v in zip(which, variance, strict=True) if v > 0}


def _largest_of_one_sd(
    cost: Callable[[FloatArray], float], x: FloatArray, i: int, least: float
) -> float:
    """The size, in its own unit, at which the likelihood has fallen as at one sd."""
    from scipy.optimize import bisect

    def beyond(exponent: float) -> float:
        trial = x.copy()
        trial[i] = exponent
        return cost(trial) - least - 0.5

    return float(np.exp(LARGEST_LOG if beyond(LARGEST_LOG) <= 0 else
                        bisect(beyond, x[i], LARGEST_LOG, xtol=DIFFERENCE)))


def log_evidences(
    fit: Fit, effects: Sequence[Effect], spans: Sequence[float]
) -> FloatArray:
    """Log evidence (m,), no unit, of each of ``effects`` alone, averaged over its sizes.

    Effects drawn in time have the correlation times ``spans`` of the session, all equally likely:
    at its likeliest one a wander explains any noise, since the shortest is noise.
    """
    length_s = _length_s(fit.poses)
    values = []
    for effect in effects:
        likelihood = Likelihood.about(fit, (effect,))
        shapes = [span * length_s for span in spans] if effect.drawn == "in_time" else [1.0]
        unit = float(likelihood.units(shapes[:1])[0])
        values.append(np.logaddexp.reduce([
            likelihood.log_density([unit * size], [shape]) for shape in shapes for size in SIZES
        ]) - np.log(len(shapes)))
    return np.array(values)


def fit_with_drawn(
    poses: PoseSet, model: Model, fit_means: Callable[[PoseSet, Model], Fit]
) -> Fit:
    """Fit of a model with drawn effects, at their likeliest sizes.

    Parameters
    ----------
    poses : PoseSet
        n poses with their sds as stated.
    model : Model
    fit_means : callable
        The fit of a model at given sizes.

    Returns
    -------
    Fit
        Of ``poses`` with the sds and common errors that the sizes make; a size stands in theta.

    Raises
    ------
    Undetermined
        The poses cannot evaluate a drawn effect.
    """
    effects = model.acting_on("noise")
    for effect in effects:
        why = unavailable(effect, poses.conditions(poses.reading))
        if effect.drawn == "in_time" and _length_s(poses) == 0:
            why = LACKING["time"]
        if why is not None:
            raise Undetermined(f"{poses.triad}: '{effect.name}' cannot be evaluated: {why}.")
        if not effect.evaluate(poses.conditions(poses.reading)).any():
            runs = ", ".join(f"'{run}'" for run in dict.fromkeys(poses.run))
            raise Undetermined(f"{poses.triad}: '{effect.name}' acts on none of these poses, which "
                               f"are of {runs}. Name one of these runs, or remove it.")
    now = {e.name: Drawn(0.0, 0.0, _first_shape(e, poses), e) for e in effects}
    fitted = fit_means(poses, model)
    for k in range(ROUNDS):
        before = now
        now = likeliest(Likelihood.about(fitted, effects), effects, [*now.values()])
        fitted = fit_means(widened(poses, tuple(now.values())), model)
        if k and max(abs(np.log(max(now[name].size, now[name].sd) / max(each.size, each.sd)))
                     for name, each in before.items()) < STEADY:
            break
    return _with_sizes(fitted, now)


def _first_shape(effect: Effect, poses: PoseSet) -> float:
    """Start of a correlation time: a fifth of the session."""
    return 1.0 if effect.shape is None else float(np.clip(
        FIRST_SHARE * _length_s(poses), *effect.shape.bounds))


def _length_s(poses: PoseSet) -> float:
    """Longest time between poses on one clock, s; 0 where none is known."""
    apart = times_apart(poses)
    return float(apart[np.isfinite(apart)].max(initial=0.0))


def _with_sizes(fitted: Fit, sizes: Mapping[str, Drawn]) -> Fit:
    """``fitted`` with the sizes among its parameters."""
    theta, cov, shapes = fitted.theta.copy(), fitted.cov.copy(), {**fitted.shapes}
    for name, each in sizes.items():
        where = fitted.model.slices()[name].start
        theta[where], cov[where, where] = each.size, each.sd**2
        if each.effect.shape is not None:
            shapes[name] = each.shape
    return replace(fitted, at=replace(fitted.at, theta=theta, shapes=shapes), cov=cov)


def stated_row_sd(fit: Fit) -> FloatArray:
    """Sds (r,) of the data rows of a fit by the samples of the poses, without drawn effects, SI."""
    return np.asarray(
        Whitening.of((fit.poses.as_stated,), fit.equations.start.take(None)).row_sd[0])


def times_stated(fit: Fit) -> float:
    """Residual of a fit over the noise that the samples of the poses show, root mean square."""
    stated = stated_row_sd(fit)
    widened = fit.equations.row_sd[: len(stated)] / stated
    in_sd = fit.rows.residual[: len(stated)] * widened
    return float(np.sqrt(fit.weight[: len(stated)] @ in_sd**2 / max(fit.dof, 1)))
