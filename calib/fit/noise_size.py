"""Size of the noise, from the stated sds and from the residual of the rows.

The residual of n degrees of freedom has V times the stated variance. The sds say V = 1 with ν
degrees of freedom, so that the density is Student's and with Q the sum of its squares

    E V = (ν - 2 + Q) / (ν - 2 + n),

where the sds contain Student's factor (:mod:`calib.poses.averaging.mean_noise`); or V is larger,
for whatever reason, and is estimated from the rows. Both are weighed, so that no fixed level
decides where a misfit begins.
"""

from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray

LEAST_EXTRA = 0.35  #: least extra scatter, stated sds; derived: 6 % more than stated
LARGEST_OCTAVE = 14
"""Octaves of stated sds up to which extra scatter and effects are weighed: 16384 sds. Derived: no
signal is stronger."""

ODDS_RARE = 0.04
"""Odds of events that happen once in some evenings: noise larger than stated, a step of the bias, a
bad pose, a plate that scatters. Tuned on ``tests.bench.study_diagnosis``."""

FORMULA_ERROR = 0.03  #: share of its signal by which a formula may be off; tuned

#: logarithm of the range of the extra scatter; definition
EXTRA_RANGE = float(np.log(2.0**LARGEST_OCTAVE / LEAST_EXTRA))


@dataclass(frozen=True, eq=False)
class Noise:
    """Knowledge of the noise of one set of rows, or of S.

    Parameters
    ----------
    dof : int or array, shape (S,)
        Degrees of freedom that are left for it.
    freedom : float or array, shape (S,)
        ν, those that stand behind the stated sds.
    is_known : bool or array, shape (S,)
        False where V = 1 was read off the residual itself.
    """

    dof: int | IntArray
    freedom: float | FloatArray
    is_known: bool | np.ndarray = True

    def log_density(
        self, q: FloatArray, log_det: FloatArray | float, chi2: float | FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Log densities (B,) with the stated noise and with larger noise.

        ``q`` (B,) is the rest of ``chi2`` after a set of effects, ``log_det`` (B,) the cost of its
        sizes.
        """
        q = np.maximum(q, 0.0)
        rows = np.maximum(self.dof, 1)
        degrees = 0.5 * (self.freedom + self.dof)
        stated = -0.5 * log_det - degrees * np.log1p(q / self.freedom)
        variance = q / rows
        v = np.maximum(variance, 1.0)  # q / V is ``rows`` where V is larger than stated
        larger = (-0.5 * log_det - 0.5 * self.dof * np.log(v)
                  - degrees * np.log1p(rows / self.freedom))
        tolerated = FORMULA_ERROR * np.sqrt(np.maximum(chi2 - q, 0.0) / rows)
        larger = larger + _log_prior_of_larger(v, rows, tolerated)
        return np.asarray(stated), np.where((variance > 1.0) & self.is_known, larger, -np.inf)

    def log_odds_unlike(self, q: float, chi2: float) -> float:
        """Log odds of effects that something unlike any formula imitates, against true ones.

        ``q`` is the rest of ``chi2`` after these effects. What imitates leaves any share of itself,
        one as likely as another, but more than a formula may be off by. Beside that both are as
        likely.
        """
        rows, at = np.maximum(self.dof, 1), np.array([q])
        extra, whole = max(q / rows - 1.0, 0.0), max(chi2 - q, 0.0) / rows
        if not self.is_known or not (
                max(FORMULA_ERROR**2 * whole, LEAST_EXTRA**2) < extra < whole):
            return -np.inf
        stated, larger = self.log_density(at, 0.0, chi2)
        tolerated = FORMULA_ERROR * np.sqrt([whole])
        free = larger - _log_prior_of_larger(at / rows, rows, tolerated)
        width = np.sqrt(np.pi / rows) * (q / rows) / np.sqrt(extra)
        share = np.log(min(1.0, width / np.sqrt(whole)))
        return float((free + share - np.logaddexp(stated, larger))[0])

    def nothing(self, chi2: float) -> tuple[float, float]:
        """Log densities of a residual with no effect in the set: stated, and larger noise."""
        stated, larger = self.log_density(np.array([chi2]), 0.0, chi2)
        return float(stated[0]), float(larger[0])

    def expected_variance(
        self, q: float | FloatArray, chi2: float | FloatArray | None = None
    ) -> FloatArray:
        """Mean of V, no unit, (B,), where a set of effects leaves ``q`` (B,) of ``chi2``.

        1 where the sds were estimated from the residual.
        """
        q = np.asarray(q)
        stated, larger = self.log_density(q, 0.0, q if chi2 is None else chi2)
        share = 1 / (1 + np.exp(np.minimum(stated - larger, 700.0)))
        before = np.maximum(self.freedom - 2.0, 0.0)
        as_stated = (before + q) / np.maximum(before + self.dof, 1.0)
        shown = np.maximum(q / np.maximum(self.dof, 1), 1.0)
        return np.where(self.is_known, as_stated + share * (shown - as_stated), 1.0)


def _log_prior_of_larger(
    variance: FloatArray, rows: int | IntArray, tolerated: FloatArray
) -> FloatArray:
    """Log prior (B,) of noise variances V > 1 (B,), with the width that ``rows`` leave them.

    Uniform in the logarithm of the extra scatter n = √(V - 1): rare where the model is empty, and
    as likely as none while n is within the error of a formula, ``tolerated``.
    """
    extra = np.maximum(variance - 1.0, 1e-12)
    width = np.sqrt(4 * np.pi / rows) * variance / (2 * extra)
    rare = ODDS_RARE * np.minimum(1.0, width / EXTRA_RANGE)
    span = np.log(np.maximum(tolerated / LEAST_EXTRA, 1.0))
    inside = np.sqrt(extra) <= tolerated
    allowed = np.where(inside, 0.5 * np.minimum(1.0, width / np.maximum(span, 1e-12)), 0.0)
    return np.asarray(np.log(np.maximum(rare, allowed)))
