"""Conditions at which effects are evaluated, and the terms of the rows that the model decides."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import Model, stack_columns
from calib.fit.rows.sensitive_axes import probes_of
from calib.fit.stacked import Index
from calib.poses.conditions import Conditions
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.rows import Rows, joined


@dataclass(frozen=True, eq=False)
class Surroundings(Rows):
    """The conditions of S sets of n poses, one set after another, computed when they are needed.

    Parameters
    ----------
    sets : tuple of PoseSet, length S
    vector, sensed : array, shape (S n, 3)
        The corrected vectors at the start, and what each sensitive axis sensed in its pose, for
        the memory of the pose before; SI.
    previous : array, shape (S n, 3), or None
        What they sensed in the pose before where that is known already.
    """

    sets: tuple[PoseSet, ...]
    vector: FloatArray
    sensed: FloatArray
    previous: FloatArray | None = None

    def take(self, index: Index) -> "Surroundings":
        """The surroundings of some sets, or of one set with or without its leading axis.

        A set may be taken more than once.
        """
        which = np.atleast_1d(np.arange(len(self.sets))[index]).ravel()
        if len(self.sets) == len(which) == 1:
            return self
        rows = self._rows[which].ravel()
        previous = None if self.previous is None else self.previous[rows]
        return Surroundings(tuple(self.sets[i] for i in which), self.vector[rows],
                            self.sensed[rows], previous)

    @property
    def _rows(self) -> IntArray:
        """Row of every pose, (S, n)."""
        return np.arange(len(self.vector)).reshape(len(self.sets), -1)

    @cached_property
    def at_reading(self) -> Conditions:
        """The conditions with the nominal readings."""
        return joined([poses.conditions(poses.reading) for poses in self.sets])

    @cached_property
    def at_start(self) -> Conditions:
        """The conditions at the start, after the vectors :attr:`sensed` in the poses before."""
        at = joined([poses.conditions(self.vector[rows], self.sensed[rows])
                     for poses, rows in zip(self.sets, self._rows, strict=True)])
        return at if self.previous is None else replace(at, previous=self.previous)

    @cached_property
    def probes(self) -> Conditions:
        """The poses of each set six times, for the differences that give the slopes."""
        return probes_of(self.at_start, (len(self.sets),))

    def conditions(self, vector: FloatArray) -> Conditions:
        """Conditions of the effects at the corrected vectors (..., n, 3), SI.

        In a null pose this is the expected vector, not the reading: scaled by an effect, its noise
        would look like a signal. The pose before stays as at the start, so that rows are
        independent and a sign that flips with noise cannot make the iteration jump.
        """
        flat = vector.reshape(-1, 3)
        return self.at_start.with_vector(np.where(self.is_null[:, None], self.expected, flat))

    @cached_property
    def is_null(self) -> BoolArray:
        """Whether poses were at rest, (S n,)."""
        return np.concatenate([poses.reference.is_null for poses in self.sets])

    @cached_property
    def expected(self) -> FloatArray:
        """Expected readings of poses at rest, SI, (S n, 3)."""
        return np.concatenate([poses.expected for poses in self.sets])


@dataclass(frozen=True)
class EffectPart:
    """Some effects of a model, and the indices of their parameters in theta."""

    effects: tuple[Effect, ...]
    index: list[int]

    def __bool__(self) -> bool:
        return bool(self.effects)


@dataclass(frozen=True, eq=False)
class ModelTerms:
    """The effects of a model by where they act.

    Parameters
    ----------
    model : Model
    following : frozenset of str
        Names of the effects on the sensor whose columns follow the vector.
    """

    model: Model
    following: frozenset[str] = frozenset()

    def extended(self, effects: Sequence[Effect], surroundings: Surroundings) -> "ModelTerms":
        """The terms with more ``effects``, by how their columns behave in ``surroundings``."""
        model, following = self.model, set(self.following)
        for effect in effects:
            model = model + effect
            if effect.acts_on == "sensor" and follows_vector(effect, surroundings.at_start):
                following.add(effect.name)
        return ModelTerms(model, frozenset(following))

    def _part(self, effects: Iterable[Effect]) -> EffectPart:
        chosen = tuple(effects)
        return EffectPart(chosen, self.model.positions(chosen))

    @cached_property
    def reading(self) -> EffectPart:
        """The effects on the reading, of p' parameters."""
        return self._part(self.model.acting_on("reading"))

    @cached_property
    def sensor(self) -> EffectPart:
        """The effects on the sensor."""
        return self._part(self.model.acting_on("sensor"))

    @cached_property
    def reference(self) -> EffectPart:
        """The effects on the reference."""
        return self._part(self.model.acting_on("reference"))

    @cached_property
    def varying(self) -> EffectPart:
        """The effects on the sensor that follow the vector."""
        return self._part(e for e in self.sensor.effects if e.name in self.following)

    @cached_property
    def fixed(self) -> EffectPart:
        """The other effects on the sensor."""
        return self._part(e for e in self.sensor.effects if e.name not in self.following)

    @cached_property
    def on_axes(self) -> EffectPart:
        """The effects on the sensitive axes."""
        return self._part(e for e in self.sensor.effects if not e.orthogonal)

    @cached_property
    def varying_by_axes(self) -> tuple[EffectPart, EffectPart]:
        """The varying effects of the sensitive axes, and those of the orthogonal ones."""
        return (self._part(e for e in self.varying.effects if not e.orthogonal),
                self._part(e for e in self.varying.effects if e.orthogonal))

    @property
    def is_linear_form(self) -> bool:
        """Whether the model acts on the reading alone."""
        return len(self.reading.index) == self.model.size

    @cached_property
    def matrix_slopes(self) -> FloatArray:
        """dM/dtheta of ``M y + c`` for every parameter of the reading, per unit, (p', 3, 3)."""
        probes = np.vstack([np.zeros(3), np.eye(3)])
        columns = stack_columns(self.reading.effects, Conditions.of_vectors(probes), {})
        return np.asarray((columns[0] - columns[1:]).transpose(2, 1, 0))

    def matrix(self, of_reading: FloatArray) -> FloatArray:
        """M of ``M y + c``, no unit, (..., 3, 3), at parameters of the reading (..., p')."""
        slopes = self.matrix_slopes.reshape(-1, 9)
        return np.asarray(np.eye(3) + (of_reading @ slopes).reshape(*of_reading.shape[:-1], 3, 3))


def follows_vector(effect: Effect, at: Conditions) -> bool:
    """Whether the columns of ``effect`` change with the vector, not only with the conditions."""
    elsewhere = at.with_vector(1.1 * at.vector + 0.1)
    return not np.array_equal(effect.evaluate(at), effect.evaluate(elsewhere))
