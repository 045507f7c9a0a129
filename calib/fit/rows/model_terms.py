"""What a model decides of the rows: which effects act where, and where their parameters stand."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import Model, stack_columns
from calib.fit.rows.surroundings import Surroundings
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class ModelTerms:
    """The effects of a model by where they act.

    Parameters
    ----------
    model : Model
    varying, fixed : tuple of Effect
        On the sensor: those whose columns follow the vector, and those that do not.
    """

    model: Model
    varying: tuple[Effect, ...]
    fixed: tuple[Effect, ...]

    @classmethod
    def of(cls, model: Model) -> "ModelTerms":
        """The terms of a model of the reading and the reference alone."""
        return cls(model, (), ())

    def extended(self, effects: Sequence[Effect], surroundings: Surroundings) -> "ModelTerms":
        """The terms with more ``effects``, by how their columns behave in ``surroundings``."""
        model, varying, fixed = self.model, list(self.varying), list(self.fixed)
        for effect in effects:
            model = model + effect
            if effect.acts_on == "sensor":
                follows = follows_vector(effect, surroundings.at_start)
                (varying if follows else fixed).append(effect)
        return ModelTerms(model, tuple(varying), tuple(fixed))

    @cached_property
    def on_reading(self) -> tuple[Effect, ...]:
        """The effects on the reading."""
        return self.model.acting_on("reading")

    @cached_property
    def on_sensor(self) -> tuple[Effect, ...]:
        """The effects on the sensor."""
        return self.model.acting_on("sensor")

    @cached_property
    def on_reference(self) -> tuple[Effect, ...]:
        """The effects on the reference."""
        return self.model.acting_on("reference")

    @cached_property
    def reading_index(self) -> list[int]:
        """Places of the p' parameters of the reading in theta."""
        return self.model.positions(self.on_reading)

    @cached_property
    def sensor_index(self) -> list[int]:
        """Places of the parameters of the sensor in theta."""
        return self.model.positions(self.on_sensor)

    @cached_property
    def reference_index(self) -> list[int]:
        """Places of the parameters of the reference in theta."""
        return self.model.positions(self.on_reference)

    @cached_property
    def varying_index(self) -> list[int]:
        """Places of the parameters of the effects that follow the vector."""
        return self.model.positions(self.varying)

    @cached_property
    def fixed_index(self) -> list[int]:
        """Places of the parameters of the other effects on the sensor."""
        return self.model.positions(self.fixed)

    @cached_property
    def varying_on_axes(self) -> tuple[Effect, ...]:
        """The effects that follow what the sensitive axes sense."""
        return tuple(effect for effect in self.varying if not effect.orthogonal)

    @cached_property
    def varying_orthogonal(self) -> tuple[Effect, ...]:
        """The effects that follow the vector in orthogonal axes."""
        return tuple(effect for effect in self.varying if effect.orthogonal)

    @cached_property
    def on_axes_index(self) -> list[int]:
        """Places of the parameters of the effects on the sensitive axes."""
        return self.model.positions([e for e in self.on_sensor if not e.orthogonal])

    @cached_property
    def is_linear_form(self) -> bool:
        """Whether the model is of the reading alone."""
        return len(self.reading_index) == self.model.size

    @cached_property
    def matrix_slopes(self) -> FloatArray:
        """dM/dtheta of ``M y + c`` for every parameter of the reading, per unit, (p', 3, 3)."""
        if not self.on_reading:
            return np.zeros((0, 3, 3))
        probes = np.vstack([np.zeros(3), np.eye(3)])
        columns = stack_columns(self.on_reading, Conditions.of_vectors(probes), {})
        return np.asarray((columns[0] - columns[1:]).transpose(2, 1, 0))

    def matrix(self, of_reading: FloatArray) -> FloatArray:
        """M of ``M y + c``, no unit, (..., 3, 3), at parameters of the reading (..., p')."""
        slopes = self.matrix_slopes.reshape(-1, 9)
        return np.asarray(np.eye(3) + (of_reading @ slopes).reshape(*of_reading.shape[:-1], 3, 3))


def follows_vector(effect: Effect, at: Conditions) -> bool:
    """Whether the columns of ``effect`` change with the vector, not only with the conditions."""
    elsewhere = at.with_vector(1.1 * at.vector + 0.1)
    return not np.array_equal(effect.evaluate(at), effect.evaluate(elsewhere))
