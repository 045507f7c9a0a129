"""A model is a sum of effects; fitted, it corrects readings.

With y the nominal reading and s the corrected vector:

    v = y - E(y) theta_reading            the linear form M y + c of Angrisano et al. eq. (1)
    s + C(s) theta_sensor = v             solved for s by fixed point
    m + D theta_reference                 the reference magnitude

An effect F of the sensor acts on what its sensitive axes feel, ``u = T⁻¹ s`` with T of eq. (2), the
columns of M over its diagonal: ``C(s) = T F(T⁻¹ s)``.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect, Need
from calib.errors import CalibrationError, FitFailed, Remedy
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

FIXED_POINT_STEPS = 50
FIXED_POINT_TOLERANCE = 1e-14
NO_GAIN = 1e-9
SLOPE_STEP = 1e-4
"""Relative step of the central difference dC/ds; exact for effects of second order in s."""


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


@dataclass(frozen=True, eq=False)
class Axes:
    """T of eq. (2): ``to_orthogonal`` (3, 3) from the sensitive axes, ``to_sensed`` its inverse."""

    to_orthogonal: FloatArray
    to_sensed: FloatArray

    def sensed(self, vector: FloatArray) -> FloatArray:
        """What the sensitive axes feel, ``T⁻¹ s``, of vectors (n, 3) in orthogonal axes."""
        return np.asarray(vector @ self.to_sensed.T)


ALIGNED = Axes(np.eye(3), np.eye(3))


def axes_of(matrix: FloatArray) -> Axes:
    """The axes of a linear form with M = T K (3, 3): its columns over its diagonal."""
    gain = np.diag(matrix)
    # A gain of nothing has no axis; what a fit makes of it is refused at its end.
    if (np.abs(gain) < NO_GAIN).any():
        return ALIGNED
    aligned = np.asarray(matrix / gain)
    return Axes(aligned, np.asarray(np.linalg.inv(aligned), dtype=float))


def sensor_columns(
    effects: Sequence[Effect], at: Conditions, shapes: Mapping[str, float], axes: Axes
) -> FloatArray:
    """Columns of sensor-side effects side by side in orthogonal axes, C of this module.

    Parameters
    ----------
    effects : sequence of Effect
    at : Conditions
        Of n rows, with the vectors in orthogonal axes.
    shapes : mapping of effect name to shape parameter
    axes : Axes
        Those of the linear form.

    Returns
    -------
    array, shape (n, 3, k)
    """
    sensed = replace(at, vector=axes.sensed(at.vector))
    columns = [
        effect.evaluate(at, shapes.get(effect.name))
        if effect.orthogonal
        else axes.to_orthogonal @ effect.evaluate(sensed, shapes.get(effect.name))
        for effect in effects
    ]
    return columns[0] if len(columns) == 1 else np.concatenate(columns, axis=2)


def solve_sensor(
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Mapping[str, float],
    conditions: Callable[[FloatArray], Conditions],
    linear: FloatArray,
    axes: Axes,
) -> FloatArray:
    """The corrected vector s of ``s + C(s) theta = linear`` by fixed point, shape (n, 3).

    ``conditions`` gives what the effects are evaluated on when the vectors are s (n, 3).

    Raises
    ------
    FitFailed
        The effects are so large that the fixed point does not exist.
    """
    s = linear
    largest = float(np.abs(linear).max()) + 1e-300
    for _ in range(FIXED_POINT_STEPS):
        columns = sensor_columns(effects, conditions(s), shapes, axes)
        following = linear - columns @ theta
        change = float(np.abs(following - s).max())
        s = following
        if not change < 1e3 * largest:
            break
        if change <= FIXED_POINT_TOLERANCE * largest:
            return s
    if change <= 1e-9 * largest:
        return s
    raise FitFailed(
        "the effects in the model are larger than the readings themselves, so that no true vector "
        "fits them. Remove the last effect added.",
        Remedy("remove_effect"),
    )


def follows_vector(effect: Effect, at: Conditions) -> bool:
    """Whether the columns of ``effect`` change with the vector, not only with the conditions."""
    elsewhere = replace(at, vector=1.1 * at.vector + 0.1)
    return not np.array_equal(effect.evaluate(at), effect.evaluate(elsewhere))


def sensor_slope(
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Mapping[str, float],
    at: Conditions,
    axes: Axes,
) -> FloatArray:
    """``d(C theta)/ds`` at ``at``, shape (n, 3, 3), by central differences."""
    total = np.zeros((len(at.vector), 3, 3))
    start = 0
    sensed = replace(at, vector=axes.sensed(at.vector))
    for effect in effects:
        size = theta[start : start + len(effect.parameters)]
        start += len(effect.parameters)
        if effect.orthogonal:
            total += _slope(effect, size, shapes.get(effect.name), at)
        else:
            slope = _slope(effect, size, shapes.get(effect.name), sensed)
            total += axes.to_orthogonal @ slope @ axes.to_sensed
    return total


def _slope(effect: Effect, size: FloatArray, shape: float | None, at: Conditions) -> FloatArray:
    """Derivative of an effect's error by the vector that it is evaluated on, (n, 3, 3)."""
    step = SLOPE_STEP * (float(np.abs(at.vector).max()) or 1.0)
    slope = np.empty((len(at.vector), 3, 3))
    for j in range(3):
        move = np.zeros(3)
        move[j] = step
        up = effect.evaluate(replace(at, vector=at.vector + move), shape) @ size
        down = effect.evaluate(replace(at, vector=at.vector - move), shape) @ size
        slope[:, :, j] = (up - down) / (2 * step)
    return slope


