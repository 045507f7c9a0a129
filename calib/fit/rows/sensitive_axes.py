"""Effects of the sensor act on what its sensitive axes sense.

An effect F acts on ``u = T⁻¹ s``, s the corrected vector and T of Angrisano et al. eq. (2), the
columns of M over its diagonal: ``C(s) = T F(T⁻¹ s)``. The corrected vector solves

    s + C(s) theta_sensor = M y + c

by fixed point, and where that is slow, because an effect changes the gain by a tenth and more, by
Newton's steps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Effect
from calib.errors import FitFailed, Remedy
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

FIXED_POINT_STEPS = 12
"""Derived: an effect that changes the gain by a tenth has then converged to 1e-12. Numerical."""

NEWTON_STEPS = 30  #: numerical limit
FIXED_POINT_TOLERANCE = 1e-14  #: relative; numerical: rounding
SOLVED = 1e-9  #: relative; vectors that move by less are solved for any sd; numerical
RUNAWAY = 1e3  #: relative; numerical: a step so long never comes back
NO_GAIN = 1e-9  #: of the data sheet's gain; numerical: an axis that gives nothing
SLOPE_STEP = 1e-4
"""Relative step of the central difference dC/ds; exact for effects of second order in s.
Numerical."""


@dataclass(frozen=True, eq=False)
class Axes:
    """T of Angrisano et al. eq. (2).

    Attributes
    ----------
    to_orthogonal : array, shape (3, 3)
        From the sensitive axes to the orthogonal ones.
    to_sensed : array, shape (3, 3)
        Its inverse.
    """

    to_orthogonal: FloatArray
    to_sensed: FloatArray

    def sensed(self, vector: FloatArray) -> FloatArray:
        """What the sensitive axes sense, ``T⁻¹ s``.

        Parameters
        ----------
        vector : array, shape (n, 3)
            s in orthogonal axes, SI.

        Returns
        -------
        array, shape (n, 3)
            In the same unit.
        """
        return np.asarray(vector @ self.to_sensed.T)


ALIGNED = Axes(np.eye(3), np.eye(3))  #: sensitive axes that are the orthogonal ones; definition


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
        SI per unit of each parameter.
    """
    sensed = at.with_vector(axes.sensed(at.vector))
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
    """The corrected vector s of ``s + C(s) theta = linear``, SI, shape (n, 3).

    ``conditions`` gives what the effects are evaluated on when the vectors are s (n, 3).

    Raises
    ------
    FitFailed
        The effects are so large that there is no such vector.
    """
    s = linear
    largest = float(np.abs(linear).max()) + NO_LENGTH
    for step in range(FIXED_POINT_STEPS + NEWTON_STEPS):
        at = conditions(s)
        change = linear - sensor_columns(effects, at, shapes, axes) @ theta - s
        if step >= FIXED_POINT_STEPS:
            slope = np.eye(3) + sensor_slope(
                effects, theta, shapes, probes_of(at), at.vector, axes
            )
            if not (np.linalg.det(slope) > 0).all():
                break  # the response turns back: two vectors have one reading
            change = np.asarray(np.linalg.solve(slope, change[:, :, None])[:, :, 0], dtype=float)
        s = s + change
        moved = float(np.abs(change).max())
        if not moved < RUNAWAY * largest:
            break
        if moved <= FIXED_POINT_TOLERANCE * largest:
            return s
    if moved <= SOLVED * largest:
        return s
    raise FitFailed(
        "the effects in the model are larger than the readings themselves, so that no true vector "
        "fits them. Remove the last effect added.",
        Remedy("remove_effect"),
    )


def follows_vector(effect: Effect, at: Conditions) -> bool:
    """Whether the columns of ``effect`` change with the vector, not only with the conditions."""
    elsewhere = at.with_vector(1.1 * at.vector + 0.1)
    return not np.array_equal(effect.evaluate(at), effect.evaluate(elsewhere))


def sensor_slope(
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Mapping[str, float],
    probes: Conditions,
    vector: FloatArray,
    axes: Axes,
) -> FloatArray:
    """``d(C theta)/ds`` by central differences.

    Parameters
    ----------
    effects : sequence of Effect
    theta : array, shape (k,)
        Of all of them.
    shapes : mapping of effect name to shape parameter
    probes : Conditions
        :func:`probes_of` the n rows.
    vector : array, shape (n, 3)
        In orthogonal axes.
    axes : Axes
        Those of the linear form.

    Returns
    -------
    array, shape (n, 3, 3)
        No unit: the error per error of the vector.
    """
    total = np.zeros((len(vector), 3, 3))
    if not theta.any():
        return total
    start = 0
    sensed = axes.sensed(vector)
    for effect in effects:
        size = theta[start : start + len(effect.parameters)]
        start += len(effect.parameters)
        if not size.any():
            continue
        if effect.orthogonal:
            total += _slope(effect, size, shapes.get(effect.name), probes, vector)
        else:
            slope = _slope(effect, size, shapes.get(effect.name), probes, sensed)
            total += axes.to_orthogonal @ slope @ axes.to_sensed
    return total


def probes_of(at: Conditions) -> Conditions:
    """Every row of ``at`` six times, for the differences of :func:`sensor_slope`."""
    return at.take(np.tile(np.arange(len(at)), 6))


def _slope(
    effect: Effect, size: FloatArray, shape: float | None, probes: Conditions, vector: FloatArray
) -> FloatArray:
    """Derivative of an effect's error by the vector that it is evaluated on, (n, 3, 3)."""
    step = SLOPE_STEP * (float(np.abs(vector).max()) or 1.0)
    moves = step * np.concatenate([np.eye(3), -np.eye(3)])
    moved = (vector + moves[:, None, :]).reshape(-1, 3)
    error = effect.evaluate(probes.with_vector(moved), shape) @ size
    up, down = error.reshape(2, 3, len(vector), 3)
    return np.asarray(((up - down) / (2 * step)).transpose(1, 2, 0))
