"""Texts whose samples are no rows: tables beside each other, or a value and its name in each row.

Both become tables of a row for each sample; its rows keep their line numbers in the file.
"""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from random import Random

from pipeline.logs.columns import SECONDS_PER
from pipeline.logs.dialect import (
    SHOWN,
    Dialect,
    delimiter_of,
    dialect_of,
    is_number,
    seconds_of,
    split_cells,
)
from pipeline.logs.head import (
    COMMENT_SIGNS,
    FEWEST_COUNTED,
    FEWEST_NUMBERS,
    LONGEST_HEAD,
    find_head,
    is_time,
)
from pipeline.logs.header_lines import MOST_NAMES
from pipeline.logs.header_words import axes_among, read_name
from pipeline.logs.row_kinds import MOST_KINDS

FEWEST_BLOCKS = 3  #: least number of blocks without times that are no axes of two sensors
RUN = re.compile(r"\b(?:run|set|trial|latest)\b[ #]*\d*\s*:?", re.IGNORECASE)
"""The words of a name by which a logger tells its recordings apart: ``Run 1: Time (s)``."""
CLOCKS_APART = 0.01
"""Largest log ratio of the rates of two clocks in one row that agree. A judgement: clocks of one
device differ by 1e-4, and one in whole seconds misses less than one second in a minute."""
STAMP = re.compile(
    r"(?<![A-Za-z])(?:tv_)?(n|nano|u|micro|m|milli)?s(?:ecs?|econds?)?$", re.IGNORECASE)
"""The end of the name of whole seconds, or of their parts: ``stamp.sec`` and ``stamp.nanosec``."""
PARTS = re.compile(r"(\d|.*[\d:]\d)\.(\d{1,9})")  #: a time up to its seconds, and parts of a second
DIGITS = {"m": 3, "milli": 3, "u": 6, "micro": 6, "n": 9, "nano": 9}  #: facts: of the parts
LEAST_WHOLE = 0.9  #: least share of the times of one value at which all others are there


def tables_beside(lines: Sequence[str]) -> Mapping[str, list[str]]:
    """The tables of a text that stand beside each other, each named by the cell above it or
    numbered; none if there is one.

    Their header repeats itself, or has clocks that go at different rates, each before its channels.
    """
    for at, line in enumerate(lines[:LONGEST_HEAD]):
        sign = delimiter_of(line)
        names = split_cells(line, sign)
        if sign is None or len(names) <= 2 * FEWEST_NUMBERS or any(map(is_number, names)):
            continue
        of_a_run = [RUN.sub("", name).strip() for name in names]
        tables = _repeated(of_a_run) or _of_each_clock(names, lines[at + 1 : at + SHOWN], sign)
        if not tables:
            continue
        rows = [split_cells(line, sign) for line in lines[at:]]
        above = [run[0] if (run := RUN.search(name)) else "" for name in names]
        if any(above):
            rows[0] = of_a_run
        elif at:
            above = split_cells(lines[at - 1], sign)
        titles = [next(filter(None, (above[i] for i in columns if i < len(above))), "")
                  .replace("/", " ").strip(" :") for columns in tables]
        if len({*titles}) < len(titles) or "" in titles:
            titles = [str(i + 1) for i in range(len(titles))]
        return {title: [""] * at + [_joined([row[i] for i in columns if i < len(row)], sign)
                                    for row in rows]
                for title, columns in zip(titles, tables, strict=True)}
    return {}


