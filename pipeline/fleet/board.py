"""Table of missing effects: a row for each session, a column for each effect of the lot."""

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

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
class Board:
    """The table: names of its columns, each with its unit, and its rows, the worst first.

    A row is that of the session in the table of the lot, with its cells.
    """

    effects: tuple[tuple[str, str], ...]
    rows: tuple[tuple[Any, tuple[BoardCell, ...]], ...]


def board_of(rows: "DataFrame", triad: str, most: int) -> Board:
    """The board of the sessions of one triad, of at most ``most`` rows.

    Sessions beyond a limit come first, then those that lack the most effects, and the largest.
    """
    missing, modelled = _holding(rows, "missing"), _holding(rows, "model")
    sizes = {name.removeprefix(f"{SIZE}_") for name in rows.columns}
    none = np.zeros(len(rows), dtype=bool)
    lacking, largest = np.zeros(len(rows)), np.zeros(len(rows))
    effects, cells = [], []
    for name in sorted({*missing, *(sizes & {*modelled})}):
        is_missing, is_modelled = missing.get(name, none), modelled.get(name, none)
        size, sd = column(rows, f"{SIZE}_{name}"), column(rows, f"{SIZE_SD}_{name}")
        is_sized = (is_missing | is_modelled) & np.isfinite(size) & np.isfinite(sd) & (sd > 0)
        order = np.where(is_sized, np.abs(size) / np.where(is_sized, sd, 1.0), 0.0)
        lacking += is_missing
        largest = np.maximum(largest, order * is_missing)
        try:
            unit, factor = display_unit(find_effect(name).unit_for(triad), size[np.isfinite(size)])
        except UnknownEffect:  # a user's own
            unit, factor = "SI", 1.0
        effects.append((name, unit))
        state = np.where(is_missing, 2, is_modelled).astype(np.int8)
        cells.append(partial(_cell, state, factor * size, factor * sd, order))
    fails = rows["limits"].str.startswith(FAIL).to_numpy() if "limits" in rows else none
    worst = np.lexsort((-largest, -lacking, ~fails))[:most]
    return Board(tuple(effects), tuple(
        (row, tuple(cell(i) for cell in cells))
        for i, row in zip(worst, rows.iloc[worst].itertuples(), strict=True)))


def _cell(
    states: NDArray[np.int8], size: FloatArray, sd: FloatArray, order: FloatArray, i: int
) -> BoardCell:
    """The cell of session ``i``; the others are of all n sessions, (n,), ``order`` 0 if unknown."""
    state, sds = ("", MODELLED, MISSING)[states[i]], float(order[i])
    text = with_sd(size[i], sd[i]) if sds else "named" if state else ""
    return BoardCell(state, text, sum(sds > level for level in LEVELS), sds)


def _holding(rows: "DataFrame", key: str) -> dict[str, BoolArray]:
    """Rows (n,) that contain each name of a column of names, such as ``a + b``."""
    if key not in rows:
        return {}
    which, texts = rows[key].fillna("").factorize()
    sets = [{*text.split(" + ")} - {""} for text in texts]
    return {name: np.array([name in one for one in sets])[which]
            for name in set().union(*sets)}
