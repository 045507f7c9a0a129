"""The rows of :mod:`calib.fit.rows.residuals` for a stack, under a model of any listed effects.

Every formula is that of the one set, with a leading axis; effects are row by row by law, so that
one call evaluates them on the poses of all sets. A set whose corrected vectors the fixed point does
not find is marked, and left to the solver of one set, which goes on by Newton's steps.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property

import numpy as np

from calib.effects.effect import EFFECTS, Effect
from calib.fit.batch.joint_axes import JointAxes
from calib.fit.batch.joint_rows import JointRows
from calib.fit.batch.linear_algebra import times
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import (
    FIXED_POINT_STEPS,
    FIXED_POINT_TOLERANCE,
    RUNAWAY,
    SLOPE_STEP,
    SOLVED,
    follows_vector,
)
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions, joined
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

Shapes = Mapping[str, FloatArray]
"""Shape parameters of S sets by effect, each (S,)."""


OF_EACH = ("reading", "reading_columns", "magnitude_sd", "null_sd", "common_relative", "expected",
           "stated")
"""What every set has of its own, as arrays with a leading axis."""


class JointEquations:
    """The rows of S sets of n poses under one model.

    Parameters
    ----------
    each : sequence of Equations
        Of models with the same listed effects in the same places, and with magnitude and null rows
        in the same poses. An effect that is not listed is one that :func:`is_mark`, each set's own.
    """

    def __init__(self, each: Sequence[Equations]) -> None:
        self.each = each
        self.one = each[0]  # what is the same in all of them
        self.reading = np.array([e.at_reading.vector for e in each])
        self.reading_columns = np.array([e.reading_columns for e in each])
        self.magnitude_sd = np.array([e.magnitude_sd for e in each])
        self.null_sd = np.array([e.null_sd for e in each])
        self.common_relative = np.array([e.common_relative for e in each])
        self.expected = np.array([e.poses.expected for e in each])
        self.stated = np.array([e.poses.reference.magnitude[e.magnitude] for e in each])
        self.at_start = joined([e.at_start for e in each])
        self.marks = {
            effect.name: np.array([e.model.effects[j].evaluate(e.at_start) for e in each])
            for j, effect in enumerate(self.one.model.effects) if not is_listed(effect)
        }

    def __len__(self) -> int:
        return len(self.each)

    def take(self, sets: IntArray) -> "JointEquations":
        """The equations of these sets alone."""
        if len(sets) == len(self):
            return self  # in their order
        part = copy(self)
        for name in ("probes", "of_reference"):
            vars(part).pop(name, None)
        part.each = [self.each[int(i)] for i in sets]
        for name in OF_EACH:
            setattr(part, name, getattr(self, name)[sets])
        n = self.reading.shape[1]
        part.at_start = self.at_start.take((n * sets[:, None] + np.arange(n)).ravel())
        part.marks = {name: value[sets] for name, value in self.marks.items()}
        return part

    @cached_property
    def probes(self) -> Conditions:
        """Every pose of every set six times, for the differences by which slopes are computed."""
        sets, n, _ = self.reading.shape
        pose = np.tile(np.arange(n), (sets, 6, 1)) + n * np.arange(sets)[:, None, None]
        return self.at_start.take(pose.ravel())

    @cached_property
    def of_reference(self) -> FloatArray:
        """Whitened columns (S, k, p'') of the effects on the reference."""
        columns = [e.reference_columns({}) for e in self.each]
        return np.asarray(np.array(columns) / self.magnitude_sd[:, :, None])

    def held(self, vector: FloatArray) -> FloatArray:
        """Vectors (S, n, 3), SI, that effects are evaluated on: null poses as they should be."""
        return np.asarray(np.where(self.one.is_null[:, None], self.expected, vector))

    def columns(
        self, effects: Sequence[Effect], vector: FloatArray, shapes: Shapes, axes: JointAxes
    ) -> FloatArray:
        """Columns (S, n, 3, k) of effects of the sensor at held vectors (S, n, 3), SI."""
        sets, n, _ = vector.shape
        here = self.at_start.with_vector(vector.reshape(-1, 3))
        sensed = here
        if not all(effect.orthogonal for effect in effects):
            sensed = self.at_start.with_vector(axes.sensed(vector).reshape(-1, 3))
        columns = []
        for effect in effects:
            shape = _per_row(effect, shapes, n)
            if effect.name in self.marks:
                columns.append(self.marks[effect.name])
            elif effect.orthogonal:
                columns.append(effect.evaluate(here, shape).reshape(sets, n, 3, -1))
            else:
                errors = effect.evaluate(sensed, shape).reshape(sets, n, 3, -1)
                columns.append(axes.to_orthogonal[:, None] @ errors)
        return columns[0] if len(columns) == 1 else np.concatenate(columns, axis=3)

    def rows(self, theta: FloatArray, eta: FloatArray, shapes: Shapes) -> JointRows:
        """Residual and exact Jacobian at ``theta`` (S, p), ``eta`` (S, q)."""
        one, axes = self.one, JointAxes.at(self.one, theta)
        s, columns, is_solved = self._corrected(theta, shapes, axes)
        errors, slope = self._derivatives(theta, shapes, s, columns, axes)
        directions = self._directions(s, slope)
        (sets, p), q, k, d = theta.shape, eta.shape[1], len(one.magnitude), one.data_count
        residual = np.empty((sets, d + q))
        jacobian = np.zeros((sets, d + q, p + q))
        size = np.linalg.norm(s[:, one.magnitude], axis=2)
        true_share = 1 - times(self.common_relative, eta)
        residual[:, :k] = (size * true_share - self.stated) / self.magnitude_sd
        rest = s[:, one.null] - self.expected[:, one.null]
        residual[:, k:d] = (rest / self.null_sd).reshape(sets, -1)
        directions[:, :k] *= -true_share[:, :, None]
        directions[:, k:] *= -1
        jacobian[:, :d, :p] = (directions[:, :, None] @ errors[:, one.row_pose])[:, :, 0]
        if one.on_reference:
            residual[:, :k] -= times(self.of_reference, theta[:, one.reference_index])
            jacobian[:, :k, one.reference_index] -= self.of_reference
        jacobian[:, :k, p:] = -self.common_relative * (size / self.magnitude_sd)[:, :, None]
        residual[:, d:] = eta
        jacobian[:, d:, p:] = np.eye(q)
        return JointRows(residual, jacobian, s, slope, axes.to_orthogonal, axes.to_sensed,
                         is_solved & axes.is_sound)

    def by_shape(
        self, effect: Effect, rows: JointRows, value: FloatArray, step: float
    ) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of the vectors' errors by the logarithm of a shape.

        Parameters
        ----------
        effect : Effect
            Of k parameters, on the sensor.
        rows : JointRows
        value : array, shape (S,)
            Its shape parameter.
        step : float
            Of the logarithm, for central differences.

        Returns
        -------
        first, second : array, shape (S, n, 3, k), SI
        """
        axes = JointAxes(rows.to_orthogonal, rows.to_sensed, np.ones((len(value), 3)))
        at, factor = self.held(rows.vector), float(np.exp(step))
        down, middle, up = (
            self.columns((effect,), at, {effect.name: shape}, axes)
            for shape in (value / factor, value, value * factor)
        )
        first, second = (up - down) / (2 * step), (up + down - 2 * middle) / step**2
        if rows.slope is None:
            return first, second
        both = np.linalg.solve(rows.slope, np.concatenate([first, second], axis=3))
        return both[..., : first.shape[3]], both[..., first.shape[3] :]

    def whitened(self, vectors: FloatArray, s: FloatArray) -> FloatArray:
        """Whitened rows (S, d, c) of errors (S, n, 3, c) of corrected vectors (S, n, 3)."""
        directions = self._directions(s, None)
        return np.asarray((directions[:, :, None] @ vectors[:, self.one.row_pose])[:, :, 0])

    def _corrected(
        self, theta: FloatArray, shapes: Shapes, axes: JointAxes
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Corrected vectors, the sensor's columns (S, n, 3, p'') there, and which were found."""
        one = self.one
        of_reading = theta[:, None, one.reading_index, None]
        s = self.reading - (self.reading_columns @ of_reading)[..., 0]
        columns = np.zeros((*s.shape, one.model.size))
        is_solved = np.ones(len(s), dtype=bool)
        if one.fixed:
            fixed = self.columns(one.fixed, self.held(s), shapes, axes)
            columns[..., one.fixed_index] = fixed
            s = s - (fixed @ theta[:, None, one.fixed_index, None])[..., 0]
        if one.varying:
            sizes = theta[:, None, one.varying_index, None]
            s, is_solved = self._solved(sizes, shapes, s, axes)
            columns[..., one.varying_index] = self.columns(
                one.varying, self.held(s), shapes, axes
            )
        return s, columns[..., one.sensor_index], is_solved

    def _solved(
        self, sizes: FloatArray, shapes: Shapes, linear: FloatArray, axes: JointAxes
    ) -> tuple[FloatArray, BoolArray]:
        """The corrected vectors by fixed point, and in which sets that converged."""
        s = linear
        largest = np.abs(linear).max(axis=(1, 2)) + NO_LENGTH
        moved = np.full(len(s), np.inf)
        for _ in range(FIXED_POINT_STEPS):
            columns = self.columns(self.one.varying, self.held(s), shapes, axes)
            change = linear - (columns @ sizes)[..., 0] - s
            s = s + change
            moved = np.abs(change).max(axis=(1, 2))
            wild = ~(moved < RUNAWAY * largest)
            if (wild | (moved <= FIXED_POINT_TOLERANCE * largest)).all():
                break
            s = np.where(wild[:, None, None], linear, s)  # it is given up, and must not overflow
        return s, moved <= SOLVED * largest

    def _derivatives(
        self, theta: FloatArray, shapes: Shapes, vector: FloatArray, columns: FloatArray,
        axes: JointAxes,
    ) -> tuple[FloatArray, FloatArray | None]:
        """Both sides of :mod:`calib.fit.rows.vector_derivatives`."""
        one, at = self.one, self.held(vector)
        on_axes = self._slope_of(one.varying_on_axes, theta, shapes, at, axes)
        errors = np.zeros((*vector.shape, one.model.size))
        errors[..., one.sensor_index] = columns
        of_reading = self.reading_columns
        if one.on_sensor and one.reading_index:
            error = (columns[..., one.on_axes_columns] @ theta[:, None, one.on_axes_index, None])
            moved = axes.slopes(one)  # (S, p', 3, 3)
            of_reading = of_reading + np.einsum(
                "spij,snj->snip", moved, axes.sensed(error[..., 0])
            )
            if one.varying_on_axes:
                of_reading -= on_axes @ np.einsum("spij,snj->snip", moved, axes.sensed(at))
        errors[..., one.reading_index] = of_reading
        if not one.varying:
            return errors, None
        slope = np.eye(3) + on_axes
        slope += self._slope_of(one.varying_orthogonal, theta, shapes, at, axes)
        slope[:, one.null] = np.eye(3)
        return errors, slope

    def _slope_of(
        self, effects: Sequence[Effect], theta: FloatArray, shapes: Shapes, vector: FloatArray,
        axes: JointAxes,
    ) -> FloatArray:
        """C' of some effects of the model at held vectors, (S, n, 3, 3), by central differences."""
        total = np.zeros((*vector.shape, 3))
        for effect in effects:
            size = theta[:, self.one.model.positions((effect,))]
            at = vector if effect.orthogonal else axes.sensed(vector)
            step = SLOPE_STEP * np.abs(at).max(axis=(1, 2))
            step[step == 0] = SLOPE_STEP
            moves = step[:, None, None] * np.concatenate([np.eye(3), -np.eye(3)])
            moved = self.probes.with_vector((at[:, None] + moves[:, :, None]).reshape(-1, 3))
            shape = _per_row(effect, shapes, 6 * vector.shape[1])
            columns = effect.evaluate(moved, shape).reshape(len(at), -1, len(size[0]))
            up, down = np.moveaxis((columns @ size[:, :, None]).reshape(len(at), 2, 3, -1, 3), 1, 0)
            slope = ((up - down) / (2 * step)[:, None, None, None]).transpose(0, 2, 3, 1)
            if not effect.orthogonal:
                slope = axes.to_orthogonal[:, None] @ slope @ axes.to_sensed[:, None]
            total += slope
        return total

    def _directions(self, s: FloatArray, slope: FloatArray | None) -> FloatArray:
        """What every data row shows of an error of its pose's vector, (S, d, 3), per SI unit."""
        chosen = self.one.magnitude
        turning = s[:, chosen]
        size = np.linalg.norm(turning, axis=2)
        along = turning / (np.maximum(size, NO_LENGTH) * self.magnitude_sd)[:, :, None]
        if slope is not None:
            transposed = slope[:, chosen].swapaxes(2, 3)
            along = np.linalg.solve(transposed, along[..., None])[..., 0]
        at_rest = np.eye(3) / self.null_sd[..., None]
        return np.concatenate([along, at_rest.reshape(len(s), -1, 3)], axis=1)


def is_listed(effect: Effect) -> bool:
    """Whether one call evaluates it for many sets: it is of the catalogue, or follows a column."""
    listed = EFFECTS.get(effect.name)
    known = listed is not None and listed.columns is effect.columns
    return known or effect.is_column


def is_mark(effect: Effect, at: Conditions) -> bool:
    """Whether it errs by a fixed amount in the poses of its own set, whatever they read."""
    return (effect.acts_on == "sensor" and effect.orthogonal and effect.shape is None
            and not follows_vector(effect, at))


def _per_row(effect: Effect, shapes: Shapes, rows: int) -> FloatArray | None:
    """The shape parameter of every row, (S rows, 1)."""
    return None if effect.shape is None else np.repeat(shapes[effect.name], rows)[:, None]
