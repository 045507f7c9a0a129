"""Rows from sentences: lines with the same words and signs and different numbers.

Examples are ``I (1312) IMU: acc=0.01,-0.02,0.98 gyr=1.2,0.3,-0.5``, cells with vectors
(``0.02,"[0.1, 0.2, 9.8]"``) and numbers with units (``0.02s, 0.98g``). The names are in the text
between the numbers, or in a header with as many cells as the line.
"""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import groupby, pairwise

from calib.poses.imu_log import AXES
from pipeline.logs.columns import TIME
from pipeline.logs.dialect import (
    DELIMITERS,
    delimiter_of,
    dialect_of,
    local_date_seconds,
    seconds_of,
)
from pipeline.logs.header_words import spelled_unit

LEAST_SHARE = 0.9  #: least share of the lines with one format
FEWEST = 3  #: least number of numbers in a row: a triad
#: Repetitions are possessive (``++``), or the search of a long line would take minutes.
NUMBER = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d++)?"
DAY = r"(?:\d{4}-\d{2}-\d{2}[ T])?\d{1,2}:\d{2}:\d{2}(?:\.\d++|,\d{3}(?![\d.,]))?"
SLOT = re.compile(rf"(?<![\w.^])(?<!\d:)(?:{DAY}(?![\w:])|{NUMBER})")
COLOURS = re.compile(r"\x1b\[[0-9;]*m")  #: colour codes of a terminal
PADDING = re.compile(r"(?<=[\[({]) | (?=[\])}])")  #: padding blanks inside brackets
IN_BRACKETS = re.compile(r"[\[({][^\])}]*+[\])}]")
AROUND = " \t:=<>()[]{}/\"',;|"
BEHIND = {"[": "]", "(": ")"}
LIST = re.compile(r"-?[\d.]+(?:[|]-?[\d.]+){4,}")  #: samples of one channel in one cell
COMMA = re.compile(r"(\d),(\d)")  #: a decimal comma
NO_COMMA = re.compile(r"\d\.\d|\d,-?\d+,")  #: a decimal point, or commas between numbers
MARK = "\0"  #: placeholder of a number
VECTOR = re.compile(rf"[\[({{]{MARK}(?:[ ,;]+{MARK})+[\])}}]")  #: several numbers in brackets


def rows_of_sentences(lines: list[str], shown: Sequence[str]) -> list[str] | None:
    """``lines`` as rows under a header, one row per line; None if they are not sentences.

    ``shown`` are the lines that determine the format. Lines of other formats become comments.
    """
    if shown and delimiter_of(shown[-1]) in (";", "\t") and not any(map(NO_COMMA.search, shown)):
        lines, shown = ([COMMA.sub(r"\1.\2", line) for line in each] for each in (lines, shown))
    texts = Counter(_text(line) for line in shown)
    text, count = max(texts.items(), key=lambda item: item[1], default=("", 0))
    if text.count(MARK) < FEWEST or count < LEAST_SHARE * len(shown):
        return None
    if not _hides_numbers(next(line for line in shown if _text(line) == text)):
        return None
    rows = [",".join(slot.replace(",", ".") for slot in SLOT.findall(COLOURS.sub("", line)))
            if _text(line) == text else f"# {line}" for line in lines]
    first = next(i for i, row in enumerate(rows) if not row.startswith("# "))
    clock = TIME if ":" in rows[first].split(",")[0] else "t" if _grows(shown) else ""
    above = next((line for line in reversed(lines[:first]) if line.strip()), "")
    names = _names_of_header(text, above) or _names_of_text(text, clock)
    if not all(map(str.isdecimal, names)):  # positions alone would be a row of numbers
        rows[max(first - 1, 0)] = ",".join(names)
    return rows


def _text(line: str) -> str:
    """The line with marks in place of its numbers, and single blanks."""
    return PADDING.sub("", " ".join(SLOT.sub(MARK, COLOURS.sub("", line)).split()))


def _grows(lines: Sequence[str]) -> bool:
    """Whether the first number increases from line to line, as a clock does."""
    firsts = [float(match[0].replace(",", ".")) for line in lines
              if (match := SLOT.search(COLOURS.sub("", line))) and ":" not in match[0]]
    return len(firsts) > FEWEST and all(one < other for one, other in pairwise(firsts))


def _hides_numbers(line: str) -> bool:
    """Whether the line is not a plain table: numbers have units or are in vectors."""
    plain = COLOURS.sub("", line)
    dialect = dialect_of(plain)
    hidden = [cell for cell in dialect.cells(plain)
              if not dialect.holds_number(cell) and seconds_of(cell) is None
              and local_date_seconds(cell) is None]
    if LIST.search(line):
        return False
    if VECTOR.search(_text(line)):
        return True
    with_units = any(spelled_unit(cell[slot.end() :]) for cell in hidden
                     if (slot := SLOT.match(cell)))
    return with_units or sum(len(SLOT.findall(cell)) for cell in hidden) >= FEWEST


def _names_of_header(text: str, above: str) -> list[str]:
    """Names from the cells of the line above, with the units that follow the numbers."""
    sign = max(DELIMITERS, key=text.count)
    whole = IN_BRACKETS.sub(lambda vector: vector[0].replace(sign, " "), text)
    cells, names = whole.split(sign), [name.strip(' "') for name in above.split(sign)]
    if len(cells) != len(names) or len(cells) < 2 or SLOT.search(above):
        return []
    named = []
    for cell, name in zip(cells, names, strict=True):
        count = cell.count(MARK)
        unit = cell.rpartition(MARK)[2].strip(AROUND) if count else ""
        title = f"{name} ({unit})" if spelled_unit(unit) else name
        named += ([title] if count == 1 else [title, f"{title} sd"] if count == 2 and "±" in cell
                  else _spread(name, count))
    return named


def _names_of_text(text: str, first: str) -> list[str]:
    """Names from the words before the numbers; a number without words continues the last name.

    ``first`` is the name of the first number if it has no words.
    """
    labels: list[str] = []
    units: dict[int, str] = {}
    for part in text.split(MARK)[:-1]:
        words = re.split(r"[,;|]", part)[-1].replace(":", " ").strip(AROUND)
        words += "".join(BEHIND[sign] for sign in BEHIND if words.count(sign) > words.count(
            BEHIND[sign]))
        behind, _, others = " ".join(words.split()).partition(" ")
        if labels and spelled_unit(behind.strip(AROUND)):
            units[len(labels) - 1] = behind.strip(AROUND)
            words = others
        if words.lower() in AXES and labels and labels[-1][-1:].lower() in AXES:
            words = f"{labels[-1][:-1]}{words}"
        labels.append(words if any(map(str.isalpha, words)) else "")
    labels[0] = labels[0] or first
    if labels[0] == TIME:
        units.pop(0, None)  # "14:05:00.020 Raw data" is no unit
    groups: list[list[str]] = []
    for is_named, run in groupby(labels, key=bool):
        several = list(run)
        if is_named or not groups:
            groups += [[label] for label in several]
        else:
            groups[-1] += several
    named: list[str] = []
    for group in groups:
        unit = units.get(len(named) + len(group) - 1)
        names = group if len(group) == 1 else _spread(group[0], len(group))
        named += [f"{name} ({unit})" if unit and name else name for name in names]
    return named


def _spread(name: str, count: int) -> list[str]:
    """Names of several numbers with one name: with the axes for a triad, else their positions."""
    if count == len(AXES):
        return [f"{name} {axis}" for axis in AXES]
    return [str(place) for place in range(1, count + 1)]
