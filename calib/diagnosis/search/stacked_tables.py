"""Tables of hypotheses at many solutions of one shape, as stacked arrays."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Projector
from calib.diagnosis.search.raw_columns import RawColumns
from calib.diagnosis.search.table import Spectrum, Table
from calib.effects.effect import EFFECTS
from calib.fit.column_scaling import NORM_FLOOR, RANK_TOLERANCE
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class TableAt:
    """Asks for the table of ``hypotheses`` at ``fit``, whose effects ``members`` are on trial."""

    fit: Fit
    hypotheses: Sequence[Hypothesis]
    members: Sequence[str] = ()

    @property
    def shape(self) -> tuple[object, ...]:
        """What requests share that are answered as one stack."""
        equations, names = self.fit.equations, self.fit.model.names
        return (
            self.fit.rows.residual.shape, equations.magnitude.tobytes(), "bias" in names,
            tuple(self.fit.poses.columns),
            tuple(_kind(h, names) for h in self.hypotheses),
        )


def _kind(hypothesis: Hypothesis, fitted: Sequence[str]) -> tuple[object, ...]:
    """What two hypotheses share whose columns are made in one call."""
    if hypothesis.course is not None:
        return (hypothesis.kind, hypothesis.course.values.shape)
    name, effect = hypothesis.name, hypothesis.effect
    of_catalogue = effect is not None and (EFFECTS.get(name) is effect or effect.is_column)
    # What is fitted has a derivative of its own, not only its square.
    by_square = effect is not None and effect.in_square and name not in fitted
    return (name if of_catalogue else id(effect), by_square)


@dataclass(frozen=True, eq=False)
class _Block:
    """The turned columns of w hypotheses of k columns each at S solutions.

    ``turned`` (S, w, v, r), which of them are ``visible`` (S, w, v); ``spectrum`` of those with an
    effect: their turns (S, w, k, k), squared lengths and products with the residual (S, w, k).
    """

    which: IntArray
    index: IntArray
    turned: FloatArray
    visible: BoolArray
    spectrum: tuple[FloatArray, FloatArray, FloatArray] | None


@dataclass(frozen=True, eq=False)
class _Spectra(Mapping[int, Spectrum]):
    """The spectra of table number ``at``, taken out of its stack when they are asked for."""

    place: Mapping[int, tuple[_Block, int]]
    unit: FloatArray
    at: int

    def __getitem__(self, j: int) -> Spectrum:
        block, i = self.place[j]
        assert block.spectrum is not None
        turns, squared, along = (each[self.at, i] for each in block.spectrum)
        return Spectrum(turns, squared, along, self.unit[block.index[i]])

    def __iter__(self) -> Iterator[int]:
        return iter(self.place)

    def __len__(self) -> int:
        return len(self.place)


def tables_at(requests: Sequence[TableAt]) -> list[Table]:
    """The tables of requests of one :attr:`TableAt.shape`.

    Parameters
    ----------
    requests : sequence of TableAt

    Returns
    -------
    list of Table
        In their order.
    """
    fits = [each.fit for each in requests]
    projectors = Projector.each(fits, [each.members for each in requests])
    residual = np.array([each.residual for each in projectors])
    model = _side_by_side([each.model for each in projectors])
    root = np.array([each.root for each in projectors])
    hypotheses = [each.hypotheses for each in requests]
    raw = RawColumns.of(fits, hypotheses, root)
    unit, total = _units(raw, hypotheses[0], projectors[0].data_count)
    projected = raw.rows * unit[:, :, None]
    projected -= (projected @ model) @ model.swapaxes(1, 2)
    # One that was fitted was seen where its shape began; where that ended, less of it may be.
    least = total * np.array([
        [RANK_TOLERANCE if h.shape is not None and h.name in each.members else VISIBLE_SHARE
         for h in each.hypotheses] for each in requests
    ])
    beside = _complement(model)
    blocks = [_turned(which, hypotheses[0][which[0]].effect is not None, raw, projected, residual,
                      least, beside)
              for which in _alike(raw, hypotheses[0])]
    return _tables(requests, projectors, blocks, total, unit)


def _complement(bases: FloatArray) -> FloatArray:
    """Orthonormal bases (S, r, c) of what is perpendicular to ``bases`` (S, r, k), in which
    columns of zeros stand for what one lacks; so they do in the result.
    """
    rank = bases.any(axis=1).sum(axis=1)
    sets, r, _ = bases.shape
    beside = np.zeros((sets, r, r - int(rank.min())))
    for k in np.unique(rank):
        some = np.flatnonzero(rank == k)
        whole = np.linalg.qr(bases[some, :, :k], mode="complete")[0]
        beside[some, :, : r - k] = whole[:, :, k:]
    return beside


def _side_by_side(bases: Sequence[FloatArray]) -> FloatArray:
    """Bases (r, k) of S models as (S, r, k), columns of zeros where one has fewer."""
    most = max(basis.shape[1] for basis in bases)
    stacked = np.zeros((len(bases), len(bases[0]), most))
    for each, basis in zip(stacked, bases, strict=True):
        each[:, : basis.shape[1]] = basis
    return stacked


def _alike(raw: RawColumns, hypotheses: Sequence[Hypothesis]) -> Iterator[IntArray]:
    """Hypotheses of equally many columns, those with an effect apart from those without."""
    has_effect = np.array([h.effect is not None for h in hypotheses], bool)
    for width in np.unique(raw.width[raw.width > 0]):
        for with_effect in (True, False):
            which = np.flatnonzero((raw.width == width) & (has_effect == with_effect))
            if len(which):
                yield which


def _turned(
    which: IntArray, has_effect: bool, raw: RawColumns, projected: FloatArray,
    residual: FloatArray, least: FloatArray, beside: FloatArray,
) -> _Block:
    """The columns of the hypotheses ``which`` turned until they are orthogonal."""
    width = int(raw.width[which[0]])
    index = raw.start[which][:, None] + np.arange(width)
    stacked = projected[:, index]  # (S, w, k, r)
    least = (least[:, which] ** 2)[:, :, None]
    if not has_effect and width > beside.shape[2]:
        # More columns than they have room for: by the eigenvectors of the room.
        inside = stacked @ beside[:, None]
        squared, turns = np.linalg.eigh(inside.swapaxes(2, 3) @ inside)
        size = np.sqrt(np.maximum(squared, 0.0))[:, :, None]
        turned = (beside[:, None] @ (turns * size)).swapaxes(2, 3)
        return _Block(which, index, turned, squared > least, None)
    squared, turns = np.linalg.eigh(stacked @ stacked.swapaxes(2, 3))
    turned = turns.swapaxes(2, 3) @ stacked
    along = np.einsum("swkr,sr->swk", turned, residual) if has_effect else np.zeros(0)
    spectrum = (turns, squared, along) if has_effect else None
    return _Block(which, index, turned, squared > least, spectrum)


def _tables(
    requests: Sequence[TableAt], projectors: Sequence[Projector], blocks: Sequence[_Block],
    total: FloatArray, unit: FloatArray,
) -> list[Table]:
    """The tables of a stack, each with its visible columns."""
    sets, m, r = len(requests), len(requests[0].hypotheses), projectors[0].residual.size
    first, seen = np.zeros((2, sets, m), int)
    before = np.zeros(sets, int)
    for block in blocks:
        count = block.visible.sum(axis=2)
        seen[:, block.which] = count
        ends = before[:, None] + np.cumsum(count, axis=1)
        first[:, block.which] = ends - count
        before = ends[:, -1]
    turned = np.concatenate(
        [np.zeros((sets, 0, r)), *(b.turned.reshape(sets, -1, r) for b in blocks)], axis=1
    )
    visible = np.concatenate(
        [np.zeros((sets, 0), bool), *(b.visible.reshape(sets, -1) for b in blocks)], axis=1
    )
    place = {int(j): (block, i) for block in blocks if block.spectrum is not None
             for i, j in enumerate(block.which)}
    return [
        Table(
            projector=projectors[s],
            log_prior=np.array([h.log_prior for h in requests[s].hypotheses]),
            total=total[s],
            rows=turned[s][visible[s]],
            first=first[s],
            seen=seen[s],
            spectra=_Spectra(place, unit[s], s),
        )
        for s in range(sets)
    ]


def _units(
    raw: RawColumns, hypotheses: Sequence[Hypothesis], rows: int
) -> tuple[FloatArray, FloatArray]:
    """Factor of every raw column (S, c), and the signal of each one's strongest column (S, m).

    All columns of a hypothesis together then have the signal of unit size.
    """
    owner, shape = raw.owner, (len(raw.rows), len(hypotheses))
    squared = (raw.rows**2).sum(axis=2)
    has_effect = np.array([h.effect is not None for h in hypotheses], bool)
    some = np.flatnonzero(raw.width)
    some = some[np.argsort(raw.start[some], kind="stable")]
    mean, largest, count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    mean[:, some] = np.add.reduceat(squared, raw.start[some], axis=1) / raw.width[some]
    # Not parameters of their own units: their proportions count.
    norm = np.sqrt(np.where(has_effect[owner] | (squared == 0), squared, mean[:, owner]))
    largest[:, some] = np.maximum.reduceat(norm, raw.start[some], axis=1)
    norm[norm <= NORM_FLOOR * np.maximum(largest, NO_LENGTH)[:, owner]] = np.inf
    count[:, some] = np.add.reduceat(np.isfinite(norm).astype(float), raw.start[some], axis=1)
    count = np.maximum(count, 1)
    signal = np.array([_unit_signal(h, rows) for h in hypotheses])
    unit = (signal / np.sqrt(count))[:, owner] / norm
    # Each combination of parameters of an effect is judged as the fit will judge it.
    is_listed = np.array([h.kind == "listed" for h in hypotheses], bool)
    return unit, signal / np.sqrt(np.where(is_listed, count, 1))


def _unit_signal(hypothesis: Hypothesis, rows: int) -> float:
    """Length of the signal of unit size: one sd in every row, or four of a bad pose's own."""
    return CONSTANTS.bad_pose_size if hypothesis.kind == "bad_pose" else float(np.sqrt(rows))
