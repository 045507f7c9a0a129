"""The table of all hypotheses at one solution."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Projector
from calib.diagnosis.search.raw_columns import RawColumns
from calib.diagnosis.search.table import Spectrum, Table
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.fit.linear import NORM_FLOOR, RANK_TOLERANCE
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class _Block:
    """The turned columns of w hypotheses of k columns each.

    ``turned`` (w, v, r), which of them are ``visible`` (w, v); ``spectra`` of those with an effect.
    """

    which: IntArray
    turned: FloatArray
    visible: BoolArray
    spectra: tuple[Spectrum, ...]


def table_at(
    fit: Fit, hypotheses: Sequence[Hypothesis], members: Sequence[str] = ()
) -> Table:
    """The table of ``hypotheses`` at ``fit``, whose effects ``members`` are on trial."""
    projector = Projector(fit, members)
    raw = RawColumns.of(fit, hypotheses, projector.root)
    unit, alike, total = _units(raw, hypotheses, projector.data_count)
    projected = raw.rows * unit[:, None]
    projected -= (projected @ projector.model) @ projector.model.T
    # One that was fitted was seen where its shape began; where that ended, less of it may be.
    least = total * np.array([
        RANK_TOLERANCE if h.shape is not None and h.name in members else VISIBLE_SHARE
        for h in hypotheses
    ])
    blocks = [_turned(which, hypotheses[which[0]].effect is not None, raw, projected, projector,
                      least, unit, alike)
              for which in _of_one_width(raw, hypotheses)]
    first, seen = np.zeros((2, len(hypotheses)), int)
    before = 0
    for block in blocks:
        count = block.visible.sum(axis=1)
        seen[block.which] = count
        ends = before + np.cumsum(count)
        first[block.which] = ends - count
        before = int(ends[-1])
    rows = [block.turned[block.visible] for block in blocks]
    return Table(
        projector=projector,
        noise=noise_of(fit, projector.dof),
        rows=np.concatenate([np.zeros((0, len(projector.residual))), *rows]),
        first=first,
        seen=seen,
        spectra={int(j): spectrum for block in blocks
                 for j, spectrum in zip(block.which, block.spectra, strict=False)},
    )


def unit_columns_of(
    fit: Fit, hypotheses: Sequence[Hypothesis], projector: Projector
) -> tuple[FloatArray, IntArray]:
    """Whitened columns (c, r) of hypotheses at ``fit``, of unit size, and whose each is, (c,).

    Nothing is projected out of them.
    """
    raw = RawColumns.of(fit, hypotheses, projector.root)
    unit, alike, _ = _units(raw, hypotheses, projector.data_count)
    return raw.rows * (unit * alike)[:, None], raw.owner


def _complement(basis: FloatArray) -> FloatArray:
    """Orthonormal basis (r, c) of what is perpendicular to an orthonormal one (r, k)."""
    return np.linalg.qr(basis, mode="complete")[0][:, basis.shape[1] :]


def _of_one_width(raw: RawColumns, hypotheses: Sequence[Hypothesis]) -> Iterator[IntArray]:
    """Hypotheses of equally many columns, those with an effect apart from those without."""
    has_effect = np.array([h.effect is not None for h in hypotheses], bool)
    for width in np.unique(raw.width[raw.width > 0]):
        for with_effect in (True, False):
            which = np.flatnonzero((raw.width == width) & (has_effect == with_effect))
            if len(which):
                yield which


def _turned(
    which: IntArray, has_effect: bool, raw: RawColumns, projected: FloatArray,
    projector: Projector, least: FloatArray, unit: FloatArray, alike: FloatArray,
) -> _Block:
    """The columns of the hypotheses ``which`` turned until they are orthogonal.

    What of an effect is visible is judged as the fit will judge it, column by column; how large
    it may be, by parameters that are alike in size.
    """
    width = int(raw.width[which[0]])
    index = raw.start[which][:, None] + np.arange(width)
    stacked = projected[index]  # (w, k, r)
    least = (least[which] ** 2)[:, None]
    rows, fitted = projector.model.shape
    if not has_effect and width > rows - fitted:
        # More columns than they have room for: by the eigenvectors of the room.
        beside = _complement(projector.model)
        inside = stacked @ beside
        squared, turns = np.linalg.eigh(inside.swapaxes(1, 2) @ inside)
        size = np.sqrt(np.maximum(squared, 0.0))[:, None, :]
        turned = (beside @ (turns * size)).swapaxes(1, 2)
        return _Block(which, turned, squared > least, ())
    squared, turns = np.linalg.eigh(stacked @ stacked.swapaxes(1, 2))
    turned = turns.swapaxes(1, 2) @ stacked
    visible = squared > least
    if not has_effect:
        return _Block(which, turned, visible, ())
    spectra = tuple(
        Spectrum(*each) for each in zip(turns, squared, turned @ projector.residual, unit[index],
                                        strict=True)
    )
    _, mixed = alike_in_size(squared, turns, visible, alike[index])
    return _Block(which, mixed @ turned, visible, spectra)


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


def _units(
    raw: RawColumns, hypotheses: Sequence[Hypothesis], rows: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Factor of every raw column (c,), a second one (c,), and the signal of one column (m,).

    All columns of a hypothesis together then have the signal of unit size; with the second factor
    its parameters are alike in size, as those of one unit are. The orders of a curve have no unit
    in common.
    """
    owner, m = raw.owner, len(hypotheses)
    squared = (raw.rows**2).sum(axis=1)
    has_effect = np.array([h.effect is not None for h in hypotheses], bool)
    some = np.flatnonzero(raw.width)
    some = some[np.argsort(raw.start[some], kind="stable")]
    mean, largest, count = np.zeros((3, m))
    if len(some):
        mean[some] = np.add.reduceat(squared, raw.start[some]) / raw.width[some]
    norm = np.sqrt(np.where(has_effect[owner] | (squared == 0), squared, mean[owner]))
    if len(some):
        largest[some] = np.maximum.reduceat(norm, raw.start[some])
    norm[norm <= NORM_FLOOR * np.maximum(largest, NO_LENGTH)[owner]] = np.inf
    if len(some):
        count[some] = np.add.reduceat(np.isfinite(norm).astype(float), raw.start[some])
    count = np.maximum(count, 1)
    signal = np.array([_unit_signal(h, rows) for h in hypotheses])
    unit = (signal / np.sqrt(count))[owner] / norm
    # Each combination of parameters of an effect is judged as the fit will judge it.
    is_listed = np.array([h.course is None for h in hypotheses], bool)
    alike = norm / np.sqrt(np.maximum(mean * raw.width / count, NO_LENGTH))[owner]
    of_one_unit = np.array([h.effect is not None and (
        h.effect.shape is None or h.effect.shape.is_fitted) for h in hypotheses], bool)
    alike = np.where(of_one_unit[owner] & np.isfinite(norm), np.maximum(alike, VISIBLE_SHARE), 1.0)
    return unit, alike, signal / np.sqrt(np.where(is_listed, count, 1))


def _unit_signal(hypothesis: Hypothesis, rows: int) -> float:
    """Length of the signal of unit size: one sd in every row, or four of a bad pose's own."""
    return CONSTANTS.bad_pose_size if hypothesis.kind == "bad_pose" else float(np.sqrt(rows))
