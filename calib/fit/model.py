"""A model is a sum of effects that are fitted jointly.

With y the nominal reading and s the corrected vector:

    v = y - E(y) theta_reading            the linear form M y + c of Angrisano et al. eq. (1)
    s + C(s) theta_sensor = v             :mod:`calib.fit.rows.sensitive_axes`
    m + D theta_reference                 the reference magnitude
"""

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
    """Effects fitted jointly. ``model + effect`` and ``model - name`` give new models.

    Parameters
    ----------
    effects : tuple of Effect
        Their k parameters each stand one after another in theta (p,), in this order; shape
        parameters are not among them.

    Raises
    ------
    CalibrationError
        By ``+``: an effect of that name is already in the model.
    """

    effects: tuple[Effect, ...]

    @classmethod
    def of(cls, names: Sequence[str], extra: Mapping[str, Effect] | None = None) -> "Model":
        """The model of these effects, by name.

        Parameters
        ----------
        names : sequence of str
        extra : mapping of name to Effect, optional
            Users' effects; they go before the catalogue's.

        Raises
        ------
        UnknownEffect
            A name that neither ``extra`` nor the catalogue has.
        """
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

    def within(self, at: Conditions) -> "Model":
        """The same model with the starts of shape parameters for poses at ``at`` (n)."""
        if all(effect.starts_in is None for effect in self.effects):
            return self
        return Model(tuple(effect.within(at) for effect in self.effects))

    def slices(self) -> dict[str, slice]:
        """Slices of theta by effect name."""
        places, start = {}, 0
        for effect in self.effects:
            places[effect.name] = slice(start, start + len(effect.parameters))
            start += len(effect.parameters)
        return places

    def acting_on(self, place: str) -> tuple[Effect, ...]:
        """The effects that act on ``reading``, ``sensor``, ``reference`` or ``noise``."""
        return tuple(effect for effect in self.effects if effect.acts_on == place)

    def positions(self, effects: Sequence[Effect]) -> list[int]:
        """Indices in theta of the parameters of ``effects``, one effect after another.

        Parameters
        ----------
        effects : sequence of Effect
            Each of them in the model.

        Returns
        -------
        list of int
            Indices into theta (p,), k for every effect of k parameters, in the order of
            ``effects``.

        Raises
        ------
        KeyError
            One of them is not in the model.
        """
        slices = self.slices()
        return [i for e in effects for i in range(slices[e.name].start, slices[e.name].stop)]


def stack_columns(
    effects: Sequence[Effect], at: Conditions, shapes: Mapping[str, float]
) -> FloatArray:
    """Columns of several effects on the reading or the sensor side by side.

    Parameters
    ----------
    effects : sequence of Effect
        May be none: a model need not have bias, scale and misalignment.
    at : Conditions
        Of n poses or samples, SI.
    shapes : mapping of effect name to shape parameter
        An effect that is not in it is evaluated at its first start.

    Returns
    -------
    array, shape (n, 3, k)
        Error of the vector, SI, per unit of each of the k parameters of all effects.
    """
    none = np.zeros((len(at), 3, 0))
    return np.concatenate([none, *(e.evaluate(at, shapes.get(e.name)) for e in effects)], axis=2)
