"""The head and the foot of a text log: the first and last row, and the names above them."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.logs.clock import EPOCH_S, FASTEST_HZ, SLOWEST_HZ
from pipeline.logs.columns import ColumnNames, Renamed, missing_columns, our_name
from pipeline.logs.dialect import (
    Dialect,
    delimiter_of,
    dialect_of,
    is_number,
    local_date_seconds,
    seconds_of,
    split_cells,
)
from pipeline.logs.header import MISSING_TRIAD, our_names, wrong_header
from pipeline.logs.header_lines import best_names, wide_names, with_units

COMMENT_SIGNS = ("#", "//", "%")
#: Sample rate in a logger's header lines: "Fs,100", "sample_rate: 100 Hz", "Update Rate: 100.0Hz",
#: "at 100 Hz".
STATED_RATE = re.compile(
    r"(?:\bfs\b|\bodr\b|(?:sample|sampling|update|output|measurement)[ _]?(?:rate|frequency|freq))"
    r"(?:[ _]?\(?hz\)?)?\s*[,:=\s]\s*(\d+\.?\d*)|\bat (\d+\.?\d*) ?hz\b", re.IGNORECASE)
STATED_PERIOD = re.compile(
    r"\b(?:period|interval|delta[ _]?t|dt)\b\s*[,:=\s]\s*(\d+\.?\d*)\s*(ms|us|s)\b"
    r"|\bwf_increment\s*[,:=\s]\s*(\d+\.?\d*)", re.IGNORECASE)
#: Largest number of lines of a head; settings above the header ("Fs,100") take a few lines.
LONGEST_HEAD = 200
FEWEST_COUNTED = 10  #: number of first rows whose numbers show that a column counts them; chosen
LONGEST_FOOTER = 100  #: largest number of lines of text and sums below the rows
FEWEST_NUMBERS = 3  #: least number of numbers in a row: a triad
#: Comment signs that count as a name before the others; C is Fortran's.
OF_COMMENTS = ("", "#", "//", "%", "C", "c", "!", "*")
REMARKS = ("comment", "comments", "remark", "notes")
"""Names of a last column of LabVIEW, which rows omit if it is empty."""
Shape = tuple[int, bool | None]

@dataclass(frozen=True)
class Head:
    """The lines above the rows of a text table.

    Parameters
    ----------
    first : int or None
        Index of the first row; None if no line is a row.
    names : list of str or None
        The cells of the header, None if there is no header.
    names_line : int
        Index of the header's line, or of the first row.
    rate_hz : float or None
        The sample rate, if the head states one.
    """

    first: int | None
    names: list[str] | None
    names_line: int
    rate_hz: float | None


def find_head(lines: Sequence[str], columns: ColumnNames | None = None) -> Head:
    """Find the first row of numbers and the header above it.

    A line with our names of a log's columns is the header wherever it is; without such a line the
    header is the last line above the rows with as many cells as they have. A line of units between
    the two is skipped.
    """
    header: tuple[int, list[str]] | None = None
    above: list[tuple[int, list[str]]] = []  # lines of words, the last one last
    usual: Shape | None = None
    begin, rate_hz = _start_and_rate(lines)
    second_half = (*lines[len(lines) // 2 : len(lines) // 2 + LONGEST_HEAD],)
    for i, line in enumerate(lines[begin:LONGEST_HEAD], begin):
        text = _stripped(line)
        comment = text.startswith(COMMENT_SIGNS)
        if comment:
            text = text.lstrip("#/% ")
        cells = split_cells(text, delimiter_of(text))
        if not cells:
            continue
        if _is_header(cells, columns):
            header = (i, cells)
        elif not comment and (header or _is_row(text, columns)):
            dialect = dialect_of(text)
            row = dialect.cells(text)
            if header and width_of_numbers(text) == 0:
                above.append((i, cells))  # a line of units, or the title of the rows
                continue
            usual, shape = usual or _usual_shape(second_half), _shape(dialect, row)
            if usual not in (None, shape) and (header is None or shape[1] is False):
                continue  # a setting, or the end of a truncated line
            if dialect.delimiter:  # words separated by blanks are not the header of such rows
                above = [line for line in above if delimiter_of(lines[line[0]])]
            above = [(at, names) for at, names in above if len(names) != len(row) - 1
                     or delimiter_of(lines[at].lstrip("#/% ")) == dialect.delimiter]
            above = [(at, wide_names(lines[at], names, len(row))) for at, names in above]
            if header and columns is not None:  # the names without units are asked for
                above = []
            return _head(i, header, above, len(row), rate_hz or _stated_rate(lines[:i]))
        else:
            above.append((i, cells))
    at, names = header or (above[-1] if above else (0, None))
    return Head(None, names, at, rate_hz)


def _stripped(line: str) -> str:
    """A line without blanks around it; a leading tab ends an empty cell, as pandas writes it."""
    return line.rstrip().lstrip(" ")


def _start_and_rate(lines: Sequence[str]) -> tuple[int, float | None]:
    """Number of lines with the start and the rate in every column, and that rate in Hz.

    Empatica writes these lines above its readings; other logs have none.
    """
    rows = [split_cells(line, ",") for line in lines[1:3]]
    if len(rows) < 2 or any(len(cells) < FEWEST_NUMBERS or len({*cells}) > 1
                            or not is_number(cells[0]) for cells in rows):
        return 0, None
    start, rate_hz = (float(cells[0]) for cells in rows)
    is_so = EPOCH_S[0] < start < EPOCH_S[1] and SLOWEST_HZ < rate_hz < FASTEST_HZ
    return (1 + len(rows), rate_hz) if is_so else (0, None)


def _stated_rate(above: Sequence[str]) -> float | None:
    """The sample rate that the lines above the rows state, Hz."""
    text = "\n".join(above)
    if rate := STATED_RATE.search(text):
        return float(rate[1] or rate[2]) or None
    period = STATED_PERIOD.search(text)
    step = float(period[1] or period[3]) if period else 0.0
    return 1 / (step * our_name(f"time_{period[2] or 's'}")[1]) if period and step else None


@lru_cache(maxsize=2)  # several stages of one reading find the head of the same lines
def _usual_shape(lines: tuple[str, ...]) -> Shape | None:
    """The most frequent shape of the rows among ``lines``; None without rows."""
    shapes: Counter[Shape] = Counter()
    for line in map(_stripped, lines):
        dialect = dialect_of(line)
        cells = dialect.cells(line)
        if sum(map(dialect.holds_number, cells)) >= FEWEST_NUMBERS:
            shapes[shape := _shape(dialect, cells)] += 1
            if 2 * shapes[shape] > len(lines):
                return shape
    return shapes.most_common(1)[0][0] if shapes else None


def _shape(dialect: Dialect, cells: Sequence[str]) -> Shape:
    """Number of cells of a row, and whether the first is a number or a time; None if empty."""
    return len(cells), is_time(dialect.decimal_points(cells[0])) if cells and cells[0] else None


def _head(
    first: int,
    header: tuple[int, list[str]] | None,
    above: list[tuple[int, list[str]]],
    width: int,
    rate_hz: float | None,
) -> Head:
    fitting = [(at, names) for at, names in above
               if len(without_sign(names, width) or ()) in (width, width - 1)]
    if header is not None:
        header = with_units(*header, [names for at, names in fitting if at > header[0]])
    elif fitting:
        header = best_names(fitting)
    if header is None:
        return Head(first, None, first, rate_hz)
    return Head(first, header[1], header[0], rate_hz)


def width_of_numbers(line: str) -> int:
    """Number of cells of a line that are numbers."""
    dialect = dialect_of(line)
    return sum(map(dialect.holds_number, dialect.cells(line)))


def _is_header(cells: list[str], columns: ColumnNames | None) -> bool:
    if isinstance(columns, Renamed):
        return columns.apply(cells) is not None
    return columns is None and missing_columns([name for name, _ in our_names(cells)]) is None


def _is_row(line: str, columns: ColumnNames | None) -> bool:
    numbers = width_of_numbers(line)
    if isinstance(columns, Sequence) and len(dialect_of(line).cells(line)) == len(columns):
        return numbers > 0
    return numbers >= FEWEST_NUMBERS


def is_time(cell: str) -> bool:
    """Whether a cell is a number, a date with a time, or a time of the day."""
    return is_number(cell) or seconds_of(cell) is not None or local_date_seconds(cell) is not None


def without_footer(lines: list[str], dialect: Dialect, width: int) -> list[str]:
    """``lines`` without the footer of a report: a title, then words and numbers."""
    end = len(lines)
    for i in range(len(lines) - 1, max(len(lines) - LONGEST_FOOTER, 0) - 1, -1):
        cells = dialect.cells(lines[i])
        if cells and is_time(dialect.decimal_points(cells[0])):
            return lines[:end] if len(cells) == width else lines
        if cells and not any(map(dialect.holds_number, cells)):
            end = i
    return lines


def without_sign(
    names: Sequence[str] | None, cells: int, shifted: bool = False
) -> Sequence[str] | None:
    """The names for ``cells`` cells, without a leading comment sign or a last column of remarks.

    ``shifted``: if one name is missing, it is that of the first column, as R writes row names.
    """
    if names is not None and shifted and len(names) == cells - 1:
        return ["", *names]
    if names is None or len(names) != cells + 1:
        return names
    return (names[1:] if names[0] in OF_COMMENTS else
            names[:-1] if names[-1].lower() in REMARKS else names)


def are_numbered(dialect: Dialect, lines: Sequence[str], first: int) -> bool:
    """Whether rows begin with their numbers or quoted names, as pandas and R print them."""
    rows = [cells for line in lines[first : first + FEWEST_COUNTED]
            if (cells := dialect.cells(line))]
    if not rows or not all(cells[-1] for cells in rows):
        return False
    names = [cells[0] for cells in rows]
    numbers = [str(int(names[0]) + i) for i in range(FEWEST_COUNTED)] if (
        names[0].isascii() and names[0].isdecimal()) else []
    return names[0][:1] == '"' or names == numbers


def require_one_header(path: Path, lines: Sequence[str], head: Head, dialect: Dialect) -> None:
    """Refuse rows below a second header with the same names in another order.

    Raises
    ------
    UnreadableInput
    """
    if head.names is None or head.first is None:
        return
    for i, line in enumerate(lines[head.first :], head.first):
        if not line[:1].isalpha():
            continue
        names = dialect.cells(line)
        if names != head.names and sorted(names) == sorted(head.names):
            raise UnreadableInput(
                f"{path}:{i}: from here on the columns are {', '.join(names)}, and above they "
                f"are {', '.join(head.names)}. Cut the file in two there.")


def moving_columns(
    dialect: Dialect, cells: Sequence[str], rows: Sequence[str]
) -> Sequence[int]:
    """Columns whose cell in the last row differs from ``cells``: a constant start is no clock."""
    last = next((other for row in reversed(rows)
                 if len(other := dialect.cells(row)) == len(cells)), cells)
    return [i for i, cell in enumerate(cells) if cell != last[i]] or range(len(cells))


def date_column(dialect: Dialect, cells: Sequence[str], places: Iterable[int]) -> int | None:
    """The first of the columns ``places`` whose cell is a date or a time of the day."""
    return next((i for i in places
                 if not dialect.holds_number(cells[i]) and is_time(cells[i])), None)


def no_rows(path: Path, head: Head) -> UnreadableInput:
    """The error for a file without rows."""
    if head.names and missing_columns([name for name, _ in our_names(head.names)]) is None:
        return UnreadableInput(f"{path}: no row of numbers below the header. Record the pose "
                               "again.")
    if head.names is None:
        return UnreadableInput(f"{path}: no row of numbers. {MISSING_TRIAD}.")
    return wrong_header(f"{path}:{head.names_line}", head.names)
