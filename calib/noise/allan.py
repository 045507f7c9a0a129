"""The overlapping Allan deviation with its confidence, by allantools.

The band of each point is that of chi-square with the equivalent degrees of freedom of Greenhall and
Riley (NIST SP 1065, section 5.4.1), for the noise that dominates there.
"""

from dataclasses import dataclass

import allantools
import numpy as np

from calib.poses.imu_log import FloatArray, IntArray

PER_OCTAVE = 2  #: averaging times per factor of two; numerical
LONGEST = 8
"""Averages of at most a record's length over this. Derived: longer ones have fewer than ten degrees
of freedom, and their scatter is not Gaussian."""
NOISE_TYPES = {"quantisation": 2, "noise_density": 0, "bias_instability": -1, "random_walk": -2,
               "rate_ramp": -2}
"""The exponent of frequency of each process, as :func:`allantools.edf_greenhall` takes it.
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
