"""A fitted model, with everything that comparison and diagnosis need."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from calib.effects.effect import Effect
from calib.errors import Contradiction, FitFailed, Remedy
from calib.fit.column_scaling import inverse_square, pseudo_inverse, unit_columns
from calib.fit.identifiability import require_determined, require_enough
from calib.fit.model import Model
from calib.fit.residuals import Equations, WhitenedRows
from calib.fit.sensitive_axes import sensor_columns
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet

HUBER_SD = 1.5
"""Rows count in full up to here; beyond, their pull stays what it is here. At 1.5 the estimate is
3.6 % less efficient than least squares on pure noise."""

HUBER_VARIANCE = 0.7785
"""Mean of ψ² for standard normal noise, ``Φ(c) - Φ(-c) - 2cφ(c) + 2c²(1 - Φ(c))`` at 1.5."""

OUTLIER_SD = 4.0
"""Rows beyond are no noise of the stated sd: of normal rows one in 16000 is."""

LARGEST_REFERENCE_ERROR = 2.0
"""No plate turns, and no site has gravity, half or twice what was stated."""


MISFIT_P_VALUE = 0.005
"""The one level at which "the stated noise explains the rows" is given up: both triads of a session
together raise a false alarm in one session of a hundred."""

UNDETERMINED_SHARE = 0.02
"""A parameter is seen by itself when no more of it than this lies outside what was fitted."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Where a solver ended.

    ``theta`` (p,), ``eta`` (q,), the rows there, ``weight`` (r,) of every row and the number of
    iterations.
    """

    theta: FloatArray
    eta: FloatArray
    rows: WhitenedRows
    weight: FloatArray
    iterations: int

    @property
    def cost(self) -> float:
        """Weighted sum of squares."""
        return float(self.weight @ self.rows.residual**2)


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model, with everything that comparison and diagnosis need.

    ``theta`` (p,), ``cov`` (p, p) from the stated sds, ``common_shift`` (p, q) how far one sd of
    each common error of the references moves theta, ``eta`` (q,) those errors in their sds,
    ``shapes`` fitted shape parameters with their sd, ``rows`` at the solution,
    ``weight`` (r,) what the robust loss left of each row (1 without it), ``basis`` (p, v) the
    combinations of parameters that these poses see and that were fitted.
    """

    poses: PoseSet
    model: Model
    theta: FloatArray
    cov: FloatArray
    common_shift: FloatArray
    eta: FloatArray
    shapes: Mapping[str, float]
    shape_sd: Mapping[str, float]
    equations: Equations
    rows: WhitenedRows
    weight: FloatArray
    basis: FloatArray
    iterations: int

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return self.rows.chi2

    @property
    def bounded_chi2(self) -> float:
        """Chi-square in which a row counts as the loss bounds it; :attr:`chi2` of plain squares.

        ``Σ ψ²`` over its expected value for noise, so that one bad pose that the robust loss has
        set aside does not widen the sds of all.
        """
        if not self.is_robust:
            return self.chi2
        data = slice(self.equations.data_count)
        bounded = self.weight * self.rows.residual
        prior = self.rows.residual[self.equations.data_count :]
        return float((bounded[data] ** 2).sum() / HUBER_VARIANCE + prior @ prior)

    @property
    def bounded_p_value(self) -> float:
        """:attr:`p_value` of :attr:`bounded_chi2`."""
        return float(fdtrc(self.dof, self.poses.noise_dof, self.bounded_chi2 / self.dof))

    @property
    def p_value(self) -> float:
        """Probability of a residual this large when the model and the stated sds are right.

        The sds come from the same samples with ``noise_dof`` degrees of freedom, so chi-square
        over its degrees of freedom is an F ratio.
        """
        return float(fdtrc(self.dof, self.poses.noise_dof, self.chi2 / self.dof))

    @property
    def dof(self) -> int:
        """Data rows less parameters; the prior rows pay for the common errors."""
        return int(self.equations.data_count - self.basis.shape[1] - len(self.shapes))

    @property
    def sensed(self) -> FloatArray:
        """What each sensitive axis felt in every pose, all errors taken off, SI, (n, 3)."""
        return self.rows.axes.sensed(self.rows.vector)

    def columns_of(self, effect: Effect, shape: float | None = None) -> FloatArray:
        """Columns of ``effect`` at the solution, where and on what it acts.

        Parameters
        ----------
        effect : Effect
            In the model or not.
        shape : float, optional
            Value of its shape parameter.

        Returns
        -------
        array, shape (n, 3, k) or (n, k)
            Error of the vector (of an effect on the reading: of the nominal reading), or of the
            reference magnitude, per unit of each parameter.
        """
        equations = self.equations
        if effect.acts_on != "sensor":
            return effect.evaluate(equations.at_reading, shape)
        at = equations.conditions(self.rows.vector)
        shapes = {} if shape is None else {effect.name: shape}
        return sensor_columns((effect,), at, shapes, self.rows.axes)

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
    solution: Solution,
    basis: FloatArray,
    shapes: Mapping[str, float] | None = None,
) -> Fit:
    """Check that the solution is determined and finite, and give it its covariance."""
    require_enough(equations, basis.shape[1] + len(shapes or {}))
    rows, weight = solution.rows, solution.weight
    require_determined(equations, rows, basis)
    p = equations.model.size
    full = with_common(basis, len(solution.eta))
    inverse = inverse_square(rows.jacobian @ full * np.sqrt(weight)[:, None])
    cov = full @ inverse @ full.T
    if not (np.isfinite(solution.theta).all() and np.isfinite(cov).all()):
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended without finite parameters. Check the "
            f"log for poses that are not what they should be."
        )
    require_size(equations, rows)
    return Fit(
        poses=equations.poses,
        model=equations.model,
        theta=solution.theta,
        cov=cov[:p, :p] + _pull_of_outliers(rows, weight, cov)[:p, :p],
        common_shift=cov[:p, p:],
        eta=solution.eta,
        shapes=dict(shapes or {}),
        shape_sd={},
        equations=equations,
        rows=rows,
        weight=weight,
        basis=basis,
        iterations=solution.iterations,
    )


