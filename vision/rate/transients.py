"""The rate of a part of a clip that begins after the motor's start or ends before its stop.

A motor approaches its rate ever more slowly; what is left of that at the beginning of the steady
part lowers the rate. The angle then holds besides the line and the waves, at either end,

    θ(t) = ... + a e^(-(t - t_0)/τ)

with a and τ unknown. The rates for all τ are averaged with their posterior probabilities (Hoeting
et al., Bayesian model averaging, 1999), so that the sd holds what the clip leaves open. The
shortest τ are as good as no transient.
"""

from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import LeastSquares, columns_of_unit_rms, least_squares

TIME_CONSTANTS = 8  #: numerical: tried at either end; 6 or 12 give the same


@dataclass(frozen=True)
class TransientThresholds:
    """What of a start or a stop is looked for in the part that is measured.

    Attributes
    ----------
    longest : float
        Share of the part that the longest time constant lasts. Derived: within four time constants
        98 % of a transient have died away, and the line beside it is seen.
    """

    longest: float = 0.25


THRESHOLDS = TransientThresholds()


@dataclass(frozen=True)
class MovingEnds:
    """Whether the plate has another rate before and after the part that is measured."""

    before: bool = False
    after: bool = False

    def __bool__(self) -> bool:
        return self.before or self.after


STEADY_ENDS = MovingEnds()


def rate_beside_transients(
    fit: LeastSquares,
    x: FloatArray,
    y: FloatArray,
    time_s: FloatArray,
    turn_rad: FloatArray,
    ends: MovingEnds,
) -> tuple[float, float]:
    """The rate with what is left of a start or a stop fitted beside it.

    Parameters
    ----------
    fit : LeastSquares
        Of the part, without transients; the rows that it set aside stay aside.
    x : array, shape (n, k)
        Its columns; column 1 is the time.
    y : array, shape (n,)
        Angle, rad.
    time_s : array, shape (n,)
        Of the rows, s.
    turn_rad : array, shape (n,)
        Angle of the plate on the fitted line.
    ends : MovingEnds
        At which ends there may be a transient.

    Returns
    -------
    rate, sd : float
        rad/s, the rate signed.
    """
    x, y, time_s, turn_rad = x[fit.used], y[fit.used], time_s[fit.used], turn_rad[fit.used]
    fits = [_TransientFit.of(x, pair, y) for pair in _transients(time_s, ends)]
    best = max(fits, key=lambda each: each.log_likelihood(len(y)))
    # How many rows carry the information of one, by what the best of the fits leaves.
    memory = float(least_squares(best.columns, y, turn_rad).cov[1, 1]) / best.variance
    log_weight = np.array([each.log_likelihood(len(y) / memory) for each in fits])
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    rates = np.array([each.rate for each in fits])
    rate = float(weight @ rates)
    variance = memory * np.array([each.variance for each in fits]) + (rates - rate) ** 2
    return rate, float(np.sqrt(weight @ variance))


def _transients(time_s: FloatArray, ends: MovingEnds) -> list[tuple[FloatArray, ...]]:
    """What may be left at the ends that move: decays of every time constant."""
    length = float(time_s[-1] - time_s[0])
    step = length / (len(time_s) - 1)
    decays = np.geomspace(2 * step, THRESHOLDS.longest * length, TIME_CONSTANTS)
    before = [(np.exp(-(time_s - time_s[0]) / tau),) for tau in decays] if ends.before else [()]
    after = [(np.exp(-(time_s[-1] - time_s) / tau),) for tau in decays] if ends.after else [()]
    return [first + last for first, last in product(before, after)]


@dataclass(frozen=True, eq=False)
class _TransientFit:
    """A fit with given transients: its rate, the variances of the rate and of a row, if white."""

    columns: FloatArray
    rate: float
    variance: float
    noise: float

    @classmethod
    def of(cls, x: FloatArray, transients: tuple[FloatArray, ...], y: FloatArray) -> Self:
        columns = np.column_stack([x, *transients])
        scaled, scale = columns_of_unit_rms(columns)
        covariance = np.linalg.pinv(scaled.T @ scaled)
        beta = covariance @ (scaled.T @ y)
        rest = y - scaled @ beta
        noise = float(rest @ rest) / (len(y) - len(scale))
        return cls(columns, float(beta[1] / scale[1]),
                   float(noise * covariance[1, 1] / scale[1] ** 2), noise)

    def log_likelihood(self, rows: float) -> float:
        """Logarithm of the likelihood if so many rows were independent."""
        return float(-0.5 * rows * np.log(self.noise))
