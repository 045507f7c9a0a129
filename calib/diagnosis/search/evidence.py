"""Evidence of a set of hypotheses about what is left in the residual, in closed form.

A block is a hypothesis with columns X; a set of blocks is a covariance of the projected residual:

    r ~ N(0, V I + Σ_k tau_k² X_k X_kᵀ)

tau_k the root mean square signal of block k in noise units, V = 1 where the stated noise holds and
larger where something else is left. Log densities are relative to those of unit rows without any
constant. They are averaged over tau = 1, 2, 4 ... and over V: no threshold is needed, parameters
that buy nothing cost, and nothing ties where p-values underflow. The prior of tau is a half-Cauchy
distribution (Gelman, Bayesian Analysis 1, 2006), whose tail is heavy enough for any signal.
"""

from collections.abc import Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.poses.imu_log import FloatArray

#: sizes of an effect, noise units, each twice the one before
TAUS = 2.0 ** np.arange(CONSTANTS.octaves_of_size)
HALF_CAUCHY = TAUS / (1.0 + (TAUS / CONSTANTS.typical_size) ** 2)
"""Derived: its density over the logarithm of tau, up to a factor."""

LOG_PRIOR = np.log(HALF_CAUCHY / HALF_CAUCHY.sum())

SWEEPS = 2
"""Times that the size of each effect is chosen anew beside the others'; not tuned."""

#: logarithm of the range of the noise's size
NOISE_RANGE = float(np.log(TAUS[-1] / CONSTANTS.least_noise))


def over_sizes(gain: FloatArray) -> FloatArray:
    """Average over tau, the first axis of ``gain``, of log densities."""
    weighed = gain + LOG_PRIOR.reshape(-1, *(1,) * (gain.ndim - 1))
    top = weighed.max(axis=0)
    return np.asarray(np.log(np.exp(weighed - top).sum(axis=0)) + top)


def log_noise_prior(variance: FloatArray, dof: int, tolerated: FloatArray) -> FloatArray:
    """Log prior of a noise variance V > 1 with the width that ``dof`` rows leave it.

    Uniform in the logarithm of the extra scatter n = √(V - 1): rare where nothing is in the model,
    and as likely as none while n is what a formula may be off by, ``tolerated``.
    """
    extra = np.maximum(variance - 1.0, 1e-12)
    width = np.sqrt(4 * np.pi / max(dof, 1)) * variance / (2 * extra)
    rare = CONSTANTS.odds_rare * np.minimum(1.0, width / NOISE_RANGE)
    span = np.log(np.maximum(tolerated / CONSTANTS.least_noise, 1.0))
    inside = np.sqrt(extra) <= tolerated
    allowed = np.where(inside, 0.5 * np.minimum(1.0, width / np.maximum(span, 1e-12)), 0.0)
    return np.asarray(np.log(np.maximum(rare, allowed)))


def over_noise(
    stated: FloatArray, larger: FloatArray, variance: FloatArray, dof: int, tolerated: FloatArray
) -> FloatArray:
    """Average of log densities at V = 1 and at the V that the rows ask for, where it is larger."""
    more = larger + log_noise_prior(variance, dof, tolerated)
    return np.asarray(np.where(variance > 1.0, np.logaddexp(stated, more), stated))


def block_log_densities(
    strength: FloatArray, amplitude: FloatArray, chi2: float, dof: int
) -> FloatArray:
    """Log density of the residual under each of m single blocks, (m,).

    Parameters
    ----------
    strength, amplitude : array, shape (m, v)
        Signal along each visible direction for unit tau, and the residual along it; both zero
        where a block has fewer directions.
    chi2, dof : float, int
        Of the whole projected residual.
    """
    seen = (strength > 0).sum(axis=1)
    drop = (amplitude**2).sum(axis=1)
    variance = np.maximum((chi2 - drop) / np.maximum(dof - seen, 1), 1.0)
    tolerated = CONSTANTS.tolerance * np.sqrt(drop / max(dof, 1))

    def at(v: FloatArray) -> FloatArray:
        signal = (TAUS[:, None, None] * strength) ** 2 / v[None, :, None]
        gain = 0.5 * amplitude**2 / v[:, None] * signal / (1 + signal) - 0.5 * np.log1p(signal)
        return over_sizes(gain.sum(axis=2)) - 0.5 * (dof * np.log(v) + chi2 / v)

    stated = at(np.ones_like(variance))
    if not (variance > 1.0).any():
        return stated
    return over_noise(stated, at(variance), variance, dof, tolerated)


