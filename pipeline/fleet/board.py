"""Table of missing effects: a row for each session, a column for each effect of the lot."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.units import display_unit
from calib.poses.imu_log import BoolArray, FloatArray
from calib.rounding import with_sd
from pipeline.fleet.limits import FAIL
from pipeline.fleet.table import SIZE, SIZE_SD, column

if TYPE_CHECKING:
    from pandas import DataFrame

LEVELS = (2.0, 5.0, 20.0)
"""Sizes over their sds from which a cell is darker. A judgement: not there, perhaps, clear, plain.
"""
MISSING, MODELLED = "missing", "modelled"  #: an effect that a session names, or has in its model


@dataclass(frozen=True)
class BoardCell:
    """One effect in one session.

    ``state`` is ``missing``, ``modelled`` or empty, ``text`` its size with its sd in the unit of
    the column, ``level`` from 0 how many sds it is, ``order`` that number itself.
    """

    state: str
    text: str
    level: int
    order: float


@dataclass(frozen=True)
class BoardRow:
    """One session: its sensor, name, verdict and the cells of all columns."""

    sensor: str
    session: str
    verdict: str
    cells: tuple[BoardCell, ...]
    limits: str


@dataclass(frozen=True)
class Board:
    """The table: names of its columns, each with its unit, and its rows, the worst first."""

    effects: tuple[tuple[str, str], ...]
    rows: tuple[BoardRow, ...]


@dataclass(frozen=True, eq=False)
class _Column:
    """One effect in all n sessions: where it is missing or modelled, and its size and sd, (n,).

    ``order`` is the size in sds, 0 where it is not known, ``factor`` from SI to ``unit``.
    """

    name: str
    unit: str
    factor: float
    is_missing: BoolArray
    is_modelled: BoolArray
    size: FloatArray
    sd: FloatArray
    order: FloatArray

    def cell(self, i: int) -> BoardCell:
        """The cell of session ``i``."""
        state = MISSING if self.is_missing[i] else MODELLED if self.is_modelled[i] else ""
        order = float(self.order[i])
        text = (with_sd(self.size[i] * self.factor, self.sd[i] * self.factor) if order
                else "named" if state else "")
        return BoardCell(state, text, sum(order > level for level in LEVELS), order)


def board_of(rows: "DataFrame", triad: str, most: int) -> Board:
    """The board of the sessions of one triad, of at most ``most`` rows.

    Sessions beyond a limit come first, then those that lack the most effects, and the largest.
    """
    missing, modelled = _holding(rows, "missing"), _holding(rows, "model")
    sizes = {name.removeprefix(f"{SIZE}_") for name in rows.columns}
    none = np.zeros(len(rows), dtype=bool)
    columns = [_column_of(rows, name, triad, missing.get(name, none), modelled.get(name, none))
               for name in sorted({*missing, *(sizes & {*modelled})})]
    lacking, largest = np.zeros(len(rows)), np.zeros(len(rows))
    for one in columns:
        lacking += one.is_missing
        largest = np.maximum(largest, one.order * one.is_missing)
    fails = rows["limits"].str.startswith(FAIL).to_numpy() if "limits" in rows else none
    worst = np.lexsort((-largest, -lacking, ~fails))[:most]
    return Board(
        tuple((one.name, one.unit) for one in columns),
        tuple(BoardRow(str(row.sensor), str(row.session), str(row.verdict),
                       tuple(one.cell(i) for one in columns), getattr(row, "limits", ""))
              for i, row in zip(worst, rows.iloc[worst].itertuples(), strict=True)))


def _holding(rows: "DataFrame", key: str) -> dict[str, BoolArray]:
    """Rows (n,) that contain each name of a column of names, such as ``a + b``."""
    if key not in rows:
        return {}
    which, texts = rows[key].fillna("").factorize()
    sets = [{*text.split(" + ")} - {""} for text in texts]
    return {name: np.array([name in one for one in sets])[which]
            for name in set().union(*sets)}


def _column_of(
    rows: "DataFrame", name: str, triad: str, is_missing: BoolArray, is_modelled: BoolArray
) -> _Column:
    size, sd = column(rows, f"{SIZE}_{name}"), column(rows, f"{SIZE_SD}_{name}")
    try:
        unit, factor = display_unit(find_effect(name).unit_for(triad), size[np.isfinite(size)])
    except UnknownEffect:  # a user's own
        unit, factor = "SI", 1.0
    is_sized = (is_missing | is_modelled) & np.isfinite(size) & np.isfinite(sd) & (sd > 0)
    order = np.where(is_sized, np.abs(size) / np.where(is_sized, sd, 1.0), 0.0)
    return _Column(name, unit, factor, is_missing, is_modelled, size, sd, order)
