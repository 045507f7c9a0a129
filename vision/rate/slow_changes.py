"""The mean rate of a clip beside slow changes of it: an even drift, the end of a start or a stop.

The rate of a motor that warms up drifts, and the angle contains c t²/2 besides the line and the
waves. A motor that starts approaches its rate ever more slowly; what is left of that at the
beginning of the steady part lowers the rate. The angle then contains, at either end,

    θ(t) = ... + a e^(-(t - t_0)/τ)

with a and τ unknown, and no drift that these do not follow. The rates for all τ are averaged with
their posterior probabilities (Hoeting et al., Bayesian model averaging, 1999), so that the sd
includes the uncertainty of τ. The shortest τ are equivalent to no transient.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import LeastSquares, least_squares

TIME_CONSTANTS = 8  #: numerical: tried at either end; 6 or 12 give the same
LONGEST = 0.25
"""Longest time constant of a transient, as a share of the part. Derived: within four time constants
98 % have decayed, and the line beside it is visible."""
MovingEnds = tuple[bool, bool]  # whether the plate has another rate before and after the part


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
    ends : (bool, bool)
        Whether there may be a transient at the beginning, and at the end.
    """
    rate, sd = float(fit.beta[1]), float(fit.sd[1])
    length = float(np.ptp(time_s))
    if not any(ends):
        change = length / rate * np.array([fit.beta[drift], fit.sd[drift]]) * (drift > 0)
        return SlowRate(rate, sd, float(change[0]), abs(float(change[1])))
    x, y, time_s = x[fit.used], angle_rad[fit.used], time_s[fit.used]
    x = np.delete(x, drift, axis=1) if drift else x
    decays = np.geomspace(2 * length / (len(y) - 1), LONGEST * length, TIME_CONSTANTS)
    transients = [[np.exp(-from_end / tau)[:, None] for tau in decays] if moves else [x[:, :0]]
                  for from_end, moves in zip((time_s - time_s[0], time_s[-1] - time_s), ends,
                                             strict=True)]
    fits = [least_squares(np.column_stack([x, *pair]), y) for pair in product(*transients)]
    best = min(fits, key=lambda one: one.noise)
    noise, rates, sds = np.array([(one.noise, one.beta[1], one.sd[1]) for one in fits]).T
    # Likelihood, for the number of independent rows.
    weight = (noise / best.noise) ** (-len(y) / best.correlation_time)
    weight /= weight.sum()
    rate = float(weight @ rates)
    return SlowRate(rate, float(np.sqrt(weight @ (sds**2 + (rates - rate) ** 2))), 0.0, 0.0)
