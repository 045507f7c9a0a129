"""Noise density, bias instability, random walk and rate ramp from an Allan variance.

Generalised least squares of the Allan variances on the columns of :mod:`calib.noise.spectra`, no
square below zero, weighted by the covariance of the estimates under the fitted noise, which is
iterated. A coefficient whose square is not above zero by its own scatter is reported as an upper
limit.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from calib.noise.allan import LONGEST, AllanCurve, allan_variances, averaging_factors, curve
from calib.noise.spectra import FLICKER, NAMES, variance_columns, variance_covariance
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

ITERATIONS = 6  #: of the weights; numerical limit
OPTIONAL = ("quantisation", "rate_ramp")
"""What few sensors show, and what takes from the random walk and the density beside it."""

OPTIONAL_SDS = 4.0  #: without which they are left out of the fit
SEEN_SDS = 2.0  #: a square smaller than this many of its sds is not seen
LIMIT_SDS = 1.645  #: of an upper limit at 95 %
SMALLEST_SHARE = 1e-6  #: of a variance, added so that correlations of nearly 1 have an inverse


@dataclass(frozen=True)
class NoiseCoefficient:
    """One coefficient of IEEE Std 952, SI units.

    Attributes
    ----------
    value, sd : float or None
        None where the log does not show it.
    limit : float
        What it is then below at 95 %.
    needed_s : float or None
        Length of a log that would show it if it were half the limit, s; None where a longer log is
        no help.
    """

    value: float | None
    sd: float | None
    limit: float
    needed_s: float | None


@dataclass(frozen=True, eq=False)
class AxisNoise:
    """The noise of one axis.

    Attributes
    ----------
    curve : AllanCurve
        n averaging times.
    fitted : array, shape (n,)
        The fitted curve.
    parts : array, shape (n, 5)
        Fitted Allan variances of each process, in the order of ``NAMES``.
    coefficients : mapping of str to NoiseCoefficient
    """

    curve: AllanCurve
    fitted: FloatArray
    parts: FloatArray
    coefficients: Mapping[str, NoiseCoefficient]


def axis_noise(readings: FloatArray, step_s: float) -> AxisNoise:
    """The noise of one axis.

    Parameters
    ----------
    readings : array, shape (t,)
        At rest, evenly sampled, SI units.
    step_s : float
        Interval between samples.

    Returns
    -------
    AxisNoise

    Source
    ------
    IEEE Std 952-1997, annex C; NIST SP 1065 for the degrees of freedom.
    """
    count = len(readings)
    factors = averaging_factors(count)
    variances = allan_variances(readings, step_s, factors)
    columns = variance_columns(factors, step_s)
    record = _Record(variances, variance_columns(factors, step_s), factors, step_s, count)
    columns = record.columns
    kept = np.array([name not in OPTIONAL for name in NAMES])
    squares, _ = record.fit(kept)
    every, sds = record.step(squares, np.ones(len(NAMES), bool))
    kept |= every > OPTIONAL_SDS * sds
    squares, sds = record.fit(kept)
    parts = columns * squares
    names = [NAMES[i] for i in np.argmax(parts, axis=1)]
    coefficients = {
        name: _coefficient(i, squares, sds, record)
        for i, name in enumerate(NAMES)
    }
    return AxisNoise(curve(variances, factors, step_s, count, names), np.sqrt(parts.sum(axis=1)),
                     parts, coefficients)


@dataclass(frozen=True, eq=False)
class _Record:
    """Allan variances (n,) of one axis, and what the processes make of them per unit, (n, 5)."""

    variances: FloatArray
    columns: FloatArray
    factors: IntArray
    step_s: float
    count: int

    def fit(self, kept: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Squares of the coefficients and their sds, each (5,), of those that are ``kept``."""
        shares = self.columns * kept / self.variances[:, None]
        squares = np.asarray(nnls(shares, np.ones(len(shares)))[0])
        for _ in range(ITERATIONS):
            squares, sds = self.step(squares, kept)
        return squares, sds

    def step(self, squares: FloatArray, kept: BoolArray) -> tuple[FloatArray, FloatArray]:
        """The fit under the scatter that these ``squares`` make; sds of all five."""
        whiten = self.whitening(squares)
        whitened = whiten @ self.columns
        size = np.linalg.norm(whitened, axis=0)
        fitted = nnls(whitened / size * kept, whiten @ self.variances)[0] / size
        return np.asarray(fitted), self.sds(squares, kept)

    def sds(self, squares: FloatArray, kept: BoolArray) -> FloatArray:
        """Sds (5,) of the squares; of one that is not kept the sd that it would have beside."""
        whitened = self.whitening(squares) @ self.columns
        size = np.linalg.norm(whitened, axis=0)
        sds = np.empty(len(size))
        for i in range(len(size)):
            beside = kept.copy()
            beside[i] = False
            unit = (whitened / size)[:, [i, *np.flatnonzero(beside)]]
            sds[i] = math.sqrt(np.linalg.pinv(unit.T @ unit)[0, 0]) / size[i]
        return sds

    def whitening(self, squares: FloatArray) -> FloatArray:
        """The matrix (n, n) that makes the variances' scatter white and of size 1."""
        cov = variance_covariance(self.factors, self.step_s, self.count,
                                  dict(zip(NAMES, squares, strict=True)))
        scale = np.sqrt(np.diag(cov))
        shares = cov / np.outer(scale, scale) + SMALLEST_SHARE * np.eye(len(scale))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(shares)) / scale)


def _coefficient(
    i: int, squares: FloatArray, sds: FloatArray, record: _Record
) -> NoiseCoefficient:
    square, sd = float(squares[i]), float(sds[i])
    if square > SEEN_SDS * sd:
        value = math.sqrt(square)
        return NoiseCoefficient(value, sd / (2 * value), math.sqrt(square + LIMIT_SDS * sd), None)
    largest = square + LIMIT_SDS * sd
    for _ in range(ITERATIONS):  # the scatter is that of a coefficient as large as the limit
        supposed = squares.copy()
        supposed[i] = largest
        largest = square + LIMIT_SDS * float(record.sds(supposed, squares > 0)[i])
    limit = math.sqrt(largest)
    return NoiseCoefficient(None, None, limit, _needed(
        NAMES[i], limit, squares, record.count * record.step_s))


def _needed(name: str, limit: float, squares: FloatArray, length_s: float) -> float | None:
    """Length of a log in which half the limit would dominate the white noise at the longest τ."""
    white = float(squares[NAMES.index("noise_density")])
    half = (limit / 2) ** 2
    if name == "bias_instability":
        tau = white / (FLICKER * half)
    elif name == "random_walk":
        tau = math.sqrt(3 * white / half)
    else:
        return None
    return float(max(LONGEST * tau, 2 * length_s))
