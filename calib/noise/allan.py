"""Overlapping Allan deviation, and its expectation under the noise processes of IEEE Std 952.

The band of each point is that of chi-square with the equivalent degrees of freedom of Greenhall and
Riley (NIST SP 1065, section 5.4.1), for the noise that dominates there.

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
from dataclasses import dataclass

import allantools
import numpy as np

from calib.poses.imu_log import FloatArray, IntArray

PER_OCTAVE = 2  #: averaging times per factor of two; numerical
LONGEST = 8
"""Longest averages, as the record's length over this. Derived: longer ones have fewer than ten
degrees of freedom, and their scatter is not Gaussian."""
NOISE_TYPES = {"quantisation": 2, "noise_density": 0, "bias_instability": -1, "random_walk": -2,
               "rate_ramp": -2}
"""Exponent of the frequency for each process, as :func:`allantools.edf_greenhall` takes it.
Definition."""


@dataclass(frozen=True, eq=False)
class AllanCurve:
    """Allan deviations of one axis.

    ``factors`` (n,) samples in each average, ``tau_s`` (n,), ``deviation`` (n,) in the unit of the
    readings, ``low`` and ``high`` (n,) their band of 68 %.
    """

    factors: IntArray
    tau_s: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray


def averaging_factors(count: int) -> IntArray:
    """Samples in each average (n,), spaced by their logarithm, of ``count`` samples."""
    octaves = np.log2(max(count // LONGEST, 1))
    steps = np.arange(0, PER_OCTAVE * octaves + 1e-9)
    return np.unique(np.round(2 ** (steps / PER_OCTAVE)).astype(int))


def allan_variances(readings: FloatArray, step_s: float, factors: IntArray) -> FloatArray:
    """Overlapping Allan variances (n,) of one axis (t,), in the square of its unit."""
    tau, deviation, _, _ = allantools.oadev(
        readings - readings.mean(), rate=1 / step_s, data_type="freq", taus=factors * step_s)
    if len(tau) != len(factors):
        raise AssertionError(f"{len(tau)} of {len(factors)} averaging times were evaluated")
    return np.asarray(deviation, float) ** 2


def curve(
    variances: FloatArray, factors: IntArray, step_s: float, count: int, dominating: list[str]
) -> AllanCurve:
    """The deviations with their bands; ``dominating`` (n) names the process at each time."""
    deviation = np.asarray(np.sqrt(variances), np.float64)
    bands = []
    for value, m, name in zip(deviation, factors, dominating, strict=True):
        edf = allantools.edf_greenhall(
            alpha=NOISE_TYPES[name], d=2, m=int(m), N=count + 1, overlapping=True)
        bands.append(allantools.confidence_interval(float(value), edf))
    low, high = np.array(bands, np.float64).T
    return AllanCurve(factors, np.asarray(factors * step_s, np.float64), deviation,
                      low, high)


FLICKER = 2 * math.log(2) / math.pi
"""Allan variance of flicker noise over B² at times of many samples: IEEE Std 952. Definition."""

NAMES = ("quantisation", "noise_density", "bias_instability", "random_walk", "rate_ramp")
FREQUENCIES = 6000  #: frequencies of the integral, spaced by their logarithm; numerical
LOWEST = 0.02  #: lowest frequency in inverse lengths of the record; numerical


class VarianceModel:
    """Mean and scatter of the Allan variances of records of one length, for any noise in them.

    The spectral density is a sum over the processes: the means are linear in the squares of their
    coefficients, and the covariance is a quadratic form, whose matrices are computed once.
    ``columns`` (n, 5) are the variances per unit of the square of each coefficient of
    :data:`NAMES`. A ramp is no random process and scatters nothing.

    Parameters
    ----------
    factors : array of int, shape (n,)
        Samples in each average.
    step_s : float
    count : int
        Samples in the record.
    """

    def __init__(self, factors: IntArray, step_s: float, count: int) -> None:
        self.length_s = count * step_s
        f = np.geomspace(LOWEST / self.length_s, 0.5 / step_s, FREQUENCIES)
        sine = np.sin(np.pi * f * step_s)
        self._densities = np.stack([4 * sine**2 / step_s, np.ones_like(f), 1 / (2 * np.pi * f),
                                    step_s**2 / (4 * sine**2)])
        self._filters = np.stack([2 * np.sin(np.pi * f * m * step_s) ** 4 / (m * sine) ** 2
                                  for m in factors])
        self._widths = 2 * f * np.gradient(np.log(f))  # df = f d(log f), and both signs of f
        m = factors.astype(float)
        tau = m * step_s
        # In closed form where there is one; sampled flicker ends at the Nyquist frequency.
        flicker = self._filters @ (self._widths * self._densities[2])
        self.columns = np.stack([3 / tau**2, 1 / tau, flicker,
                                 tau / 3 * (1 + 1 / (2 * m**2)), tau**2 / 2], axis=1)
        used = count - 2 * np.minimum(factors[:, None], factors[None]) + 1  # the longer of two
        weighted = self._filters * np.sqrt(2 * self._widths) * self._densities[:, None]
        self._products = np.einsum("inf,jmf->ijnm", weighted, weighted,
                                   optimize=True) / (used * step_s)

    def covariance(self, squares: FloatArray) -> FloatArray:
        """Covariance (n, n) of the variances for the squares (5,) of the coefficients, any unit."""
        random = squares[: len(self._products)]
        return np.asarray(np.einsum("i,j,ijnm->nm", random, random, self._products))