def _of_each_clock(names: Sequence[str], lines: Sequence[str], sign: str) -> list[list[int]]:
    """The columns of each clock, its times first; empty if all of them go at one rate."""
    if read_name(names[0]).quantity != "time":
        return []  # of nearly all lines
    times = [i for i, name in enumerate(names) if read_name(name).quantity == "time"]
    if len(times) == 1:
        return []
    rows = [split_cells(line, sign) for line in lines]
    comma = any("," in cell for row in rows[:MOST_NAMES] for cell in row)
    whole = [[cell.replace(",", ".") if comma else cell for cell in row] for row in rows
             if len(row) == len(names)]
    clocks: dict[float, list[int]] = {}
    for begin, end in pairwise([*times, len(names)]):
        ticks = [seconds for row in whole if (seconds := _seconds(row[begin])) is not None]
        length = ticks[-1] - ticks[0] if len(ticks) > 1 else 0.0
        if length <= 0 or any(one >= other for one, other in pairwise(ticks)):
            return []  # a temperature called T, or a time in whole seconds
        alike = next((other for other in clocks if any(
            abs(math.log(length / other * unit / per)) < CLOCKS_APART
            for unit, per in product(SECONDS_PER.values(), repeat=2))), length)
        clocks.setdefault(alike, [begin]).extend(range(begin + 1, end))
    tables = [*clocks.values()]
    able = len(tables) > 1 and all(any(
        _seconds(whole[-1][i]) is not None for i in columns if i not in times)
        for columns in tables)  # without a number it is a second clock, and no second sensor
    return tables if able and max(map(len, tables)) > FEWEST_NUMBERS else []


def _seconds(cell: str) -> float | None:
    return float(cell) if is_number(cell) else seconds_of(cell)


