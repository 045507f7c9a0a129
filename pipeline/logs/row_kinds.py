"""Tables of several sensors, boards or messages whose rows take turns in one text.

A cell of each row names its kind: ``ACCE;12.1;0.1;0.2;9.8``, ``$PIMU,...*5A``, the number of a
board. Each kind becomes a table of its own; its rows keep their line numbers in the file.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.logs.dialect import SHOWN, Dialect, dialect_of
from pipeline.logs.head import COMMENT_SIGNS, FEWEST_NUMBERS
from pipeline.logs.header_words import ACC, GYR
from pipeline.logs.sentence_names import MARK
from pipeline.logs.sentences import form_of

MOST_KINDS = 12  #: largest number of sensors: those of a phone
LEAST_TURNS = 0.25
"""Least share of rows whose board differs from that of the row before. A judgement: boards that
send in turn change in half of the rows or more, the state of one board changes rarely."""
FARTHER = 5.0
"""Least ratio of the step between sensors to that within one plus the resolution. A judgement: the
biases of two boards differ by ten times the noise in one of six axes, those of one board by 1."""
UNEVEN = 1.2
"""Least ratio of the numbers of lines of two sensors that do not take turns. A judgement: rates of
one logger differ by a quarter and more or not at all, and lost lines make a few per cent."""
SENTENCE = re.compile(r"\s*+[$%#](\w++,.*)\*[0-9A-Fa-f]{2,8}\s*+")
"""A sentence of NMEA 0183, or a message of NovAtel."""
SENSOR = re.compile("acc|gyr", re.IGNORECASE)
NAMED = re.compile(r"^[A-Za-z]\w*+ ?+[:=] ?+|[\])}]$")  #: what is no number in ``GyrX : -0.022}``
KIND = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  #: a first cell that names the kind of a row


def lines_by_kind(lines: list[str]) -> Mapping[str, list[str]]:
    """The lines of each kind, others empty; all lines under an empty name if there is one kind.

    A kind may have kinds of its own, as the messages of two sensors.
    """
    return {"/".join(filter(None, (kind, part))): those
            for kind, table in _first_kinds(lines).items()
            for part, those in (_first_kinds(table) if kind else {"": table}).items()}


def _first_kinds(lines: list[str]) -> Mapping[str, list[str]]:
    if sum(SENTENCE.fullmatch(line) is not None for line in lines[-SHOWN:]) > SHOWN / 4:
        lines = [match[1].replace(";", ",") if (match := SENTENCE.fullmatch(line)) else f"# {line}"
                 for line in lines]
    shown = [line for line in lines[-SHOWN:]
             if line.strip() and not line.startswith(COMMENT_SIGNS)]
    if not shown:
        return {"": lines}
    dialect = dialect_of(shown[-1])
    rows = [dialect.cells(line) for line in shown]
    at = _column_of_kinds(rows, dialect)
    if at is None:
        return _kinds_by_words(lines, shown) or {"": lines}
    widths: dict[str, Counter[int]] = {}
    for row in rows:
        if len(_numbers(row, dialect)) >= FEWEST_NUMBERS:
            widths.setdefault(row[at], Counter())[len(row)] += 1
    kinds = {kind: width.most_common(1)[0][0] for kind, width in widths.items()}
    return {kind: _of_kind(lines, dialect, at, kind, width, [*kinds])
            for kind, width in sorted(kinds.items())} or {"": lines}


def _kinds_by_words(lines: Sequence[str], shown: Sequence[str]) -> Mapping[str, list[str]]:
    """The lines of each sensor that a word in them names, if one sends more often than another or
    than lines of something else."""
    if not SENSOR.search("\n".join(shown)):
        return {}
    counts = Counter(form for form in map(form_of, shown) if form.count(MARK) >= FEWEST_NUMBERS)
    forms = {form: count for form, count in counts.items() if count >= FEWEST_NUMBERS}
    words = {form: re.findall(r"[a-z]{3,}", form.lower()) for form in forms}
    sensors = [form for form in forms if SENSOR.search(form)]
    names = [next((word for word in words[form] if word in ACC | GYR), next(iter(words[form])))
             for form in sensors]
    uneven = forms and max(forms.values()) > UNEVEN * min(forms.values())
    if not uneven or not sensors or len({*names}) < len(sensors):
        return {}
    return {name: [line if form_of(line) == form else "" for line in lines]
            for name, form in zip(names, sensors, strict=True)}


def _of_kind(
    lines: Sequence[str], dialect: Dialect, at: int, kind: str, width: int, kinds: Sequence[str]
) -> list[str]:
    """The lines without the rows and the headers of other kinds."""
    kept = []
    for line in lines:
        bare = line.lstrip("#/%; ") if line.startswith((*COMMENT_SIGNS, ";")) else line
        cells = dialect.cells(bare)
        is_row = len(cells) == width and cells[at] == kind and (
            len(_numbers(cells, dialect)) >= FEWEST_NUMBERS)
        words = not any(map(dialect.holds_number, cells[-width:]))
        if is_row or (words and cells[:1] == [kind]):
            kept.append(bare)
        elif words and kind in cells[1:] and len(cells) > width:  # "FMT, 163, 58, IMU, ..., TimeUS"
            kept.append((dialect.delimiter or " ").join([cells[0], *cells[1 - width:]]))
        else:
            of_others = {*cells} & {*kinds} or len(cells) > width + 1  # wider rows' names
            kept.append(line if words and not of_others else "")
    return kept


def _column_of_kinds(rows: Sequence[Sequence[str]], dialect: Dialect) -> int | None:
    """The column whose cell names the kind of each row; None if the rows are those of one sensor.

    In a first column kinds of different widths show it. Otherwise the rows take turns and,
    whatever the names, the readings jump between successive rows but not between those of a kind.
    """
    width = min(map(len, rows))
    if not width:
        return None
    kinds = Counter((row[0], len(row)) for row in rows if any(map(dialect.holds_number, row[1:])))
    usual = [kind for kind, count in kinds.items() if count >= FEWEST_NUMBERS]
    if usual and all(KIND.fullmatch(kind) for kind, _ in kinds) and all(
            len({one[i] for one in usual}) > 1 for i in (0, 1)):
        return 0
    columns = [[row[i] for row in rows] for i in range(width)]
    turning = [i for i, column in enumerate(columns) if take_turns(column)]
    if not turning:
        return None
    numbers = {i: values for i, column in enumerate(columns)
               if len(values := _numbers(column, dialect)) == len(column)}
    return next((i for i in turning if _jump_between(
        np.array([cells for j, cells in numbers.items() if j != i]).T, columns[i])), None)


def _numbers(cells: Sequence[str], dialect: Dialect) -> list[float]:
    """The numbers of the cells that hold one, alone or behind its name."""
    bare = (NAMED.sub("", cell.strip()) for cell in cells)
    return [float(dialect.decimal_points(cell)) for cell in bare if dialect.holds_number(cell)]


def take_turns(words: Sequence[str] | Sequence[float]) -> bool:
    """Whether a few words follow each other in turn."""
    kinds = {*words}
    if not 1 < len(kinds) <= min(MOST_KINDS, len(words) / 2) or "" in kinds:
        return False
    turns = sum(one != other for one, other in pairwise(words))
    return turns > LEAST_TURNS * len(words)


def _jump_between(columns: FloatArray, words: Sequence[str]) -> bool:
    """Whether a column of (t, k) has much smaller steps within each of the rows' ``words`` (t,)."""
    if not columns.size:
        return False
    kinds = np.unique(words, return_inverse=True)[1]
    between = np.abs(np.diff(columns, axis=0))[np.diff(kinds) != 0]
    order = np.argsort(kinds, kind="stable")
    within = np.abs(np.diff(columns[order], axis=0))[np.diff(kinds[order]) == 0]
    apart = np.diff(np.sort(columns, axis=0), axis=0)
    finest = np.where(apart > 0, apart, np.inf).min(axis=0)
    return bool((np.median(between, axis=0) > FARTHER * (np.median(within, axis=0) + finest)).any())
