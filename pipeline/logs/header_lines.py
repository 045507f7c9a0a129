"""Lines above the rows of a text table: names in one line or two, and their units."""

import re
from collections.abc import Sequence
from itertools import pairwise

from pipeline.logs.dialect import delimiter_of
from pipeline.logs.header_words import read_name, spelled_unit

MOST_NAMES = 4  #: fact: lines of names, units, comments and kinds of Origin and of Campbell loggers
OTHER_UNITS = ("deg", "ut", "µt", "gauss", "hz", "-", "hpa", "pa", "")  #: units of other columns


def wide_names(line: str, names: list[str], width: int) -> list[str]:
    """``names``, or, as many as cells in a row, those between two blanks: "t [s]  Acc. X [mg]"."""
    wide = re.split(r"\s{2,}", line.strip())
    return wide if delimiter_of(line) is None and len(wide) == width else names


def best_names(fitting: Sequence[tuple[int, list[str]]]) -> tuple[int, list[str]]:
    """The line above the rows, or two lines joined, in which most names are known, with the units
    of a line of units."""
    rows = [row for row in fitting[-MOST_NAMES:] if row is fitting[0] or not _are_units(row[1])]
    joined = [(at, [" ".join(dict.fromkeys(filter(None, pair))) for pair in zip(
        names, below, strict=True)]) for (_, names), (at, below) in pairwise(rows)
        if len(names) == len(below)]
    at, names = max([*joined, *rows], key=lambda row: (
        sum(read_name(name).quantity != "" for name in row[1]), row in rows, row[0]))
    return with_units(at, names, [cells for _, cells in fitting[1:]])


def with_units(
    at: int, names: list[str], others: Sequence[list[str]]
) -> tuple[int, list[str]]:
    """The line of names with the units of the last line of units among ``others``."""
    for units in [cells for cells in others if _are_units(cells)][-1:]:
        names = [f"{name} ({_bare_unit(unit)})" if unit else name
                 for name, unit in zip(names, units, strict=False)]
    return at, names


def _are_units(names: Sequence[str]) -> bool:
    """Whether most cells of a line are units, or words of a row that names its units."""
    units = [unit for unit in map(_bare_unit, names)
             if spelled_unit(unit) or unit.lower() in (*OTHER_UNITS, "units", "unit")]
    return len(units) > len(names) / 2 and any(map(spelled_unit, units))


def _bare_unit(cell: str) -> str:
    """``[m/s^2]`` -> ``m/s^2``; brackets inside a unit stay."""
    text = cell.strip()
    return text[1:-1].strip() if text[:1] in "([" and text[-1:] in ")]" else text
