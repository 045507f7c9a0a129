"""The rows at one estimate."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from calib.fit.rows.sensitive_axes import Axes
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class WhitenedRows:
    """Whitened rows at one estimate.

    ``residual`` (r,), ``jacobian`` (r, p + q) with the q common errors last, ``vector`` (n, 3) the
    corrected vectors, ``slope`` (n, 3, 3) what effects that follow the vector make of its changes
    (None without such effects), ``axes_there`` gives the sensitive axes. The first rows are the
    magnitude rows, then the null rows, then the priors.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray
    slope: FloatArray | None
    axes_there: Callable[[], Axes]

    @cached_property
    def axes(self) -> Axes:
        """The sensitive axes at the estimate."""
        return self.axes_there()

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.residual @ self.residual)
