"""Which sensor lacks which effect: a row for each session, a column for each effect of the lot."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.units import display_unit
from calib.rounding import with_sd
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

    @property
    def worst(self) -> tuple[bool, int, float]:
        """What sorts rows: beyond a limit first, then by the effects that are missing."""
        missing = [cell.order for cell in self.cells if cell.state == MISSING]
        return self.limits.startswith("fail"), len(missing), max(missing, default=0.0)


@dataclass(frozen=True)
class Board:
    """The table: names of its columns, each with its unit, and its rows, the worst first."""

    effects: tuple[tuple[str, str], ...]
    rows: tuple[BoardRow, ...]


def board_of(rows: "DataFrame", triad: str, most: int) -> Board:
    """The board of the sessions of one triad; at most so many rows."""
    missing = [{*text.split(" + ")} - {""} for text in rows["missing"].fillna("")]
    models = rows["model"].fillna("") if "model" in rows else [""] * len(rows)
    modelled = [{*text.split(" + ")} for text in models]
    sizes = {name.removeprefix(f"{SIZE}_") for name in rows.columns
             if name.startswith(f"{SIZE}_") and not name.startswith(SIZE_SD)}
    effects = [name for name in sorted(sizes | set().union(*missing))
               if any(name in one or name in other
                      for one, other in zip(missing, modelled, strict=True))]
    columns = {name: _cells(rows, name, triad, missing, modelled) for name in effects}
    limits = rows["limits"].fillna("") if "limits" in rows else [""] * len(rows)
    every = [BoardRow(str(sensor), str(session), str(verdict),
                      tuple(columns[name][1][i] for name in effects), str(limit))
             for i, (sensor, session, verdict, limit) in enumerate(zip(
                 rows["sensor"], rows["session"], rows["verdict"], limits, strict=True))]
    every.sort(key=lambda row: row.worst, reverse=True)
    return Board(tuple((name, columns[name][0]) for name in effects), tuple(every[:most]))


def _cells(
    rows: "DataFrame", name: str, triad: str, missing: Sequence[set[str]],
    modelled: Sequence[set[str]],
) -> tuple[str, list[BoardCell]]:
    """The unit of one column and its cells."""
    size, sd = column(rows, f"{SIZE}_{name}"), column(rows, f"{SIZE_SD}_{name}")
    try:
        unit, factor = display_unit(find_effect(name).unit_for(triad), size[np.isfinite(size)])
    except UnknownEffect:  # a user's own
        unit, factor = "SI", 1.0
    cells = []
    for value, own_sd, named, model in zip(size, sd, missing, modelled, strict=True):
        state = MISSING if name in named else MODELLED if name in model else ""
        is_sized = state and np.isfinite(value) and np.isfinite(own_sd) and own_sd > 0
        order = abs(value / own_sd) if is_sized else 0.0
        text = with_sd(value * factor, own_sd * factor) if is_sized else "named" if state else ""
        cells.append(BoardCell(state, text, sum(order > level for level in LEVELS), order))
    return unit, cells
