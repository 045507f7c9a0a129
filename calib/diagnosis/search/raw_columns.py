"""Columns of every hypothesis in the whitened rows of a fit, nothing projected out.

Columns lie as rows of one array, those of a hypothesis one after another: everything that is done
to them then runs along the memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import (
    is_rounding,
    reference_columns,
    square_vectors,
    with_waves,
)
from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class RawColumns:
    """The columns of m hypotheses over r rows.

    Parameters
    ----------
    rows : array, shape (c, r)
        Each column as a row; zero over the rows of the common errors.
    start, width : array, shape (m,)
        Where those of each hypothesis begin, and how many it has.
    owner : array, shape (c,)
        Whose each column is.
    """

    rows: FloatArray
    start: IntArray
    width: IntArray
    owner: IntArray

    @classmethod
    def of(cls, fit: Fit, hypotheses: Sequence[Hypothesis], root: FloatArray) -> "RawColumns":
        """The columns at the solution ``fit``; ``root`` (r,) are the roots of the rows' weights."""
        reference, vector, size, axes = _in_groups(hypotheses)
        at, d = _Solution(fit), fit.equations.data_count
        parts = [np.zeros((0, d))]
        widths: list[int] = []
        for j in reference:
            parts.append(at.of_reference(_effect_of(hypotheses[j])))
            widths.append(len(parts[-1]))
        for group, columns in ((vector, at.of_effects), (size, at.of_courses),
                               (axes, at.of_courses)):
            if group:
                part, count = columns([hypotheses[j] for j in group])
                parts.append(part)
                widths += count
        order = np.array([*reference, *vector, *size, *axes], int)
        width, start = np.zeros((2, len(hypotheses)), int)
        width[order] = widths
        start[order] = np.cumsum(widths, dtype=int) - width[order]
        rows = np.zeros((sum(widths), len(root)))
        np.multiply(np.concatenate(parts), root[:d], out=rows[:, :d])
        return cls(rows, start, width, np.repeat(order, width[order]))


def _in_groups(hypotheses: Sequence[Hypothesis]) -> tuple[list[int], ...]:
    """Which of them err on the reference, by an effect, in size, and on each axis."""
    groups: tuple[list[int], ...] = ([], [], [], [])
    for j, h in enumerate(hypotheses):
        if h.course is not None:
            groups[2 if h.course.is_of_size else 3].append(j)
        else:
            groups[0 if h.on_reference else 1].append(j)
    return groups


def _effect_of(hypothesis: Hypothesis) -> Effect:
    assert hypothesis.effect is not None
    return hypothesis.effect


@dataclass(frozen=True, eq=False)
class _Solution:
    """Conditions of the hypotheses at the solution ``fit``."""

    fit: Fit

    @cached_property
    def corrected(self) -> Conditions:
        """Conditions with the corrected vectors; a pose at rest is held at its expected reading."""
        return self.fit.equations.conditions(self.fit.rows.vector)

    @cached_property
    def sensed(self) -> Conditions:
        """Conditions with the vectors of the sensitive axes."""
        to_sensed = self.fit.rows.axes.to_sensed
        return self.corrected.with_vector(self.corrected.vector @ to_sensed.T)

    @cached_property
    def directions(self) -> FloatArray:
        """Sensitivity of every data row to an error of its pose's vector, per SI unit, (d, 3)."""
        return self.fit.equations.directions(self.fit.rows.vector, self.fit.rows.slope)

    @cached_property
    def along_vectors(self) -> FloatArray:
        """Sensitivity of data rows to an error in their vector's length, per SI unit, (d, 1)."""
        chosen = self.fit.equations.magnitude
        s = self.fit.rows.vector[chosen]
        unit = s / np.maximum(np.linalg.norm(s, axis=1, keepdims=True), NO_LENGTH)
        along = np.zeros((len(self.directions), 1))
        along[: len(chosen), 0] = (self.directions[: len(chosen)] * unit).sum(axis=1)
        return along

    def of_reference(self, effect: Effect) -> FloatArray:
        """Columns (k, d) of an effect on the reference."""
        varying = about_mean(effect, self.fit.model.names)
        return reference_columns(self.fit, varying).T

    def of_effects(self, hypotheses: Sequence[Hypothesis]) -> tuple[FloatArray, list[int]]:
        """Columns (k, d) of effects on the vectors, and how many each has."""
        errors = [self._errors(h) for h in hypotheses]
        vectors = np.concatenate(errors, axis=2)
        rows = np.einsum("di,dik->kd", self.directions, vectors[self.fit.equations.row_pose],
                         optimize=True)
        whole = (vectors**2).sum(axis=(0, 1))
        rows[is_rounding(self.fit, (rows**2).sum(axis=1), whole)] = 0.0
        widths = [each.shape[2] for each in errors]
        for h, last, width in zip(hypotheses, np.cumsum(widths), widths, strict=True):
            if not _effect_of(h).in_square:
                mine = slice(last - width, last)
                with_waves(self.fit, rows[mine].T, _effect_of(h), self._shape(h))
        return rows, widths

    def _shape(self, h: Hypothesis) -> float | None:
        return None if h.shape is None else self.fit.shapes.get(h.name, h.shape)

    def _errors(self, h: Hypothesis) -> FloatArray:
        """Errors (n, 3, k) of one effect; a shape parameter that the fit has is as fitted."""
        effect, fitted = _effect_of(h), self.fit.model.names
        if effect.in_square and h.name not in fitted:
            return square_vectors(self.fit, effect)
        shape = self._shape(h)
        varying = about_mean(effect, fitted)
        if effect.acts_on == "reading":
            return varying.evaluate(self.fit.equations.at_reading, shape)
        if effect.orthogonal:
            return varying.evaluate(self.corrected, shape)
        errors = varying.evaluate(self.sensed, shape)
        return np.asarray(self.fit.rows.axes.to_orthogonal @ errors)

    def of_courses(self, hypotheses: Sequence[Hypothesis]) -> tuple[FloatArray, list[int]]:
        """Columns (k, d) of courses, all of size or all on the axes, and how many each has."""
        courses = [h.course.values for h in hypotheses if h.course is not None]
        values = np.concatenate(courses, axis=1)  # (n, courses, a)
        equations, directions, counted = self.fit.equations, self.directions, values
        if values.shape[2] == 1:
            directions, counted = self.along_vectors, values[equations.magnitude]
        whole = (counted**2).sum(axis=0).ravel()
        of_rows = values.transpose(1, 2, 0)[..., equations.row_pose]
        columns = (of_rows * directions.T).reshape(len(whole), -1)
        columns[is_rounding(self.fit, (columns**2).sum(axis=1), whole)] = 0.0
        return columns, [each[0].size for each in courses]