def nothing_log_density(chi2: float, dof: int) -> tuple[float, float]:
    """Log density when nothing is in the set: with the stated noise, and with larger noise."""
    variance = chi2 / max(dof, 1)
    stated = -0.5 * chi2
    if variance <= 1.0:
        return stated, -np.inf
    larger = -0.5 * (dof * np.log(variance) + dof)
    prior = log_noise_prior(np.array(variance), dof, np.zeros(()))
    return stated, float(larger + prior)


def set_log_density(
    gram: FloatArray, product: FloatArray, chi2: float, dof: int, sizes: Sequence[int]
) -> float:
    """Log density of the residual under a set of blocks, each with a size of its own.

    Parameters
    ----------
    gram, product : array, shapes (p, p) and (p,)
        ``XᵀX`` and ``Xᵀr`` of the blocks' columns side by side.
    chi2, dof : float, int
        Of the whole projected residual.
    sizes : sequence of int
        Number of columns of each block.
    """
    p = len(product)
    ridge = 1e-9 * float(np.trace(gram)) / p
    solution = np.asarray(np.linalg.solve(gram + ridge * np.eye(p), product), dtype=float)
    drop = float(product @ solution)
    variance = max((chi2 - drop) / max(dof - p, 1), 1.0)
    stated, _ = _at_variance(gram, product, chi2, dof, sizes, solution, 1.0)
    if variance <= 1.0:
        return stated
    larger, _ = _at_variance(gram, product, chi2, dof, sizes, solution, variance)
    tolerated = np.array(CONSTANTS.tolerance * np.sqrt(max(drop, 0.0) / max(dof, 1)))
    return float(
        over_noise(np.array(stated), np.array(larger), np.array(variance), dof, tolerated)
    )


def likeliest_sizes(
    gram: FloatArray, product: FloatArray, chi2: float, dof: int, sizes: Sequence[int]
) -> tuple[FloatArray, float]:
    """The likeliest tau of every block, and the noise variance V that goes with them.

    The parameters are those of :func:`set_log_density`.
    """
    p = len(product)
    ridge = 1e-9 * float(np.trace(gram)) / p
    solution = np.asarray(np.linalg.solve(gram + ridge * np.eye(p), product), dtype=float)
    rest = (chi2 - float(product @ solution)) / max(dof - p, 1)
    variance = max(rest if dof > p else 1.0, 1.0)
    _, taus = _at_variance(gram, product, chi2, dof, sizes, solution, variance)
    return taus, variance


def _at_variance(
    gram: FloatArray,
    product: FloatArray,
    chi2: float,
    dof: int,
    sizes: Sequence[int],
    solution: FloatArray,
    variance: float,
) -> tuple[float, FloatArray]:
    """:func:`set_log_density` at one V, each tau averaged with the others at their best; taus."""
    h, ends = product / variance, np.cumsum(sizes)
    where = [slice(end - size, end) for end, size in zip(ends, sizes, strict=True)]
    taus = np.array([max(1.0, float(np.sqrt(np.mean(solution[part] ** 2)))) for part in where])
    taus = np.minimum(taus, TAUS[-1])
    averaged = np.zeros(len(sizes))
    base = -0.5 * (dof * np.log(variance) + chi2 / variance)
    density = 0.0
    for _ in range(SWEEPS if len(sizes) > 1 else 1):
        for k, part in enumerate(where):
            precision = np.repeat(taus**-2.0, sizes)
            precision[part] = TAUS[-1] ** -2.0
            inverse = np.linalg.inv(gram / variance + np.diag(precision))
            _, log_det = np.linalg.slogdet(inverse)
            estimate = inverse @ h
            m, turn = np.linalg.eigh(inverse[part, part])
            m = np.maximum(m, 0.0)
            q = turn.T @ estimate[part]
            delta = TAUS[:, None] ** -2.0 - TAUS[-1] ** -2.0
            grid = (
                -0.5 * np.log1p(delta * m) - 0.5 * delta * q**2 / (1 + delta * m)
            ).sum(axis=1) - sizes[k] * np.log(TAUS)
            best = int(np.argmax(grid))
            taus[k] = TAUS[best]
            averaged[k] = float(over_sizes(grid)) - grid[best]
            others = float((np.log(taus) * sizes).sum() - sizes[k] * np.log(taus[k]))
            density = base + 0.5 * log_det + 0.5 * float(h @ estimate) + grid[best] - others
    return float(density + averaged.sum()), taus
