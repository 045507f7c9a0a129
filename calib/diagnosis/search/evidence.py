"""Evidence of a set of hypotheses about what is left in the residual, in closed form.

A block is a hypothesis with columns X; a set of blocks is a covariance of the projected residual:

    r ~ N(0, V I + Σ_k tau_k² X_k X_kᵀ)

tau_k the root mean square signal of block k in noise units, V = 1 where the stated noise holds and
larger where something else is left. Log densities are relative to those of unit rows without any
constant. They are averaged over tau = 1, 2, 4 ... and over V: no threshold is needed, parameters
that buy nothing cost, and nothing ties where p-values underflow. The prior of tau is a half-Cauchy
distribution (Gelman, Bayesian Analysis 1, 2006), whose tail is heavy enough for any signal.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

#: sizes of an effect, noise units, each twice the one before; numerical
TAUS = 2.0 ** np.arange(CONSTANTS.octaves_of_size)
HALF_CAUCHY = TAUS / (1.0 + (TAUS / CONSTANTS.typical_size) ** 2)
"""Derived: its density over the logarithm of tau, up to a factor."""

LOG_PRIOR = np.log(HALF_CAUCHY / HALF_CAUCHY.sum())

SWEEPS = 2
"""Times that the size of each effect is chosen anew beside the others'; not tuned. Numerical."""

#: logarithm of the range of the noise's size; derived
NOISE_RANGE = float(np.log(TAUS[-1] / CONSTANTS.least_noise))


def over_sizes(gain: FloatArray) -> FloatArray:
    """Average over tau of log densities ``gain`` (taus, ...), one less axis: (...,)."""
    weighed = gain + LOG_PRIOR.reshape(-1, *(1,) * (gain.ndim - 1))
    top = weighed.max(axis=0)
    return np.asarray(np.log(np.exp(weighed - top).sum(axis=0)) + top)


def log_noise_prior(
    variance: FloatArray, dof: IntArray, tolerated: FloatArray
) -> FloatArray:
    """Log prior (m,) of noise variances V > 1 (m,) with the width that ``dof`` rows leave them.

    Uniform in the logarithm of the extra scatter n = √(V - 1): rare where nothing is in the model,
    and as likely as none while n is what a formula may be off by, ``tolerated``.
    """
    extra = np.maximum(variance - 1.0, 1e-12)
    width = np.sqrt(4 * np.pi / np.maximum(dof, 1)) * variance / (2 * extra)
    rare = CONSTANTS.odds_rare * np.minimum(1.0, width / NOISE_RANGE)
    span = np.log(np.maximum(tolerated / CONSTANTS.least_noise, 1.0))
    inside = np.sqrt(extra) <= tolerated
    allowed = np.where(inside, 0.5 * np.minimum(1.0, width / np.maximum(span, 1e-12)), 0.0)
    return np.asarray(np.log(np.maximum(rare, allowed)))


def over_noise(
    stated: FloatArray, larger: FloatArray, variance: FloatArray, dof: IntArray,
    tolerated: FloatArray,
) -> FloatArray:
    """Average of log densities at V = 1 and, where it is larger, at the V that the rows ask for.

    All arrays (m,): the densities at both, V in units of the stated variance, degrees of freedom,
    and the extra scatter that is tolerated, in sds.
    """
    more = larger + log_noise_prior(variance, dof, tolerated)
    return np.asarray(np.where(variance > 1.0, np.logaddexp(stated, more), stated))


def block_log_densities(
    strength: FloatArray, amplitude: FloatArray, chi2: FloatArray, dof: IntArray
) -> FloatArray:
    """Log density of the residual under each of m single blocks, (m,).

    Parameters
    ----------
    strength, amplitude : array, shape (m, v)
        Signal along each visible direction for unit tau, and the residual along it; both zero
        where a block has fewer directions.
    chi2, dof : array, shape (m,)
        Of the whole projected residual that each is weighed on.
    """
    seen = (strength > 0).sum(axis=1)
    drop = (amplitude**2).sum(axis=1)
    variance = np.maximum((chi2 - drop) / np.maximum(dof - seen, 1), 1.0)
    tolerated = CONSTANTS.tolerance * np.sqrt(drop / np.maximum(dof, 1))

    def at(v: FloatArray, some: BoolArray | slice) -> FloatArray:
        signal = (TAUS[:, None, None] * strength[some]) ** 2 / v[None, :, None]
        gain = 0.5 * amplitude[some] ** 2 / v[:, None] * signal / (1 + signal)
        gain -= 0.5 * np.log1p(signal)
        return over_sizes(gain.sum(axis=2)) - 0.5 * (dof[some] * np.log(v) + chi2[some] / v)

    density = at(np.ones_like(variance), slice(None))
    more = variance > 1.0
    if more.any():
        density[more] = over_noise(
            density[more], at(variance[more], more), variance[more], dof[more], tolerated[more]
        )
    return density


def nothing_log_density(chi2: float, dof: int) -> tuple[float, float]:
    """Log density when nothing is in the set: with the stated noise, and with larger noise."""
    variance = chi2 / max(dof, 1)
    stated = -0.5 * chi2
    if variance <= 1.0:
        return stated, -np.inf
    larger = -0.5 * (dof * np.log(variance) + dof)
    prior = log_noise_prior(np.array(variance), np.array(dof), np.zeros(()))
    return stated, float(larger + prior)


