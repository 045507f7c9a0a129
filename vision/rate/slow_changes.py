"""The mean rate of a clip beside slow changes of it: an even drift, the end of a start or a stop.

The rate of a motor that warms up drifts, and the angle contains c t²/2 besides the line and the
waves (``vision.rate.terms``). A motor that starts approaches its rate ever more slowly; what is
left of that at the beginning of the steady part lowers the rate. The angle then contains, at either
end,

    θ(t) = ... + a e^(-(t - t_0)/τ)

with a and τ unknown, and no drift but one of most of the clip. The rates for all τ are averaged
with their posterior probabilities (Hoeting et al., Bayesian model averaging, 1999), so that the sd
includes the uncertainty of τ. The shortest τ are equivalent to no transient.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from vision.geometry import FloatArray
from vision.rate.least_squares import LeastSquares, least_squares
from vision.rate.terms import DRIFT, Regressors, usual_sizes

TIME_CONSTANTS = 8  #: numerical: tried at either end; 6 or 12 give the same
NONE = 1e-6  #: share of the usual drift that is none; numerical
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
    fit: LeastSquares, x: FloatArray, angle_rad: FloatArray, base: Regressors, ends: MovingEnds
) -> SlowRate:
    """The rate by the fit of a clip, or beside the transients of the ends of a part.

    Parameters
    ----------
    fit : LeastSquares
        Fit of the angles; rows that it set aside stay aside.
    x : array, shape (n, k)
        Its columns; column 1 is the time.
    angle_rad : array, shape (n,)
    base : Regressors
        Of the rows.
    ends : MovingEnds
    """
    length = float(np.ptp(base.time_s))
    if not any(ends[:2]):
        return _averaged([fit], np.ones(1), length)
    x, y, time_s = x[fit.used], angle_rad[fit.used], base.time_s[fit.used]
    decays = np.geomspace(2 * length / (len(y) - 1), LONGEST * length, TIME_CONSTANTS)
    transients = [[np.exp(-from_end / tau)[:, None] for tau in decays] if moves else [x[:, :0]]
                  for from_end, moves in zip((time_s - time_s[0], time_s[-1] - time_s), ends[:2],
                                             strict=True)]
    usual = np.append(usual_sizes(base, x.shape[1]), np.full(sum(ends[:2]), np.inf))
    if not ends[2]:
        usual[DRIFT] *= NONE
    fits = [least_squares(np.column_stack([x, *pair]), y, usual) for pair in product(*transients)]
    best = min(fits, key=lambda one: one.noise)
    # Likelihood, for the number of independent rows.
    weight = np.array([one.noise / best.noise for one in fits]) ** (
        -len(y) / best.correlation_time)
    return _averaged(fits, weight / weight.sum(), length)


def _averaged(fits: Sequence[LeastSquares], weight: FloatArray, length_s: float) -> SlowRate:
    """The rate and its change over a clip, as the mean of fits with weights, (m,)."""
    values, sds = (np.array([part[[1, DRIFT]] for part in parts]) for parts in (
        [fit.beta for fit in fits], [fit.sd for fit in fits]))
    rate, slope = mean = weight @ values
    rate_sd, slope_sd = np.sqrt(weight @ (sds**2 + (values - mean) ** 2))
    return SlowRate(float(rate), float(rate_sd), float(slope / rate * length_s),
                    float(slope_sd / abs(rate) * length_s))
