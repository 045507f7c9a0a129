"""A model is a sum of effects that are fitted jointly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True)
class Model:
    """Effects fitted jointly. ``model + effect`` and ``model - name`` give new models."""

    effects: tuple[Effect, ...]

    @classmethod
    def of(cls, names: Sequence[str], extra: Mapping[str, Effect] | None = None) -> "Model":
        """The model of these effect names; ``extra`` holds users' own effects by name."""
        extra = extra or {}
        return cls(tuple(extra[name] if name in extra else find_effect(name) for name in names))

    def __add__(self, effect: Effect) -> "Model":
        if effect.name in self.names:
            raise CalibrationError(f"'{effect.name}' is already in the model")
        return Model((*self.effects, effect))

    def __sub__(self, name: str) -> "Model":
        return Model(tuple(effect for effect in self.effects if effect.name != name))

    @property
    def names(self) -> tuple[str, ...]:
        """Effect names in order."""
        return tuple(effect.name for effect in self.effects)

    @property
    def size(self) -> int:
        """Number of parameters, shape parameters not counted."""
        return sum(len(effect.parameters) for effect in self.effects)

    def slices(self) -> dict[str, slice]:
        """Where each effect's parameters stand in theta."""
        places, start = {}, 0
        for effect in self.effects:
            places[effect.name] = slice(start, start + len(effect.parameters))
            start += len(effect.parameters)
        return places

    def acting_on(self, place: str) -> tuple[Effect, ...]:
        """The effects that act on ``reading``, ``sensor`` or ``reference``."""
        return tuple(effect for effect in self.effects if effect.acts_on == place)


def stack_columns(
    effects: Sequence[Effect], at: Conditions, shapes: Mapping[str, float]
) -> FloatArray:
    """Columns of several sensor-side effects side by side, shape (n, 3, k)."""
    return np.concatenate([e.evaluate(at, shapes.get(e.name)) for e in effects], axis=2)


def pick(model: Model, effects: Sequence[Effect]) -> list[int]:
    """Positions in theta (list of int) of the parameters of ``effects``, in their order."""
    slices = model.slices()
    return [i for e in effects for i in range(slices[e.name].start, slices[e.name].stop)]
