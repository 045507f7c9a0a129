"""What the noise processes of IEEE Std 952 make of an Allan variance, and how much it scatters.

With two-sided densities S(f) and τ = m Δ,

    white          S = N²                  σ² = N²/τ
    flicker        S = B²/(2π|f|)          σ² = (2 ln 2/π) B²
    random walk    S = K²/(2πf)²           σ² = K² τ/3 · (1 + 1/(2m²))
    rate ramp      deterministic           σ² = R² τ²/2
    quantisation   S = (2πf)² Q² τ0        σ² = 3 Q²/τ²

The overlapping estimator is the mean square of the record filtered by
``|H_m(f)|² = 2 sin⁴(π f τ)/(m sin(π f Δ))²``; two averages so have the covariance
``(2/T) ∫ |H_1|² |H_2|² S² df`` over all frequencies, which holds for τ well below T.
"""

import math
from collections.abc import Mapping

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray

FLICKER = 2 * math.log(2) / math.pi  #: IEEE Std 952: Allan variance of flicker noise over B²
NAMES = ("quantisation", "noise_density", "bias_instability", "random_walk", "rate_ramp")
FREQUENCIES = 6000  #: of the integral, spaced by their logarithm
LOWEST = 0.02  #: of the frequencies, times the inverse of the record's length


def variance_columns(factors: IntArray, step_s: float) -> FloatArray:
    """Allan variance per unit of the square of each coefficient of :data:`NAMES`, (n, 5)."""
    m = factors.astype(float)
    tau = m * step_s
    return np.stack([3 / tau**2, 1 / tau, np.full(len(m), FLICKER),
                     tau / 3 * (1 + 1 / (2 * m**2)), tau**2 / 2], axis=1)


def variance_covariance(
    factors: IntArray, step_s: float, count: int, squares: Mapping[str, float]
) -> FloatArray:
    """Covariance (n, n) of the Allan variances of a record.

    Parameters
    ----------
    factors : array of int, shape (n,)
        Samples in each average.
    step_s : float
    count : int
        Samples in the record.
    squares : mapping of name to float
        Squares of the coefficients; those of random processes count.

    Returns
    -------
    array, shape (n, n)
    """
    nyquist = 0.5 / step_s
    f = np.geomspace(LOWEST / (count * step_s), nyquist, FREQUENCIES)
    sine = np.sin(np.pi * f * step_s)
    density = (squares["noise_density"] + squares["bias_instability"] / (2 * np.pi * f)
               + squares["random_walk"] * step_s**2 / (4 * sine**2)
               + squares["quantisation"] * 4 * sine**2 / step_s)
    filters = np.stack([2 * np.sin(np.pi * f * m * step_s) ** 4 / (m * sine) ** 2
                        for m in factors])
    weighted = filters * density
    widths = f * np.gradient(np.log(f))  # df = f d(log f)
    integral = 2 * (weighted * widths) @ weighted.T  # both signs of f
    used = count - 2 * np.minimum(factors[:, None], factors[None]) + 1  # the longer of two means
    return np.asarray(2 * integral / (used * step_s))