def unavailable(effect: Effect, poses: PoseSet) -> str | None:
    """Why ``effect`` cannot be evaluated on these poses, or None when it can."""
    at = poses.conditions(poses.reading)
    if np.isfinite(effect.evaluate(at)).all():
        return None
    return why_lacking(effect, at) or "its columns are not numbers in these poses"


LACKING: Mapping[Need, str] = {
    "force": "the accelerometer was not logged in every pose",
    "time": "the logs' clocks overlap or are missing, so the order in time is not known",
    "previous": "the logs' clocks overlap or are missing, so the order in time is not known",
    "vibration": "the accelerometer was not logged in every pose",
    "plate": "the plate's rate is not known",
}


def lacking(effect: Effect, at: Conditions) -> tuple[list[Need], list[str]]:
    """Which needs of ``effect``, and which logged columns, are not complete in ``at``.

    Returns
    -------
    needs, columns : list of str
    """
    fields: Mapping[Need, FloatArray] = {
        "force": at.force,
        "time": at.time_s,
        "previous": at.previous,
        "vibration": at.vibration,
        "plate": at.spin_rad_s,
    }
    return (
        [need for need in effect.needs if not np.isfinite(fields[need]).all()],
        [name for name in effect.logged if not np.isfinite(at.column(name)).all()],
    )


def why_lacking(effect: Effect, at: Conditions) -> str | None:
    """The first thing that ``effect`` needs and poses at ``at`` do not have, in words."""
    needs, columns = lacking(effect, at)
    if needs:
        return LACKING[needs[0]]
    return f"the logs have no complete column {columns[0]}" if columns else None


@dataclass(frozen=True, eq=False)
class Correction:
    """What is needed to correct the readings of one triad, and nothing else.

    ``theta`` (p,) are the fitted parameters of ``model`` and ``shapes`` its shape parameters;
    ``spec`` turns counts into the nominal readings they act on.
    """

    spec: TriadSpec
    model: Model
    theta: FloatArray
    shapes: Mapping[str, float]

    def linear_form(self) -> tuple[FloatArray, FloatArray]:
        """M (3, 3) and c (3,) of ``M y + c``, which bias, scale and misalignment make up."""
        probes = np.vstack([np.zeros(3), np.eye(3)])
        at = Conditions.of_vectors(probes)
        effects = self.model.acting_on("reading")
        s = probes
        if effects:
            s = probes - stack_columns(effects, at, {}) @ self.theta[pick(self.model, effects)]
        return np.asarray((s[1:] - s[0]).T), np.asarray(s[0])

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors for nominal readings ``at.vector`` and their conditions, (n, 3).

        Effects on the reference are left out: they are errors of the bench, not of the sensor.
        """
        matrix, offset = self.linear_form()
        s = at.vector @ matrix.T + offset
        sensor = self.model.acting_on("sensor")
        if not sensor:
            return np.asarray(s)
        theta = self.theta[pick(self.model, sensor)]
        axes = axes_of(matrix)
        return solve_sensor(sensor, theta, self.shapes, lambda v: replace(at, vector=v), s, axes)
