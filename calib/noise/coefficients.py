"""Noise density, bias instability, random walk and rate ramp from an Allan variance.

Generalised least squares of the Allan variances on the columns of :mod:`calib.noise.allan`, with no
square below zero, weighted by the covariance of the estimates under the fitted noise, iteratively.
A coefficient whose square does not exceed zero by its own scatter is reported as an upper limit.

The upper limit inverts a test: L is the smallest coefficient beyond which less than 5 % of all logs
would show as little as this log. The mean and scatter of the estimate are those of noise with the
coefficient L; the other coefficients are fitted along with it. If the log shows less than
a share LUCK of such logs would, it counts as showing that much, so that a lucky record does not
lower the limit (power-constrained limit of Cowan et al., arXiv:1105.3166).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, nnls
from scipy.special import ndtri

from calib.noise.allan import (
    FLICKER,
    LONGEST,
    NAMES,
    AllanCurve,
    VarianceModel,
    allan_variances,
    averaging_factors,
    curve,
)
from calib.poses.imu_log import BoolArray, FloatArray

ITERATIONS = 6  #: steps of the weights; twice as many change no digit, two are too few; numerical
OPTIONAL = ("quantisation", "rate_ramp")
"""Coefficients that few sensors show, and that correlate with random walk and density."""

OPTIONAL_SDS = 4.0  #: with fewer they are left out of the fit; derived: 1 in 30,000 of a normal one
SEEN_SDS = 2.0  #: a square of fewer sds is not seen; derived: 1 in 44 of a normal variable
RISK = 0.05  #: chance that a coefficient is beyond its upper limit; fact: results.json states it so
LUCK = 0.16  #: share of logs where noise shows so little; derived: one sd below, as Cowan et al.
PRECISION = 1e-3  #: relative, of the square of an upper limit; numerical
LARGEST_FACTOR = 1e6  #: square of a limit over the estimate and its sd, at most; numerical
SMALLEST_SHARE = 1e-6
"""Share of a variance that is added, so that correlations of nearly 1 have an inverse; and of the
white noise that the curve allows, so that the noise of a pure ramp has some scatter. Ten times less
or more changes no printed digit. Numerical."""

WHITE = NAMES.index("noise_density")


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

    Source
    ------
    IEEE Std 952-1997, annex C; NIST SP 1065 for the degrees of freedom.
    """
    count = len(readings)
    factors = averaging_factors(count)
    variances = allan_variances(readings, step_s, factors)
    record = _Record(variances, _model(count, step_s))
    kept = np.array([name not in OPTIONAL for name in NAMES])
    squares, _ = record.fit(kept)
    every, sds = record.step(squares, np.ones(len(NAMES), bool))
    kept |= every > OPTIONAL_SDS * sds
    squares, sds = record.fit(kept)
    parts = record.model.columns * squares
    names = [NAMES[i] for i in np.argmax(parts, axis=1)]
    coefficients = {name: _coefficient(i, squares, sds, kept, record)
                    for i, name in enumerate(NAMES)}
    return AxisNoise(curve(variances, factors, step_s, count, names), np.sqrt(parts.sum(axis=1)),
                     parts, coefficients)


@lru_cache(maxsize=1)
def _model(count: int, step_s: float) -> VarianceModel:
    """The model of a record; the axes of one log share it."""
    return VarianceModel(averaging_factors(count), step_s, count)


