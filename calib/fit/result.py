"""A fitted model, with everything that comparison and diagnosis need."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.errors import FitFailed
from calib.fit.column_scaling import unit_columns
from calib.fit.identifiability import require_determined, require_enough
from calib.fit.model import Model
from calib.fit.residuals import Equations, Rows
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet

LARGEST_REFERENCE_ERROR = 2.0
"""No plate turns, and no site has gravity, half or twice what was stated."""


UNDETERMINED_SHARE = 0.02
"""A parameter is seen by itself when no more of it than this lies outside what was fitted."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model, with everything that comparison and diagnosis need.

    ``theta`` (p,), ``cov`` (p, p) from the stated sds, ``eta`` (q,) common errors of the
    references, ``shapes`` fitted shape parameters with their sd, ``rows`` at the solution,
    ``weight`` (r,) what the robust loss left of each row (1 without it), ``basis`` (p, v) the
    combinations of parameters that these poses see and that were fitted.
    """

    poses: PoseSet
    model: Model
    theta: FloatArray
    cov: FloatArray
    eta: FloatArray
    shapes: Mapping[str, float]
    shape_sd: Mapping[str, float]
    equations: Equations
    rows: Rows
    weight: FloatArray
    basis: FloatArray
    iterations: int

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return self.rows.chi2

    @property
    def dof(self) -> int:
        """Data rows less parameters; the prior rows pay for the common errors."""
        return int(self.equations.data_count - self.basis.shape[1] - len(self.shapes))

    @property
    def pushed(self) -> FloatArray:
        """What each axis itself felt in every pose, all errors taken off, SI, (n, 3).

        ``M^-1 s``, with M of the linear form ``M y + c``, which is affine in the readings y.
        """
        y, equations = self.poses.reading, self.equations
        linear = y - equations.reading_columns @ self.theta[equations.reading_index]
        affine = np.linalg.lstsq(np.column_stack([y, np.ones(len(y))]), linear)[0]
        return np.asarray(np.linalg.solve(affine[:3].T, self.rows.vector.T).T)

    @property
    def residual_si(self) -> FloatArray:
        """Residual of every data row in SI units, (r - q,)."""
        return np.asarray(self.rows.residual[: self.equations.data_count] * self.equations.row_sd)

    @property
    def determined(self) -> BoolArray:
        """Which parameters the poses see by themselves, not only in combination, (p,)."""
        q, _ = np.linalg.qr(unit_columns(self.basis)[0])
        return np.asarray((q**2).sum(axis=1) > 1 - UNDETERMINED_SHARE)

    @property
    def is_robust(self) -> bool:
        """Whether the robust loss took weight off a row."""
        return bool((self.weight < 1).any())

    @property
    def residual_rms(self) -> float:
        """Root mean square of the data rows' residuals, SI."""
        return float(np.sqrt(np.mean(self.residual_si**2)))


def finish(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    rows: Rows,
    weight: FloatArray,
    basis: FloatArray,
    iterations: int,
    shapes: Mapping[str, float] | None = None,
) -> Fit:
    """Check that the solution is determined and finite, and give it its covariance."""
    require_enough(equations, basis.shape[1] + len(shapes or {}))
    require_determined(equations, rows, basis)
    p = equations.model.size
    full = with_common(basis, len(eta))
    jacobian = (rows.jacobian @ full) * np.sqrt(weight)[:, None]
    unit, scale = unit_columns(jacobian)
    r = np.linalg.qr(unit, mode="r")
    inverse = np.linalg.inv(r) / scale[:, None]
    cov = (full @ (inverse @ inverse.T) @ full.T)[:p, :p]
    if not (np.isfinite(theta).all() and np.isfinite(cov).all()):
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended without finite parameters. Check the "
            f"log for poses that are not what they should be."
        )
    require_size(equations, rows)
    return Fit(
        poses=equations.poses,
        model=equations.model,
        theta=theta,
        cov=cov,
        eta=eta,
        shapes=dict(shapes or {}),
        shape_sd={},
        equations=equations,
        rows=rows,
        weight=weight,
        basis=basis,
        iterations=iterations,
    )


def require_size(equations: Equations, rows: Rows) -> None:
    """Refuse the trivial solution: gains of nothing fit a reference that an effect took to zero."""
    size = np.linalg.norm(rows.vector[equations.magnitude], axis=1)
    stated = equations.poses.reference.magnitude[equations.magnitude]
    share = float(np.median(size / stated)) if len(stated) else 1.0
    if not 1 / LARGEST_REFERENCE_ERROR < share < LARGEST_REFERENCE_ERROR:
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended at {share:.2g} times the stated "
            f"reference: an effect on the reference has taken the gains along with it. Remove it "
            f"(`pipeline remove`); these poses do not tell it from the scale."
        )


def with_shape_sd(found: Fit, cov: FloatArray, shape_sd: Mapping[str, float]) -> Fit:
    """``found`` with the covariance widened by its fitted shape parameters."""
    return replace(found, cov=cov, shape_sd=dict(shape_sd))


def with_common(basis: FloatArray, common: int) -> FloatArray:
    """``basis`` (p, v) extended by the ``common`` errors, which are always fitted."""
    p, v = basis.shape
    full = np.zeros((p + common, v + common))
    full[:p, :v] = basis
    full[p:, v:] = np.eye(common)
    return full