@dataclass(frozen=True, eq=False)
class Sets:
    """B sets of blocks of equal ``sizes``, their numbers of columns.

    Parameters
    ----------
    gram, product : array, shapes (B, p, p) and (B, p)
        ``XᵀX`` and ``Xᵀr`` of the blocks' columns side by side.
    chi2, dof : array, shape (B,)
        Of the whole projected residual of each.
    sizes : tuple of int
    """

    gram: FloatArray
    product: FloatArray
    chi2: FloatArray
    dof: IntArray
    sizes: tuple[int, ...]

    @cached_property
    def solution(self) -> FloatArray:
        """The columns' least-squares coefficients, (B, p), in sds of the rows."""
        p = self.product.shape[1]
        ridge = 1e-9 * np.trace(self.gram, axis1=1, axis2=2) / p
        matrix = self.gram + ridge[:, None, None] * np.eye(p)
        return np.asarray(np.linalg.solve(matrix, self.product[:, :, None])[:, :, 0])

    @property
    def drop(self) -> FloatArray:
        """What they take off chi-square, (B,), no unit."""
        return np.asarray((self.product * self.solution).sum(axis=1))

    @property
    def variance(self) -> FloatArray:
        """The noise variance V that the rows ask for, (B,), over the stated: no unit."""
        rest = self.dof - self.product.shape[1]
        return np.asarray(np.maximum((self.chi2 - self.drop) / np.maximum(rest, 1), 1.0))

    def take(self, some: IntArray) -> "Sets":
        """These of the sets alone."""
        return Sets(self.gram[some], self.product[some], self.chi2[some], self.dof[some],
                    self.sizes)


def set_log_densities(sets: Sets) -> FloatArray:
    """Log density of the residual under each of B sets, every block with a size of its own, (B,).
    """
    variance = sets.variance
    more = np.flatnonzero(variance > 1.0)
    # With the stated noise, and where the rows ask for it with larger noise, as one stack.
    both = np.concatenate([np.arange(len(variance)), more])
    at = np.concatenate([np.ones_like(variance), variance[more]])
    density, _ = _at_variance(sets.take(both), at)
    density, larger = density[: len(variance)], density[len(variance) :]
    if len(more):
        some = sets.take(more)
        tolerated = CONSTANTS.tolerance * np.sqrt(
            np.maximum(some.drop, 0.0) / np.maximum(some.dof, 1)
        )
        density[more] = over_noise(
            density[more], larger, variance[more], some.dof, tolerated
        )
    return density


def likeliest_sizes(sets: Sets) -> tuple[FloatArray, FloatArray]:
    """The likeliest tau of every block, (B, blocks), and V with them, (B,); no unit."""
    variance = np.where(sets.dof > sets.product.shape[1], sets.variance, 1.0)
    return _at_variance(sets, variance)[1], variance


def _at_variance(sets: Sets, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """:func:`set_log_densities` at V (B,), each tau averaged with the others at their best; taus.
    """
    sizes, ends = np.array(sets.sizes), np.cumsum(sets.sizes)
    where = [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]
    gram = sets.gram / variance[:, None, None]
    h = sets.product / variance[:, None]
    taus = np.stack(
        [np.sqrt(np.mean(sets.solution[:, part] ** 2, axis=1)) for part in where], axis=1
    )
    taus = np.clip(taus, 1.0, TAUS[-1])
    averaged, density = np.zeros_like(taus), np.zeros(len(variance))
    base = -0.5 * (sets.dof * np.log(variance) + sets.chi2 / variance)
    delta = (TAUS**-2.0 - TAUS[-1] ** -2.0)[:, None, None]
    for _ in range(SWEEPS if len(sizes) > 1 else 1):
        for k, part in enumerate(where):
            precision = np.repeat(taus**-2.0, sizes, axis=1)
            precision[:, part] = TAUS[-1] ** -2.0
            inverse = np.linalg.inv(gram + precision[:, :, None] * np.eye(len(h[0])))
            _, log_det = np.linalg.slogdet(inverse)
            estimate = (inverse @ h[:, :, None])[:, :, 0]
            if sizes[k] == 1:
                m, q = inverse[:, part, part][:, :, 0], estimate[:, part]
            else:
                m, turn = np.linalg.eigh(inverse[:, part, part])
                q = (turn.swapaxes(1, 2) @ estimate[:, part, None])[:, :, 0]
            m = np.maximum(m, 0.0)
            grid = (
                -0.5 * np.log1p(delta * m) - 0.5 * delta * q**2 / (1 + delta * m)
            ).sum(axis=2) - sizes[k] * np.log(TAUS)[:, None]
            best = grid.argmax(axis=0)
            at_best = grid[best, np.arange(len(best))]
            taus[:, k] = TAUS[best]
            averaged[:, k] = over_sizes(grid) - at_best
            others = np.log(taus) @ sizes - sizes[k] * np.log(taus[:, k])
            pulled = (h * estimate).sum(axis=1)
            density = base + 0.5 * log_det + 0.5 * pulled + at_best - others
    return density + averaged.sum(axis=1), taus