@dataclass(frozen=True, eq=False)
class _Record:
    """Allan variances (n,) of one axis, and the model of their mean and scatter."""

    variances: FloatArray
    model: VarianceModel

    def fit(self, kept: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Squares of the coefficients and their sds, each (5,), of those that are ``kept``."""
        shares = self.model.columns * kept / self.variances[:, None]
        squares = np.asarray(nnls(shares, np.ones(len(shares)))[0])
        for _ in range(ITERATIONS):
            squares, sds = self.step(squares, kept)
        return squares, sds

    def step(self, squares: FloatArray, kept: BoolArray) -> tuple[FloatArray, FloatArray]:
        """The fit weighted by the scatter under these ``squares``; sds of all five."""
        fitted = self.beside(np.zeros(len(squares)), self.whitening(squares), kept)
        return fitted, self.sds(squares, kept)

    def beside(self, fixed: FloatArray, whiten: FloatArray, free: BoolArray) -> FloatArray:
        """Squares (5,): the ``fixed`` ones, and the ``free`` ones fitted, none below zero."""
        columns = whiten @ self.model.columns
        size = np.linalg.norm(columns, axis=0)
        left_over = whiten @ (self.variances - self.model.columns @ fixed)
        return np.asarray(fixed + nnls(columns / size * free, left_over)[0] / size)

    def sds(self, squares: FloatArray, kept: BoolArray) -> FloatArray:
        """Sds (5,) of the squares; for one that is not kept, the sd it would have if added."""
        whiten = self.whitening(squares)
        return np.array([np.linalg.norm(self.weights(i, whiten, kept))
                         for i in range(len(squares))])

    def weights(self, i: int, whiten: FloatArray, beside: BoolArray) -> FloatArray:
        """Weights (n,) on the whitened variances in the estimate of square i beside the others."""
        columns = whiten @ self.model.columns
        size = np.linalg.norm(columns, axis=0)
        others = [j for j in np.flatnonzero(beside) if j != i]
        return np.asarray(np.linalg.pinv((columns / size)[:, [i, *others]])[0] / size[i])

    def whitening(self, squares: FloatArray) -> FloatArray:
        """The matrix (n, n) that makes the variances' scatter white and of size 1."""
        white = SMALLEST_SHARE * float(np.min(self.variances / self.model.columns[:, WHITE]))
        cov = self.model.covariance(np.where(np.arange(len(squares)) == WHITE,
                                             np.maximum(squares, white), squares))
        scale = np.sqrt(np.diag(cov))
        shares = cov / np.outer(scale, scale) + SMALLEST_SHARE * np.eye(len(scale))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(shares)) / scale)

    def excess(self, i: int, square: float, kept: BoolArray) -> float:
        """Number of sds by which the log shows more of coefficient i than RISK of all logs would.

        The logs are of noise with this ``square``. The log does not choose the others: all
        that are ``kept`` are fitted along with it, otherwise the risk would be larger.
        """
        fixed = np.zeros(len(kept))
        fixed[i] = square
        free = kept & (np.arange(len(kept)) != i)
        supposed = self.beside(fixed, np.diag(1 / self.variances), free)
        for _ in range(ITERATIONS // 2):
            whiten = self.whitening(supposed)
            supposed = self.beside(fixed, whiten, free)
        weights = self.weights(i, whiten, free)
        sd = float(np.linalg.norm(weights))
        shown = max(float(weights @ whiten @ self.variances) / sd, float(ndtri(LUCK)))
        return shown - square / sd - float(ndtri(RISK))


def _coefficient(
    i: int, squares: FloatArray, sds: FloatArray, kept: BoolArray, record: _Record
) -> NoiseCoefficient:
    square, sd = float(squares[i]), float(sds[i])
    limit = math.sqrt(_largest(i, square, sd, kept, record))
    if square > SEEN_SDS * sd:
        value = math.sqrt(square)
        return NoiseCoefficient(value, sd / (2 * value), limit, None)
    return NoiseCoefficient(None, None, limit, _needed(
        NAMES[i], limit, squares, record.model.length_s))


def _largest(i: int, square: float, sd: float, kept: BoolArray, record: _Record) -> float:
    """Square beyond which this log is among the share RISK of logs that show so little."""
    low, high = 0.0, square + sd
    while record.excess(i, high, kept) > 0 and high < LARGEST_FACTOR * (square + sd):
        low, high = high, 2 * high
    if high >= LARGEST_FACTOR * (square + sd):
        return high
    return high * float(brentq(
        lambda share: record.excess(i, share * high, kept), low / high, 1.0, rtol=PRECISION))


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