def _repeated(names: Sequence[str]) -> list[list[int]]:
    """The columns of each block of a header that repeats its names; empty if it does not.

    Two blocks are two recordings if each has its times and the axes of an accelerometer.
    """
    for width in range(FEWEST_NUMBERS, len(names) // 2 + 1):
        blocks = [(*names[i : i + width], "")[:width] for i in range(0, len(names), width)]
        able = len(blocks) >= FEWEST_BLOCKS or {"time", "acc"} <= {
            read_name(name).quantity for name in blocks[0]}
        if able and len({*blocks}) == 1 and len({*filter(None, blocks[0])}) >= FEWEST_NUMBERS:
            return [[*range(i, min(i + width, len(names)))] for i in range(0, len(names), width)]
    return []


def _joined(cells: Sequence[str], sign: str) -> str:
    """A row of a block, empty if the block has ended."""
    return sign.join(f'"{cell}"' if sign in cell else cell for cell in cells) if any(cells) else ""


def with_names_in_header(lines: list[str]) -> list[str]:
    """``lines`` with a row for each time in place of rows with one value and its name, as databases
    export them; unchanged if they are others."""
    last = next((line for line in reversed(lines) if line.strip()
                 and not line.startswith(COMMENT_SIGNS)), "")
    if delimiter_of(last) is None or not any(map(str.isalpha, last)):
        return lines  # each row has a name
    at = [i for i, line in enumerate(lines) if line.strip() and not line.startswith(COMMENT_SIGNS)]
    dialect = dialect_of(lines[at[-1]])
    drawn = sorted(Random(0).sample(at, min(SHOWN, len(at))))  # names recur at even distances
    shown = [dialect.cells(lines[i]) for i in drawn]
    width = Counter(map(len, shown)).most_common(1)[0][0]
    shown = [row for row in shown if len(row) == width]
    place = next(filter(None, (_column_of_names(shown, j) for j in range(width))), None)
    if place is None or (of_value := _columns_of_value(dialect, shown, *place)) is None:
        return lines
    (column, kinds), (time, value) = place, of_value
    series: dict[str, dict[str, tuple[int, str]]] = {kind: {} for kind in kinds}
    for i in at:
        row = dialect.cells(lines[i])
        if len(row) == width and row[column] in series:
            series[row[column]][row[time]] = i, row[value]
    first, *others = series.values()
    whole = [when for when in first if all(when in other for other in others)]
    if len(whole) < LEAST_WHOLE * max(map(len, series.values())):
        return lines
    sign, rows = dialect.delimiter or ",", [""] * len(lines)
    for when in whole:
        samples = [one[when] for one in series.values()]
        rows[min(i for i, _ in samples)] = sign.join([when, *(value for _, value in samples)])
    begin = next(i for i, row in enumerate(rows) if row)
    rows[begin - 1] = sign.join(["time", *kinds])
    return rows


def with_whole_stamps(lines: list[str]) -> list[str]:
    """``lines`` with the seconds of each time stamp and their parts in one number, where its header
    names a column for each: parts alone do not show a pause of seconds. Where the parts have lost
    their zeros (``12.5`` for 5 ms), as the steps back show, they have them again."""
    head = find_head(lines)
    if head.first is None:
        return lines
    sign, rows = delimiter_of(lines[head.first]), [*lines]
    whole, part, digits = _without_zeros(lines[head.first :][:SHOWN]) or _seconds_and_parts(
        head.names or ()) or (0, 0, 0)
    for at, line in enumerate(lines[head.first :] if digits else (), head.first):
        cells = split_cells(line, sign)
        if len(cells) <= max(whole, part):
            continue
        if whole == part:
            cells[whole] = _padded(cells[whole], digits)
        elif len(cells[part]) <= digits and (cells[whole] + cells[part]).isdigit():
            cells[whole] += f".{cells[part]:0>{digits}}"
        rows[at] = _joined(cells, sign or " ")
    return rows


def _seconds_and_parts(names: Sequence[str]) -> tuple[int, int, int] | None:
    """The columns of whole seconds and of their parts beside them, and the digits of these."""
    ends = [(i, match, match.string[: match.start()]) for i, name in enumerate(names)
            if (match := STAMP.search(name))]
    return next(((i, j, DIGITS[part[1].lower()]) for (i, whole, one), (j, part, other)
                 in pairwise(ends) if not whole[1] and part[1] and one == other), None)


def _without_zeros(lines: Sequence[str]) -> tuple[int, int, int] | None:
    """The column of times whose parts of a second are printed without leading zeros, twice, and the
    digits of these: only with them do the times not step back. None if there is none."""
    rows = [split_cells(line, delimiter_of(line)) for line in lines]
    for column in range(min(map(len, rows)) if len(rows) >= FEWEST_COUNTED else 0):
        cells = [row[column] for row in rows]
        parts = [match[2] for cell in cells if (match := PARTS.fullmatch(cell))]
        if len(parts) < len(cells) or len({*map(len, parts)}) == 1:
            continue
        digits = next(able for able in DIGITS.values() if able >= max(map(len, parts)))
        steps = ([other - one for one, other in pairwise(times) if one is not None
                  and other is not None] for times in (
            map(_seconds, cells), (_seconds(_padded(cell, digits)) for cell in cells)))
        if min(next(steps), default=0.0) < 0 <= min(next(steps), default=-1.0):
            return column, column, digits
    return None


def _padded(cell: str, digits: int) -> str:
    match = PARTS.fullmatch(cell)
    return f"{match[1]}.{match[2]:0>{digits}}" if match else cell


def _column_of_names(rows: Sequence[Sequence[str]], column: int) -> tuple[int, list[str]] | None:
    """A column and the names of values in it; None if it holds no axes of an inertial sensor."""
    counts = Counter(row[column] for row in rows)
    kinds = [kind for kind, count in counts.items() if count > 1 and not is_number(kind)]
    able = len(kinds) <= MOST_KINDS and len(axes_among(kinds)) >= FEWEST_NUMBERS
    return (column, kinds) if able else None


def _columns_of_value(
    dialect: Dialect, rows: Sequence[Sequence[str]], column: int, kinds: Sequence[str]
) -> tuple[int, int] | None:
    """The columns of the time, which increases for one name, and of the value; None without one."""
    of_one = [row for row in rows if row[column] == kinds[0]]
    moving = [[*cells] for cells in zip(*of_one, strict=True)]
    able = [j for j, cells in enumerate(moving) if len({*cells}) > 1]
    values = [j for j in able if dialect.hold_numbers(moving[j])]
    times = [j for j in able if all(map(is_time, map(dialect.decimal_points, moving[j])))
             and (j not in values or sorted(moving[j], key=lambda cell: float(
                 dialect.decimal_points(cell))) == moving[j])]
    values = [j for j in values if j not in times[:1]]
    return (times[0], values[0]) if times and values else None
