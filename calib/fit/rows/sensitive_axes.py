"""Effects of the sensor act on what its sensitive axes sense.

An effect F acts on ``u = T⁻¹ s``, s the corrected vector and T of Angrisano et al. eq. (2), the
columns of M over its diagonal: ``C(s) = T F(T⁻¹ s)``. The corrected vector solves

    s + C(s) theta_sensor = M y + c

by fixed point, and where that is slow, because an effect changes the gain by a tenth and more, by
Newton's steps. Arrays of vectors are (..., n, 3), with an axis for the sets where there are
several; their conditions have the rows of all sets one after another.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Effect, ShapeValue
from calib.errors import FitFailed, Remedy
from calib.fit.linear import combined, inverses
from calib.fit.stacked import Stacked
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

Shapes = Mapping[str, FloatArray] | Mapping[str, float]
"""Shape parameters by effect: of each of S sets (S,), or numbers for one set."""

FIXED_POINT_STEPS = 12
"""Derived: an effect that changes the gain by a tenth has converged to 1e-12 by then. Numerical."""

NEWTON_STEPS = 30  #: numerical limit
FIXED_POINT_TOLERANCE = 1e-14  #: relative; numerical: rounding
SOLVED = 1e-9  #: relative; vectors that move by less are solved for any sd; numerical
RUNAWAY = 1e3  #: relative; numerical: so long a step never returns
IDENTITY = np.eye(3)  #: definition
NO_GAIN = 1e-9  #: share of the data sheet's gain; numerical: an axis without a signal
SLOPE_STEP = 1e-4
"""Relative step of the central difference dC/ds; exact for effects of second order in s.
Numerical."""


@dataclass(frozen=True, eq=False)
class Axes(Stacked):
    """T of Angrisano et al. eq. (2).

    Attributes
    ----------
    to_orthogonal : array, shape (..., 3, 3)
        From the sensitive axes to the orthogonal ones.
    to_sensed : array, shape (..., 3, 3)
        Its inverse.
    """

    to_orthogonal: FloatArray
    to_sensed: FloatArray

    @property
    def lead(self) -> tuple[int, ...]:
        """Shape ahead of the last two axes: (S,) of S sets, empty of one."""
        return self.to_orthogonal.shape[:-2]

    def sensed(self, vector: FloatArray) -> FloatArray:
        """Vectors in the sensitive axes, ``T⁻¹ s``.

        Parameters
        ----------
        vector : array, shape (..., n, 3)
            s in orthogonal axes, SI.

        Returns
        -------
        array, shape (..., n, 3)
            In the same unit.
        """
        return np.asarray(vector @ self.to_sensed.swapaxes(-1, -2))


ALIGNED = Axes(np.eye(3), np.eye(3))  #: sensitive axes that are the orthogonal ones; definition


def axes_of(matrix: FloatArray) -> Axes:
    """The axes of linear forms with M = T K (..., 3, 3): its columns over its diagonal.

    A vanishing gain has no axis; such a fit is refused at its end.
    """
    gain = np.einsum("...kk->...k", matrix)
    has_gain = (np.abs(gain) >= NO_GAIN).all(axis=-1)[..., None, None]
    if not has_gain.all():
        matrix = np.where(has_gain, matrix, IDENTITY)
        gain = np.where(has_gain[..., 0], gain, 1.0)
    aligned = np.asarray(matrix / gain[..., None, :])
    return Axes(aligned, inverses(aligned))


def evaluate_for(
    lead: tuple[int, ...], effect: Effect, at: Conditions, shapes: Shapes
) -> FloatArray:
    """Columns of an effect on the rows of all sets.

    Effects are row by row by law, so one call is enough. An effect that marks poses of one set (a
    step, a bad pose) has the rows of that set whatever its conditions: the others are copies of it.

    Parameters
    ----------
    lead : tuple of int
        (S,), or empty for one set.
    effect : Effect
        Of several sets with shapes of their own a listed one, which takes a shape for every row.
    at : Conditions
        Of S n rows.
    shapes : mapping of effect name to shape parameter
        Of each set.

    Returns
    -------
    array, shape (..., n, 3, k) or (..., n, k)
        SI per unit of each parameter.
    """
    value: ShapeValue | None = shapes.get(effect.name)
    if value is not None:
        of_sets = np.ravel(value)
        of_rows = np.repeat(of_sets, len(at) // len(of_sets))[:, None]
        value = float(of_sets[0]) if len(of_sets) == 1 else of_rows
    errors = effect.evaluate(at, value)
    if len(errors) < len(at):
        errors = np.concatenate([errors] * (len(at) // len(errors)))
    return errors.reshape(*lead, len(at) // max(int(np.prod(lead)), 1), *errors.shape[1:])


def sensor_columns(
    effects: Sequence[Effect], at: Conditions, shapes: Shapes, axes: Axes
) -> FloatArray:
    """Columns of sensor-side effects side by side in orthogonal axes, C of this module.

    Parameters
    ----------
    effects : sequence of Effect
    at : Conditions
        Of the n rows of each set, with the vectors in orthogonal axes.
    shapes : mapping of effect name to shape parameter
    axes : Axes
        Those of the linear forms.

    Returns
    -------
    array, shape (..., n, 3, k)
        SI per unit of each parameter.
    """
    sensed = at
    if not all(effect.orthogonal for effect in effects):
        vector = at.vector.reshape(*axes.lead, -1, 3)
        sensed = at.with_vector(axes.sensed(vector).reshape(-1, 3))
    columns = [
        evaluate_for(axes.lead, effect, at, shapes)
        if effect.orthogonal
        else axes.to_orthogonal[..., None, :, :] @ evaluate_for(axes.lead, effect, sensed, shapes)
        for effect in effects
    ]
    return columns[0] if len(columns) == 1 else np.concatenate(columns, axis=-1)


def solve_sensor(
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Shapes,
    conditions: Callable[[FloatArray], Conditions],
    linear: FloatArray,
    axes: Axes,
) -> FloatArray:
    """The corrected vectors s of ``s + C(s) theta = linear``, SI.

    Parameters
    ----------
    effects : sequence of Effect
    theta : array, shape (..., k)
        Of all of them.
    shapes : mapping of effect name to shape parameter
    conditions : callable
        What the effects are evaluated on when the vectors are s (..., n, 3).
    linear : array, shape (..., n, 3)
    axes : Axes

    Returns
    -------
    array, shape (..., n, 3)
        NaN in a set of a stack whose effects are so large that there are no such vectors.

    Raises
    ------
    FitFailed
        Those of the only set are so large.
    """
    s = linear
    largest = np.abs(linear).max(axis=(-2, -1)) + NO_LENGTH
    moved, ended = np.full(largest.shape, np.inf), np.zeros(largest.shape, dtype=bool)
    for step in range(FIXED_POINT_STEPS + NEWTON_STEPS):
        at = conditions(s)
        change = linear - combined(sensor_columns(effects, at, shapes, axes), theta) - s
        if step >= FIXED_POINT_STEPS:
            vector = at.vector.reshape(s.shape)
            slope = IDENTITY + sensor_slope(
                effects, theta, shapes, probes_of(at, axes.lead), vector, axes
            )
            # Where it is not positive, the response turns back: two vectors have one reading.
            turned = ~(np.linalg.det(slope) > 0).all(axis=-1)
            reached = np.where(moved <= SOLVED * largest, 0.0, np.inf)
            moved, ended = np.where(turned, reached, moved), ended | turned
            slope = np.where(ended[..., None, None, None], IDENTITY, slope)
            change = np.asarray(np.linalg.solve(slope, change[..., None])[..., 0], dtype=float)
        latest = np.abs(change).max(axis=(-2, -1))
        if ended.any():
            change = np.where(ended[..., None, None], 0.0, change)
            latest = np.where(ended, moved, latest)
        s, moved = s + change, latest
        sound = moved < RUNAWAY * largest
        if not sound.all():  # it is given up, and must not overflow
            s, moved = np.where(sound[..., None, None], s, linear), np.where(sound, moved, np.inf)
        ended = ~sound | (moved <= FIXED_POINT_TOLERANCE * largest)
        if ended.all():
            break
    solved = np.asarray(moved <= SOLVED * largest)
    if not axes.lead and not solved:
        raise too_large_effects()
    return s if solved.all() else np.where(solved[..., None, None], s, np.nan)


def too_large_effects() -> FitFailed:
    """The error raised where :func:`solve_sensor` finds no vectors."""
    return FitFailed(
        "the effects in the model are larger than the readings themselves, so that no true vector "
        "fits them. Remove the last effect added.",
        Remedy("remove_effect"),
    )


def sensor_slope(
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Shapes,
    probes: Conditions,
    vector: FloatArray,
    axes: Axes,
) -> FloatArray:
    """``d(C theta)/ds`` by central differences.

    Parameters
    ----------
    effects : sequence of Effect
    theta : array, shape (..., k)
        Of all of them.
    shapes : mapping of effect name to shape parameter
    probes : Conditions
        :func:`probes_of` the n rows of each set.
    vector : array, shape (..., n, 3)
        In orthogonal axes.
    axes : Axes
        Those of the linear forms.

    Returns
    -------
    array, shape (..., n, 3, 3)
        No unit: the error per error of the vector.
    """
    *lead, n, _ = vector.shape
    if not theta.any():
        return np.zeros((*vector.shape, 3))
    largest = np.abs(vector).max(axis=(-2, -1))
    step = (SLOPE_STEP * np.where(largest == 0, 1.0, largest))[..., None, None, None]
    moved = vector[..., None, :, :] + step * np.concatenate([IDENTITY, -IDENTITY])[:, None, :]
    columns = sensor_columns(effects, probes.with_vector(moved.reshape(-1, 3)), shapes, axes)
    up, down = np.moveaxis(combined(columns, theta).reshape(*lead, 2, 3, n, 3), -4, 0)
    return np.asarray(np.moveaxis((up - down) / (2 * step), -3, -1))


def probes_of(at: Conditions, lead: tuple[int, ...]) -> Conditions:
    """The rows of each set six times, for the differences of :func:`sensor_slope`."""
    rows = np.arange(len(at)).reshape(*lead, 1, -1)
    return at.take(np.repeat(rows, 6, axis=-2).ravel())