def _pull_of_outliers(rows: WhitenedRows, weight: FloatArray, cov: FloatArray) -> FloatArray:
    """What rows that are no noise may still move the estimate by, as a covariance like ``cov``.

    Huber's loss bounds the pull of a row at ``HUBER_SD``, whatever its residual: it is no noise of
    the row any more, and of either sign.
    """
    bounded = (weight < 1) & (np.abs(rows.residual) > OUTLIER_SD)
    if not bounded.any():
        return np.zeros_like(cov)
    pull = np.where(bounded, weight * rows.residual, 0.0)
    pulled = cov @ (rows.jacobian * pull[:, None]).T
    return np.asarray(pulled @ pulled.T)


def require_size(equations: Equations, rows: WhitenedRows) -> None:
    """Refuse the trivial solution: gains of nothing fit a reference that an effect took to zero."""
    size = np.linalg.norm(rows.vector[equations.magnitude], axis=1)
    stated = equations.poses.reference.magnitude[equations.magnitude]
    share = float(np.median(size / stated)) if len(stated) else 1.0
    if not 1 / LARGEST_REFERENCE_ERROR < share < LARGEST_REFERENCE_ERROR:
        if not equations.on_reference:
            raise Contradiction(
                f"{equations.poses.triad}: no gain fits all poses: fitted, their typical reading "
                f"is {share:.2g} times the stated reference. The references of some poses "
                f"contradict those of the others, or their readings do: check the rate of each "
                f"run, and whether all files are of one sensor at one range."
            )
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended at {share:.2g} times the stated "
            f"reference: an effect on the reference has taken the gains along with it. Remove it: "
            f"these poses cannot separate it from the scale.",
            Remedy("remove_effect", equations.poses.triad),
        )


def with_shape_sd(fit: Fit, columns: FloatArray) -> Fit:
    """``fit`` with its shape parameters as further unknowns.

    ``columns`` (r, k) are the derivatives of the residual by them, zero for one that is held.
    """
    full = with_common(fit.basis, len(fit.eta))
    root = np.sqrt(fit.weight)[:, None]
    inverse = pseudo_inverse(np.column_stack([fit.rows.jacobian @ full, columns]) * root)
    cov = inverse @ inverse.T
    p, fitted = fit.model.size, full.shape[1]
    sd = np.where(columns.any(axis=0), np.sqrt(np.diag(cov)[fitted:]), np.nan)
    linear = full @ cov[:fitted, :fitted] @ full.T
    pull = _pull_of_outliers(fit.rows, fit.weight, linear)
    return replace(
        fit,
        cov=(linear + pull)[:p, :p],
        common_shift=linear[:p, p:],
        shape_sd=dict(zip(fit.shapes, map(float, sd), strict=True)),
    )


def with_common(basis: FloatArray, common: int) -> FloatArray:
    """``basis`` (p, v) extended by the ``common`` errors, which are always fitted."""
    p, v = basis.shape
    full = np.zeros((p + common, v + common))
    full[:p, :v] = basis
    full[p:, v:] = np.eye(common)
    return full
