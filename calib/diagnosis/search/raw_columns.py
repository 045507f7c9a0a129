"""What every hypothesis would leave in the whitened rows of many fits, nothing projected out.

Effects are row by row by law, so that one call evaluates them on the poses of all fits. Columns lie
as rows of one array, those of a hypothesis one after another: everything that is done to them then
runs along the memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.joint_conditions import JointConditions
from calib.effects.effect import Effect
from calib.fit.least_squares.identifiability import ROUNDING
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.square_start import square_products
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class RawColumns:
    """The columns of m hypotheses over r rows of S fits.

    Parameters
    ----------
    rows : array, shape (S, c, r)
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
    def of(
        cls, fits: Sequence[Fit], hypotheses: Sequence[Sequence[Hypothesis]], root: FloatArray
    ) -> "RawColumns":
        """Those at the solutions ``fits``, which are alike, as are their ``hypotheses``.

        ``root`` (S, r) are the roots of the rows' weights.
        """
        reference, vector, size, axes = _in_groups(hypotheses[0])
        at = JointConditions.of(fits)
        d = fits[0].equations.data_count
        parts = [np.zeros((len(fits), 0, d))]
        widths: list[int] = []
        for j in reference:
            parts.append(_of_reference(at, [each[j] for each in hypotheses]))
            widths.append(parts[-1].shape[1])
        for group, columns in ((vector, _of_effects), (size, _of_courses), (axes, _of_courses)):
            if group:
                part, count = columns(at, [[each[j] for j in group] for each in hypotheses])
                parts.append(part)
                widths += count
        order = np.array([*reference, *vector, *size, *axes], int)
        width, start = np.zeros((2, len(hypotheses[0])), int)
        width[order] = widths
        start[order] = np.cumsum(widths, dtype=int) - width[order]
        rows = np.zeros((len(fits), sum(widths), root.shape[1]))
        np.multiply(np.concatenate(parts, axis=1), root[:, None, :d], out=rows[:, :, :d])
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


def _of_reference(at: JointConditions, alike: Sequence[Hypothesis]) -> FloatArray:
    """Columns (S, k, d) of one effect on the reference."""
    effect, equations = _effect_of(alike[0]), at.fits[0].equations
    errors = at.of_effect(effect, [None] * len(alike))[:, equations.magnitude]
    sd = np.array([fit.equations.magnitude_sd for fit in at.fits])
    columns = np.zeros((len(errors), errors.shape[2], equations.data_count))
    columns[:, :, : len(equations.magnitude)] = (errors / sd[:, :, None]).swapaxes(1, 2)
    return columns


def _of_effects(
    at: JointConditions, hypotheses: Sequence[Sequence[Hypothesis]]
) -> tuple[FloatArray, list[int]]:
    """Columns (S, k, d) of effects on the vectors, and how many each has."""
    errors = [_errors(at, [each[i] for each in hypotheses]) for i in range(len(hypotheses[0]))]
    vectors = np.concatenate(errors, axis=3)
    rows = np.einsum("sdi,sdik->skd", at.directions, vectors[:, at.row_pose], optimize=True)
    rows[_is_rounding(at, (rows**2).sum(axis=2), (vectors**2).sum(axis=(1, 2)))] = 0.0
    return rows, [each.shape[3] for each in errors]


def _errors(at: JointConditions, alike: Sequence[Hypothesis]) -> FloatArray:
    """Errors (S, n, 3, k) of one effect; a shape parameter that a fit fitted is as fitted."""
    effect, name = _effect_of(alike[0]), alike[0].name
    if effect.in_square and name not in at.fits[0].model.names:
        return _square_errors(at, effect)
    shapes = [None if h.shape is None else fit.shapes.get(name, h.shape)
              for fit, h in zip(at.fits, alike, strict=True)]
    return at.of_effect(effect, shapes)


def _square_errors(at: JointConditions, effect: Effect) -> FloatArray:
    """:func:`..hypotheses.signature.square_vectors` of all fits, (S, n, 3, k (k + 1) / 2)."""
    s = np.array([fit.rows.vector for fit in at.fits])
    chosen = at.fits[0].equations.magnitude
    columns = square_products(effect.evaluate(at.corrected), at.corrected.vector)
    direction = s / np.linalg.norm(s, axis=2, keepdims=True)
    vectors = np.zeros((*s.shape, columns.shape[1]))
    errors = direction[..., None] * columns.reshape(*s.shape[:2], 1, -1)
    vectors[:, chosen] = errors[:, chosen]
    return vectors


def _effect_of(hypothesis: Hypothesis) -> Effect:
    assert hypothesis.effect is not None
    return hypothesis.effect


def _of_courses(
    at: JointConditions, hypotheses: Sequence[Sequence[Hypothesis]]
) -> tuple[FloatArray, list[int]]:
    """Columns (S, k, d) of courses of one kind, all of size or all on the axes, and how many each.
    """
    values = np.array([
        np.concatenate([h.course.values for h in each if h.course is not None], axis=1)
        for each in hypotheses
    ])  # (S, n, courses, a)
    directions, counted = at.directions, values
    if values.shape[3] == 1:
        directions = at.along_vectors
        counted = values[:, at.fits[0].equations.magnitude]
    whole = (counted**2).sum(axis=1).reshape(len(values), -1)
    of_rows = values.transpose(0, 2, 3, 1)[..., at.row_pose]
    columns = (of_rows * directions.swapaxes(1, 2)[:, None]).reshape(*whole.shape, -1)
    columns[_is_rounding(at, (columns**2).sum(axis=2), whole)] = 0.0
    return columns, [h.course.values[0].size for h in hypotheses[0] if h.course is not None]


def _is_rounding(at: JointConditions, shown: FloatArray, whole: FloatArray) -> FloatArray:
    """Which columns (S, k) are rounding, as :func:`..hypotheses.signature.is_rounding` has it."""
    return np.asarray(np.sqrt(shown) < ROUNDING * np.sqrt(whole) / at.typical_sd[:, None])
