"""The mean rate of a clip beside slow changes of it: an even drift, the end of a start or a stop.

The rate of a motor that warms up drifts, and the angle contains c t²/2 besides the line and the
waves; c has a Gaussian prior, without which it stands in a clip of two turns for whatever bends the
angle. A motor that starts approaches its rate ever more slowly; what is left of that at the
beginning of the steady part lowers the rate. The angle then contains, at either end,

    θ(t) = ... + a e^(-(t - t_0)/τ)

with a and τ unknown, and no drift but one of most of the clip. The rates for all τ are averaged
with their posterior probabilities (Hoeting et al., Bayesian model averaging, 1999), so that the sd
includes the uncertainty of τ. The shortest τ are equivalent to no transient.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import LeastSquares, correlation_time, least_squares

USUAL_CHANGE = 0.003
"""Sd of the even relative change over a clip before the data. Judgement: a third of the largest one
of a constant rate."""
TIME_CONSTANTS = 8  #: numerical: tried at either end; 6 or 12 give the same
LONGEST = 0.25
"""Longest time constant of a transient, as a share of the part. Derived: within four time constants
98 % have decayed, and the line beside it is visible."""
#: Whether the plate has another rate before and after the part, and drifts within it.
MovingEnds = tuple[bool, bool, bool]


@dataclass(frozen=True)
class SlowRate:
    """The mean rate, rad/s and signed, and its even relative change over the clip, with sds."""

    rate_rad_s: float
    sd_rad_s: float
    change: float
    change_sd: float


def slow_rate(
    fit: LeastSquares, x: FloatArray, angle_rad: FloatArray, time_s: FloatArray, drift: int,
    ends: MovingEnds,
) -> SlowRate:
    """The rate by the fit of a clip, or beside the transients of the ends of a part.

    Parameters
    ----------
    fit : LeastSquares
        Fit of the angles; rows that it set aside stay aside.
    x : array, shape (n, k)
        Its columns; column 1 is the time.
    angle_rad, time_s : array, shape (n,)
        Angles, and times of the rows.
    drift : int
        The column of the drift; 0 without one.
    ends : MovingEnds
        Whether there may be a transient at the beginning, and at the end; and a drift beside them.
    """
    length = float(np.ptp(time_s))
    if not any(ends[:2]):
        rate, sd = float(fit.beta[1]), float(fit.sd[1])
        if not drift:
            return SlowRate(rate, sd, 0.0, 0.0)
        known = fit.cov[drift] / (fit.cov[drift, drift] + (USUAL_CHANGE * rate / length) ** 2)
        beta = fit.beta - known * fit.beta[drift]
        rest = (angle_rad - x @ beta)[fit.used]
        wider = (rest @ rest) * correlation_time(rest) / (
            (fit.residual[fit.used] ** 2).sum() * fit.correlation_time)
        variance = max(wider, 1.0) * np.diag(fit.cov - np.outer(known, fit.cov[drift]))
        sd, slope_sd = np.sqrt(variance[[1, drift]])
        rate = float(beta[1])
        return SlowRate(rate, float(sd), float(beta[drift] / rate * length),
                        float(slope_sd / abs(rate) * length))
    x, y, time_s = x[fit.used], angle_rad[fit.used], time_s[fit.used]
    if drift and not ends[2]:
        x = np.delete(x, drift, axis=1)
    decays = np.geomspace(2 * length / (len(y) - 1), LONGEST * length, TIME_CONSTANTS)
    transients = [[np.exp(-from_end / tau)[:, None] for tau in decays] if moves else [x[:, :0]]
                  for from_end, moves in zip((time_s - time_s[0], time_s[-1] - time_s), ends[:2],
                                             strict=True)]
    fits = [least_squares(np.column_stack([x, *pair]), y) for pair in product(*transients)]
    best = min(fits, key=lambda one: one.noise)
    # Likelihood, for the number of independent rows.
    weight = np.array([one.noise / best.noise for one in fits]) ** (
        -len(y) / best.correlation_time)
    weight /= weight.sum()

    def averaged(column: int) -> tuple[float, float]:
        values, sds = np.array([(one.beta[column], one.sd[column]) for one in fits]).T
        mean = float(weight @ values)
        return mean, float(np.sqrt(weight @ (sds**2 + (values - mean) ** 2)))

    rate, sd = averaged(1)
    slope, slope_sd = averaged(drift) if ends[2] else (0.0, 0.0)
    return SlowRate(rate, sd, slope / rate * length, slope_sd / abs(rate) * length)
