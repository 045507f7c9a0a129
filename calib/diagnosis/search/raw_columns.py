"""What every hypothesis would leave in the whitened rows, nothing projected out.

Columns lie as rows of one array, those of a hypothesis one after another: everything that is done
to them then runs along the memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import (
    is_rounding,
    reference_columns,
    vector_columns,
)
from calib.fit.least_squares.result import Fit
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
        """Those at the solution ``fit``; ``root`` (r,) are the roots of the rows' weights."""
        reference, vector, size, axes = _in_groups(hypotheses)
        parts = [_of_reference(fit, hypotheses[j]) for j in reference]
        widths = [len(part) for part in parts]
        for group, columns in ((vector, _of_effects), (size, _of_courses), (axes, _of_courses)):
            if group:
                part, each = columns(fit, [hypotheses[j] for j in group])
                parts.append(part)
                widths += each
        order = np.array([*reference, *vector, *size, *axes], int)
        width, start = np.zeros((2, len(hypotheses)), int)
        width[order] = widths
        start[order] = np.cumsum(widths, dtype=int) - width[order]
        rows = np.zeros((sum(widths), len(root)))
        if parts:
            d = fit.equations.data_count
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


def _of_reference(fit: Fit, hypothesis: Hypothesis) -> FloatArray:
    """Columns (k, d) of an effect on the reference."""
    assert hypothesis.effect is not None
    return reference_columns(fit, hypothesis.effect).T


def _of_effects(fit: Fit, hypotheses: Sequence[Hypothesis]) -> tuple[FloatArray, list[int]]:
    """Columns (k, d) of effects on the vectors, and how many each has."""
    errors = [h.errors(fit) for h in hypotheses]
    columns = vector_columns(fit, np.concatenate(errors, axis=2))
    return columns.T, [each.shape[2] for each in errors]


def _of_courses(fit: Fit, hypotheses: Sequence[Hypothesis]) -> tuple[FloatArray, list[int]]:
    """Columns (k, d) of courses of one kind, all of size or all on the axes, and how many each."""
    courses = [h.course for h in hypotheses if h.course is not None]
    values = np.concatenate([course.values for course in courses], axis=1)  # (n, courses, a)
    directions = fit.equations.directions(fit.rows.vector, fit.rows.slope)
    whole = (values**2).sum(axis=0).ravel()
    if courses[0].is_of_size:
        directions = _along_vectors(fit, directions)
        whole = ((values[fit.equations.magnitude]) ** 2).sum(axis=0).ravel()
    felt = np.ascontiguousarray(values.transpose(1, 2, 0))[:, :, fit.equations.row_pose]
    columns = (felt * directions.T).reshape(-1, len(directions))
    columns[is_rounding(fit, (columns**2).sum(axis=1), whole)] = 0.0
    return columns, [course.values[0].size for course in courses]


def _along_vectors(fit: Fit, directions: FloatArray) -> FloatArray:
    """What every data row shows of an error in the length of its vector, (d, 1); 0 at rest."""
    s = fit.rows.vector[fit.equations.magnitude]
    along = np.zeros((len(directions), 1))
    unit = s / np.linalg.norm(s, axis=1, keepdims=True)
    along[: len(s), 0] = (directions[: len(s)] * unit).sum(axis=1)
    return along
