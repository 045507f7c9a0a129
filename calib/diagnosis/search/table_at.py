"""The table of all hypotheses at one solution: their columns, whitened, of unit size, projected.

Columns lie as rows of arrays, those of a hypothesis one after another: everything that is done to
them then runs along the memory. Hypotheses of equally many columns are one array.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Linearisation, Projector, at_expected_readings
from calib.diagnosis.search.table import Spectrum, Table
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.fit.linear import NORM_FLOOR, RANK_TOLERANCE
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


def table_at(
    fit: Fit, hypotheses: Sequence[Hypothesis], members: Sequence[str] = ()
) -> Table:
    """The table of ``hypotheses`` at ``fit``, whose effects ``members`` are on trial."""
    fit = at_expected_readings(fit)
    projector = Projector(fit, members)
    # One that was fitted was seen where its shape began; where that ended, less of it may be.
    share = np.array([RANK_TOLERANCE if h.shape is not None and h.name in members else VISIBLE_SHARE
                      for h in hypotheses])
    first, seen = np.zeros((2, len(hypotheses)), int)
    spectra: dict[int, Spectrum] = {}
    rows, before = [np.zeros((0, len(projector.residual)))], 0
    for block in _blocks_of_one_width(fit, hypotheses, projector):
        squared, turns, turned = block.turned(projector)
        visible = squared > ((share[block.which] * block.signal) ** 2)[:, None]
        if block.has_effect:
            along = turned @ projector.residual
            spectra |= {int(j): Spectrum(*each) for j, *each in zip(
                block.which, turns, squared, along, block.unit, strict=True)}
            turned = alike_in_size(squared, turns, visible, block.alike)[1] @ turned
        rows.append(turned[visible])
        seen[block.which] = visible.sum(axis=1)
        first[block.which] = before + np.cumsum(seen[block.which]) - seen[block.which]
        before += len(rows[-1])
    return Table(
        projector, noise_of(fit, projector.dof), np.concatenate(rows), first, seen, spectra)


def whole_unit_columns(
    fit: Fit, hypotheses: Sequence[Hypothesis], projector: Projector
) -> dict[int, tuple[FloatArray, FloatArray]]:
    """Whitened columns (k, r) of every hypothesis at ``fit``, of unit size, nothing projected out.

    And what of each parameter (k,) that is, SI.
    """
    return {int(j): (columns * unit[:, None], unit)
            for block in _blocks_of_one_width(fit, hypotheses, projector)
            for j, columns, unit in zip(
                block.which, block.columns, block.unit * block.alike, strict=True)}


@dataclass(frozen=True, eq=False)
class _Block:
    """The hypotheses ``which`` (w,) of k columns each, all with an effect or all without.

    ``columns`` (w, k, r) are whitened, nothing projected out. With the factors ``unit`` (w, k) all
    columns of a hypothesis together have the signal of unit size; with ``alike`` (w, k) besides,
    its parameters are alike in size, as those of one unit are. One column has ``signal`` (w,).
    """

    which: IntArray
    columns: FloatArray
    has_effect: bool
    unit: FloatArray
    alike: FloatArray
    signal: FloatArray

    @classmethod
    def of(
        cls, which: IntArray, hypotheses: Sequence[Hypothesis], columns: FloatArray, rows: int
    ) -> "_Block":
        """The block of these ``columns`` of ``hypotheses`` (w), over so many data rows."""
        has_effect = hypotheses[0].effect is not None
        square = (columns**2).sum(axis=2)
        mean = square.mean(axis=1, keepdims=True)
        norm = np.sqrt(square if has_effect else np.where(square > 0, mean, 0.0))
        norm[norm <= NORM_FLOOR * np.maximum(norm.max(axis=1, keepdims=True), NO_LENGTH)] = np.inf
        used = np.isfinite(norm)
        count = np.maximum(used.sum(axis=1, keepdims=True), 1)
        signal = np.array([_unit_signal(h, rows) for h in hypotheses])
        # Each combination of parameters of an effect is judged as the fit will judge it.
        combined = np.where([h.course is None for h in hypotheses], count[:, 0], 1)
        # The orders of a curve have no unit in common.
        of_one_unit = np.array([h.effect is not None and (
            h.effect.shape is None or h.effect.shape.is_fitted) for h in hypotheses])
        alike = norm / np.sqrt(np.maximum(mean * columns.shape[1] / count, NO_LENGTH))
        return cls(
            which, columns, has_effect, signal[:, None] / np.sqrt(count) / norm,
            np.where(of_one_unit[:, None] & used, np.maximum(alike, VISIBLE_SHARE), 1.0),
            signal / np.sqrt(combined))

    def turned(self, projector: Projector) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The columns without the model, turned until they are orthogonal, (w, v, r).

        Before these their squared lengths (w, v), and the turns (w, k, v) of an effect.
        """
        rest = self.columns * self.unit[..., None]
        rest -= (rest @ projector.model) @ projector.model.T
        rows, fitted = projector.model.shape
        if self.has_effect or rest.shape[1] <= rows - fitted:
            squared, turns = np.linalg.eigh(rest @ rest.swapaxes(1, 2))
            return squared, turns, turns.swapaxes(1, 2) @ rest
        # More columns than they have room for: by the eigenvectors of the room.
        beside = np.linalg.qr(projector.model, mode="complete")[0][:, fitted:]
        inside = rest @ beside
        squared, turns = np.linalg.eigh(inside.swapaxes(1, 2) @ inside)
        size = np.sqrt(np.maximum(squared, 0.0))[:, None, :]
        return squared, turns, (beside @ (turns * size)).swapaxes(1, 2)


