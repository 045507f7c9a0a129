"""A fitted model, with everything that comparison and diagnosis need."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import fdtrc

from calib.effects.effect import Effect
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.linear import unit_columns
from calib.fit.model import Model
from calib.fit.rows.problem import Estimate, with_common
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.stacked import Stacked
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import is_free

HUBER_VARIANCE = 0.7785
"""Mean of ψ² for standard normal noise, ``Φ(c) - Φ(-c) - 2cφ(c) + 2c²(1 - Φ(c))`` at 1.5.
Definition."""

MISFIT_P_VALUE = 0.005
"""The one level at which "the stated noise explains the rows" is rejected: both triads of a session
together raise a false alarm in one session of a hundred. Derived."""

ONE_SESSION_OF = 2000
"""One in this many sessions with right sds causes a warning. Derived: both triads together then
take a fifth of the one in 200 that all warnings may take."""

PLAINLY = 1.5
"""Ratio of stated sds to right ones. A judgement: sds that contain a converter's steps and slow
noise at their largest are up to 1.3 times too large in sound sessions, and need no action."""


@dataclass(frozen=True, eq=False)
class Fit(Stacked):
    """A fitted model: of the n poses of a session, or of S sets of them with a leading axis.

    Its properties that describe one fit are for one set alone (:meth:`one`).

    Attributes
    ----------
    equations : Equations
        The r rows.
    at : Estimate
        The solution: theta (..., p), SI, in the order of the model, the common errors eta (..., q)
        in sds, the shape parameters by effect, and what the rows are there.
    weight : array, shape (..., r)
        What the robust loss left of each row; 1 without it.
    basis : array, shape (..., p, v)
        The combinations of parameters that were fitted; zero columns are none.
    cov : array, shape (..., p, p)
        Of theta, by the stated sds.
    common_shift : array, shape (..., p, q)
        How far one sd of each common error moves theta.
    log_shape_sd : mapping of str to array, shape (...,)
        Sds of the logarithms of fitted shape parameters if they had no bounds.
    iterations : int, or array of int, shape (S,)
    """

    equations: Equations
    at: Estimate
    weight: FloatArray
    basis: FloatArray
    cov: FloatArray
    common_shift: FloatArray
    log_shape_sd: Mapping[str, Any]
    iterations: Any

    def __len__(self) -> int:
        return len(self.equations.surroundings.sets)

    def one(self, k: int) -> "Fit":
        """The fit of set ``k`` as for one session, without the leading axis."""
        one = self.take(k)
        return replace(one, basis=one.basis[:, one.basis.any(axis=0)],
                       iterations=int(one.iterations))

    @property
    def poses(self) -> PoseSet:
        """The poses of the only set, or of the first."""
        return self.equations.poses

    @property
    def model(self) -> Model:
        """The model."""
        return self.equations.model

    @property
    def theta(self) -> FloatArray:
        """The parameters, SI, (..., p)."""
        return self.at.theta

    @property
    def eta(self) -> FloatArray:
        """The common errors in their sds, (..., q)."""
        return self.at.eta

    @property
    def shapes(self) -> Mapping[str, Any]:
        """The shape parameters by effect."""
        return self.at.shapes

    @property
    def rows(self) -> WhitenedRows:
        """The rows at the solution."""
        return self.at.rows

    @property
    def relative_misfit(self) -> float:
        """Residual of the magnitudes over these, root mean square, of one fit."""
        n, magnitude = self.equations.magnitude, self.poses.reference.magnitude
        off = self.rows.residual[: len(n)] * self.equations.magnitude_sd
        return float(np.sqrt(np.mean((off / magnitude[n]) ** 2))) if len(n) else 0.0

    @property
    def chi2(self) -> Any:
        """Sum of the squared whitened residuals; (S,) for S sets, as in all properties below."""
        return _number(self.rows.chi2)

    @property
    def dof(self) -> Any:
        """Data rows less parameters; the prior rows account for the common errors."""
        free = sum(map(is_free, self.poses.reference.common_names))
        fitted = self.basis.any(axis=-2).sum(axis=-1) + len(self.log_shape_sd) + free
        return _number(self.equations.data_count - fitted)

    @property
    def noise_dof(self) -> Any:
        """Degrees of freedom behind the sds of the poses."""
        every = [poses.noise_dof for poses in self.equations.surroundings.sets]
        return np.array(every) if self.theta.ndim > 1 else every[0]

    @property
    def p_value(self) -> Any:
        """Probability of residuals so large when the model and the stated sds are right.

        The sds come from the same samples with ``noise_dof`` degrees of freedom, so chi-square
        over its degrees of freedom is an F ratio.
        """
        return _number(fdtrc(self.dof, self.noise_dof, self.chi2 / self.dof))

    @property
    def sds_too_large(self) -> float | None:
        """Ratio of the sds of one set of poses to right ones if the residual is plainly too small
        for them, else None."""
        if not 0 < PLAINLY**2 * self.chi2 < self.dof or self.p_value <= 1 - 1 / ONE_SESSION_OF:
            return None
        return float(np.sqrt(self.dof / self.chi2))

    @property
    def bounded_chi2(self) -> float:
        """Chi-square with each row limited by the robust loss; :attr:`chi2` for plain squares.

        ``Σ ψ²`` over its expected value for noise, so that one bad pose that the robust loss has
        downweighted does not widen the sds of all.
        """
        if (self.weight == 1).all():
            return float(self.chi2)
        data = slice(self.equations.data_count)
        bounded = self.weight * self.rows.residual
        prior = self.rows.residual[self.equations.data_count :]
        return float((bounded[data] ** 2).sum() / HUBER_VARIANCE + prior @ prior)

    @property
    def bounded_p_value(self) -> float:
        """:attr:`p_value` of :attr:`bounded_chi2`."""
        return float(fdtrc(self.dof, self.noise_dof, self.bounded_chi2 / self.dof))

    @property
    def sensed(self) -> FloatArray:
        """Vectors of the sensitive axes in each pose, all errors removed, SI, shape (n, 3)."""
        return self.rows.axes.sensed(self.rows.vector)

    @cached_property
    def remembering(self) -> Equations:
        """The equations with the sensed vectors of the poses before, as the solution gives them."""
        return self.equations.after(self.sensed)

    def columns_of(self, effect: Effect, shape: float | None = None) -> FloatArray:
        """Columns of ``effect`` at the solution, at the place where it acts.

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
        """Residual of every data row in SI units (m/s² or rad/s), shape (r - q,)."""
        return np.asarray(self.rows.residual[: self.equations.data_count] * self.equations.row_sd)

    @property
    def determined(self) -> BoolArray:
        """Whether the poses see a parameter by itself, not only in combination, shape (p,)."""
        q, _ = np.linalg.qr(unit_columns(self.basis)[0])
        return np.asarray((q**2).sum(axis=1) > 1 - VISIBLE_SHARE)

    @property
    def directions(self) -> FloatArray:
        """Directions along which theta and eta were fitted, columns, in their units, (p + q, v +
        q)."""
        return with_common(self.basis, len(self.eta))

    @property
    def weighted_jacobian(self) -> FloatArray:
        """Rows by the fitted directions, times the roots of their weights, no unit, (r, v + q)."""
        return np.asarray(self.rows.jacobian @ self.directions * np.sqrt(self.weight)[:, None])

    @property
    def shape_sd(self) -> Mapping[str, float]:
        """Sds of the shape parameters; NaN if held, at a bound, or without influence on any row."""
        at_bound = shapes_at_bound(self.model, self.shapes)
        return {
            name: np.nan if name in at_bound else sd * self.shapes[name]
            for name, sd in self.log_shape_sd.items()
        }

    @property
    def residual_rms(self) -> float:
        """Root mean square of the data rows' residuals, SI."""
        return float(np.sqrt(np.mean(self.residual_si**2)))


def _number(value: Any) -> Any:
    """A value of one set as a Python number; an array (S,) as it is."""
    return np.asarray(value) if np.ndim(value) else np.asarray(value).item()


def shapes_at_bound(model: Model, shapes: Mapping[str, float]) -> set[str]:
    """Effects of ``model`` whose shape parameter is at the end of its range."""
    return {
        effect.name for effect in model.effects
        if effect.shape is not None and effect.name in shapes
        and effect.shape.is_at_bound(shapes[effect.name])
    }
