"""The rows at one estimate."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.fit.rows.model_terms import ModelTerms
from calib.fit.rows.sensitive_axes import Axes, axes_of
from calib.fit.stacked import Stacked
from calib.poses.imu_log import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class WhitenedRows(Stacked):
    """Whitened rows at one estimate for each set, or for one set without the leading axis.

    ``residual`` (..., r), ``jacobian`` (..., r, p + q) with the q common errors last, ``vector``
    (..., n, 3) the corrected vectors, ``slope`` (..., n, 3, 3) what effects that follow the vector
    make of its changes (None without such effects), ``of_reading`` (..., p') the parameters of the
    reading there, ``points`` (..., w k, 3) the corrected points of the rings of a leaning plate
    (None on a level one). The first rows are the magnitude rows, then the null rows, the wave rows
    and the priors. All are NaN where no true vectors belong to the estimate.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray
    slope: FloatArray | None
    of_reading: FloatArray
    terms: ModelTerms
    points: FloatArray | None = None

    @cached_property
    def axes(self) -> Axes:
        """The sensitive axes at the estimate."""
        return axes_of(self.terms.matrix(self.of_reading))

    @property
    def is_solved(self) -> BoolArray:
        """Whether true vectors belong to the estimate, (...,)."""
        return np.asarray(np.isfinite(self.residual).all(axis=-1))

    @property
    def chi2(self) -> FloatArray:
        """Sum of the squared whitened residuals, (...,)."""
        return np.asarray((self.residual**2).sum(axis=-1))