def alike_in_size(
    squared: FloatArray, turns: FloatArray, visible: BoolArray, alike: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Orthogonal columns of w effects whose k parameters are alike in size, not their signals.

    Parameters
    ----------
    squared, turns : array, shapes (w, k) and (w, k, k)
        Eigenvalues and eigenvectors of the Gram matrix of columns of equal length, no unit.
    visible : array of bool, shape (w, k)
        Which of these directions are kept.
    alike : array, shape (w, k)
        Length of each column by one size of all parameters, no unit.

    Returns
    -------
    squared, mixed : array, shapes (w, k) and (w, k, k)
        Their squared lengths, and what of each direction is in each, no unit.
    """
    seen = alike[:, :, None] * turns * visible[:, None, :]
    squared, again = np.linalg.eigh((seen * squared[:, None, :]) @ seen.swapaxes(1, 2))
    return np.maximum(squared, 0.0), again.swapaxes(1, 2) @ seen


def _unit_signal(hypothesis: Hypothesis, rows: int) -> float:
    """Length of the signal of unit size: one sd in every row, or four of a bad pose's own."""
    return CONSTANTS.bad_pose_size if hypothesis.kind == "bad_pose" else float(np.sqrt(rows))


def _blocks_of_one_width(
    fit: Fit, hypotheses: Sequence[Hypothesis], projector: Projector
) -> Iterator[_Block]:
    """All hypotheses by their number of columns, those with an effect apart from those without."""
    at, groups = Linearisation(fit), dict[tuple[int, bool], list[int]]()
    columns: dict[int, FloatArray] = {}
    for of_kind, which in _kinds(hypotheses).items():
        some = [hypotheses[j] for j in which]
        columns_of = _of_effects if of_kind < 2 else _of_courses if of_kind < 4 else _of_common
        unweighted, widths = columns_of(at, some)
        whitened = np.zeros((len(unweighted), len(projector.root)))
        d = unweighted.shape[1]
        np.multiply(unweighted, projector.root[:d], out=whitened[:, :d])
        parts = np.split(whitened, np.cumsum(widths)[:-1])
        columns |= dict(zip(which, parts, strict=True))
    for j, h in enumerate(hypotheses):
        if len(columns[j]):
            groups.setdefault((len(columns[j]), h.effect is not None), []).append(j)
    for _, which in sorted(groups.items()):
        yield _Block.of(np.array(which), [hypotheses[j] for j in which],
                        np.stack([columns[j] for j in which]), projector.data_count)


def _kinds(hypotheses: Sequence[Hypothesis]) -> dict[int, list[int]]:
    """Which of them err by an effect on the reference (0) or the vectors (1), or by a course, in
    length (2), on each axis (3) or of what is stated of the common errors (4)."""
    kinds: dict[int, list[int]] = {}
    for j, h in enumerate(hypotheses):
        kind = int(not h.on_reference) if h.course is None else (
            4 if h.course.on_common else 3 - int(h.course.is_of_size))
        kinds.setdefault(kind, []).append(j)
    return kinds


def _of_effects(
    at: Linearisation, hypotheses: Sequence[Hypothesis]
) -> tuple[FloatArray, list[int]]:
    """Columns (k, d) of effects, all on the reference or all on the vectors, and their numbers.

    A shape parameter that the fit has is as fitted.
    """
    fit, effects = at.fit, [h.effect for h in hypotheses if h.effect is not None]
    if hypotheses[0].on_reference:
        of_each = [at.of_reference(at.varying(effect)).T for effect in effects]
        return np.concatenate(of_each), [len(each) for each in of_each]
    shapes = [None if h.shape is None else fit.shapes.get(h.name, h.shape) for h in hypotheses]
    effects = [at.varying(effect) for effect in effects]
    errors = [at.squares(effect) if effect.in_square and effect.name not in fit.model.names
              else at.vectors(effect, shape)
              for effect, shape in zip(effects, shapes, strict=True)]
    rows = at.rows(np.concatenate(errors, axis=2))
    widths = [each.shape[2] for each in errors]
    for effect, shape, last, width in zip(
            effects, shapes, np.cumsum(widths), widths, strict=True):
        if not effect.in_square:
            at.with_waves(rows[:, last - width : last], effect, shape)
    return rows.T, widths


def _of_courses(
    at: Linearisation, hypotheses: Sequence[Hypothesis]
) -> tuple[FloatArray, list[int]]:
    """Columns (k, d) of courses, all of length or all on the axes, and how many each has."""
    courses = [h.course.values for h in hypotheses if h.course is not None]
    values = np.concatenate(courses, axis=1)  # (n, courses, a)
    equations, directions, counted = at.fit.equations, at.directions, values
    if values.shape[2] == 1:  # along the vectors
        chosen = equations.magnitude
        s = at.fit.rows.vector[chosen]
        unit = s / np.maximum(np.linalg.norm(s, axis=1, keepdims=True), NO_LENGTH)
        counted, directions = values[chosen], np.zeros((len(at.directions), 1))
        directions[: len(chosen), 0] = (at.directions[: len(chosen)] * unit).sum(axis=1)
    whole = (counted**2).sum(axis=0).ravel()
    of_rows = values.transpose(1, 2, 0)[..., equations.row_pose]
    columns = (of_rows * directions.T).reshape(len(whole), -1)
    return at.without_rounding(columns.T, whole).T, [each[0].size for each in courses]


def _of_common(
    at: Linearisation, hypotheses: Sequence[Hypothesis]
) -> tuple[FloatArray, list[int]]:
    """Columns (k, r) of courses of the prior rows, which are the last, and how many each has.

    In the data rows they would differ from the common errors by a share that is rounding if these
    are stated to be large.
    """
    courses = [h.course.values[:, :, 0] for h in hypotheses if h.course is not None]
    of_prior = np.concatenate(courses, axis=1).T
    data = np.zeros((len(of_prior), at.fit.equations.data_count))
    return np.hstack([data, of_prior]), [each.shape[1] for each in courses]
