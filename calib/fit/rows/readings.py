"""The corrected vectors of the readings, and their derivatives by the parameters of the model.

From ``s + C(s; T) theta = M y + c``, C of :mod:`calib.fit.rows.sensitive_axes`:

    (I + C') ds = dv - C dtheta - (dC/dT) dT,    (dC/dT) dT = dT F theta - T F' T⁻¹ dT u

the latter at fixed s. Rows show only a few directions of ds: the two sides are kept separate, so
that ``I + C'`` is solved for those directions and not for every parameter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Effect
from calib.fit.linear import combined
from calib.fit.model import Model, stack_columns
from calib.fit.rows.model_terms import ModelTerms, Surroundings
from calib.fit.rows.sensitive_axes import (
    ALIGNED,
    IDENTITY,
    NO_GAIN,
    Axes,
    Shapes,
    axes_of,
    sensor_columns,
    sensor_slope,
    solve_sensor,
)
from calib.fit.stacked import Stacked
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Readings(Stacked):
    """The readings of poses under one model.

    Parameters
    ----------
    reading : array, shape (..., n, 3)
        Nominal, SI.
    terms : ModelTerms
        What the model decides.
    surroundings : Surroundings
        What effects are evaluated on.
    columns : array, shape (..., n, 3, p')
        Those of the p' parameters of the reading, SI per unit of each.
    """

    reading: FloatArray
    terms: ModelTerms
    surroundings: Surroundings
    columns: FloatArray

    @classmethod
    def of(cls, reading: FloatArray, surroundings: Surroundings, model: Model) -> "Readings":
        """The readings (S, n, 3), SI, of the poses of ``surroundings`` under ``model``."""
        bare = cls(reading, ModelTerms(Model(())), surroundings, np.zeros((*reading.shape, 0)))
        return bare.extended(model.effects)

    def extended(self, effects: Sequence[Effect]) -> "Readings":
        """The same under the model with more ``effects``."""
        terms, columns = self.terms.extended(effects, self.surroundings), self.columns
        if len(terms.reading.effects) > len(self.terms.reading.effects):
            flat = Conditions.of_vectors(self.reading.reshape(-1, 3))
            columns = stack_columns(terms.reading.effects, flat, {})
            columns = columns.reshape(*self.reading.shape, -1)
        return Readings(self.reading, terms, self.surroundings, columns)

    def within(self, surroundings: Surroundings) -> "Readings":
        """The same in other ``surroundings``."""
        return replace(self, surroundings=surroundings)

    def axes(self, theta: FloatArray) -> Axes:
        """The sensitive axes at ``theta`` (..., p); aligned where no effect of the sensor is."""
        if not self.terms.sensor:
            return ALIGNED
        return axes_of(self.terms.matrix(theta[..., self.terms.reading.index]))

    def corrected(
        self, theta: FloatArray, shapes: Shapes
    ) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """The corrected vectors and both sides of their derivatives.

        Parameters
        ----------
        theta : array, shape (..., p)
        shapes : mapping of effect name to shape parameter

        Returns
        -------
        vector : array, shape (..., n, 3)
            SI; NaN in a set of a stack that has none.
        errors : array, shape (..., n, 3, p)
            By how much less it is per unit of each parameter, ahead of the effects that follow it.
        slope : array, shape (..., n, 3, 3), or None
            What effects that follow the vector make of its changes; the identity in null poses,
            which are held at what they should read.

        Raises
        ------
        FitFailed
            The effects of the only set are larger than the readings.
        """
        terms, axes = self.terms, self.axes(theta)
        s = self.reading - combined(self.columns, theta[..., terms.reading.index])
        if terms.is_linear_form:
            return s, self.columns, None
        columns = np.zeros((*s.shape, terms.model.size))
        columns[..., terms.reading.index] = self.columns
        conditions = self.surroundings.conditions
        if terms.fixed:
            part = terms.fixed
            columns[..., part.index] = sensor_columns(part.effects, conditions(s), shapes, axes)
            s = s - combined(columns[..., part.index], theta[..., part.index])
        if terms.varying:
            part = terms.varying
            s = solve_sensor(part.effects, theta[..., part.index], shapes, conditions, s, axes)
            columns[..., part.index] = sensor_columns(part.effects, conditions(s), shapes, axes)
        if not terms.sensor:
            return s, columns, None
        held = conditions(s).vector.reshape(s.shape)  # null poses as they should read
        slope = self._add_turns(columns, theta, shapes, held, axes)
        if slope is not None and self.surroundings.is_null.any():
            at_rest = self.surroundings.is_null.reshape(s.shape[:-1])
            slope = np.where(at_rest[..., None, None], IDENTITY, slope)
        return s, columns, slope

    def _add_turns(
        self, columns: FloatArray, theta: FloatArray, shapes: Shapes, vector: FloatArray,
        axes: Axes,
    ) -> FloatArray | None:
        """Add ``(dC/dT) dT`` to the columns of the reading; ``I + C'`` (..., n, 3, 3).

        None where no effect follows the ``vector`` (..., n, 3).
        """
        terms, surroundings = self.terms, self.surroundings
        on_axes, orthogonal = (
            sensor_slope(part.effects, theta[..., part.index], shapes, surroundings.probes, vector,
                         axes) if part else None
            for part in terms.varying_by_axes)
        if terms.reading:
            index = terms.on_axes.index
            error = axes.sensed(combined(columns[..., index], theta[..., index]))
            moved = self._axes_slopes(theta, axes)  # (..., p', 3, 3)
            turned = np.einsum("...pij,...nj->...nip", moved, error)
            if on_axes is not None:
                turned -= on_axes @ np.einsum("...pij,...nj->...nip", moved, axes.sensed(vector))
            columns[..., terms.reading.index] += turned
        slopes = [slope for slope in (on_axes, orthogonal) if slope is not None]
        return sum(slopes, start=IDENTITY) if slopes else None

    def _axes_slopes(self, theta: FloatArray, axes: Axes) -> FloatArray:
        """dT/dtheta for the parameters of the reading, (..., p', 3, 3)."""
        slopes = self.terms.matrix_slopes
        diagonal_slopes = np.einsum("pii->pi", slopes)
        diagonal = 1 + theta[..., self.terms.reading.index] @ diagonal_slopes
        has_gain = (np.abs(diagonal) >= NO_GAIN).all(axis=-1)[..., None, None, None]
        turned = axes.to_orthogonal[..., None, :, :] * diagonal_slopes[:, None, :]
        divisor = np.where(has_gain[..., 0], diagonal[..., None, :], 1.0)[..., None, :]
        # Without a gain the axes are held, see ``axes_of``.
        return np.asarray(np.where(has_gain, (slopes - turned) / divisor, 0.0))
