"""A common size and a spread of sizes: random-effects meta-analysis.

Sensor i has the size ``b_i ~ N(μ, τ²)`` and states ``y_i ~ N(b_i, v_i)``. With
``w_i = 1/(v_i + τ²)``

    μ = Σ w y / Σ w,     τ² = Σ w² ((y - μ)² - v) / Σ w² + 1 / Σ w

the second iterated: restricted maximum likelihood (Viechtbauer, J. Educ. Behav. Stat. 30, 261-293,
2005), from the moment estimate of DerSimonian and Laird (Control. Clin. Trials 7, 177-188, 1986).
The sd of μ is widened where the sensors scatter more than that (Hartung and Knapp, Stat. Med. 20,
3875-3889, 2001, never narrowed: Röver et al., BMC Med. Res. Methodol. 15:99, 2015).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from calib.poses.imu_log import FloatArray

STEPS = 200
"""Steps of the iteration for τ², which converges linearly; a fact of no consequence beyond 50.
Numerical."""

AT_REST = 1e-8
"""Relative change of τ² + median v at which it stops: far below its sd. Derived. Numerical."""


@dataclass(frozen=True)
class RandomEffects:
    """Common size of n sensors, and their spread.

    Parameters
    ----------
    sensors : int
    mean, mean_sd : float
        μ and its sd.
    spread, spread_sd : float
        τ and its sd; the sd is that of an upper limit where τ is 0.
    p_same : float
        Probability of values that differ so much if all were the same size (Cochran's Q).
    """

    sensors: int
    mean: float
    mean_sd: float
    spread: float
    spread_sd: float
    p_same: float


def random_effects(value: FloatArray, variance: FloatArray) -> RandomEffects:
    """Fit a common size and a spread of sizes.

    Parameters
    ----------
    value, variance : array, shape (n,)
        What each of n ≥ 1 sensors states, and the square of its sd.

    Returns
    -------
    RandomEffects

    Examples
    --------
    >>> alike = random_effects(np.array([1.0, 1.1, 0.9]), np.full(3, 0.25))
    >>> round(alike.mean, 3), alike.spread
    (1.0, 0.0)
    """
    n = len(value)
    weight = 1 / variance
    q = float((weight * (value - weight @ value / weight.sum()) ** 2).sum())
    excess = weight.sum() - (weight**2).sum() / weight.sum()
    tau2 = max(0.0, (q - (n - 1)) / excess) if n > 1 else 0.0
    scale = float(np.median(variance))
    for _ in range(STEPS if n > 1 else 0):
        before, tau2 = tau2, _following(value, variance, tau2)
        if abs(tau2 - before) < AT_REST * (tau2 + scale):
            break
    w = 1 / (variance + tau2)
    mean = float(w @ value / w.sum())
    scatter = float((w * (value - mean) ** 2).sum() / (n - 1)) if n > 1 else 1.0
    square, cube = (w**2).sum(), (w**3).sum()
    information = 0.5 * (square - 2 * cube / w.sum() + (square / w.sum()) ** 2)
    tau2_sd = 1 / np.sqrt(information) if n > 1 else np.inf
    spread = float(np.sqrt(tau2))
    return RandomEffects(
        sensors=n,
        mean=mean,
        mean_sd=float(np.sqrt(max(scatter, 1.0) / w.sum())),
        spread=spread,
        spread_sd=float(min(tau2_sd / (2 * spread) if spread else np.inf, np.sqrt(tau2_sd))),
        p_same=float(chdtrc(n - 1, q)) if n > 1 else 1.0,
    )


def _following(value: FloatArray, variance: FloatArray, tau2: float) -> float:
    w = 1 / (variance + tau2)
    mean = w @ value / w.sum()
    square = w**2
    return max(0.0, float((square * ((value - mean) ** 2 - variance)).sum() / square.sum()
                          + 1 / w.sum()))
