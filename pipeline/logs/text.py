"""A log as lines of text, with its columns and rows of numbers."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.poses.imu_log import BoolArray, FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, READINGS, SKIP, TIME, ColumnNames, bare
from pipeline.logs.dialect import (
    LOST,
    Dialect,
    dialect_of_rows,
    is_number,
    local_date_seconds,
    seconds_of,
)
from pipeline.logs.groups_of_digits import of_commas, of_points
from pipeline.logs.head import (
    Head,
    are_numbered,
    date_column,
    find_head,
    is_time,
    moving_columns,
    no_rows,
    require_one_header,
    without_footer,
    without_sign,
)
from pipeline.logs.header import named_columns

DIALECT_ROWS = 1000  #: number of rows that show a decimal comma
MOST_LACKING = 0.1
"""Largest share of rows without a time or a reading, of lines that are not samples, and of words in
a column of numbers. A judgement: a card or radio that loses more is broken, and half of the
characters of a hexadecimal checksum are letters."""
IN_TRIADS = (*ACCELEROMETER, *GYROSCOPE)
#: Words for a missing value, in lower case.
MISSING = frozenset(("", "nan", "null", "none", "na", "n/a", "-", "--"))


@dataclass(frozen=True)
class LogText:
    """A log as lines of text.

    Parameters
    ----------
    path : Path
        The file's name in messages.
    lines : list of str
        The lines of the file by their numbers, without line ends; line 0 is empty, or names the
        numbers of a text whose first line is a row.
    first : int
        Index of the first line that may hold a row.
    names : tuple of str
        Our name of every column, ``skip`` for those that are not read.
    factors : tuple of float
        Factor of each column to our unit.
    dialect : Dialect
        Delimiter of the columns and decimal sign.
    rate_hz : float or None
        The sample rate, if the head states one.
    dated : int or None
        The column that holds dates or times of the day, which are read as seconds.
    """

    path: Path
    lines: list[str]
    first: int
    names: tuple[str, ...]
    factors: tuple[float, ...]
    dialect: Dialect
    rate_hz: float | None
    dated: int | None = None

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line number in the file, from 1, and cells of every row; slow, for messages."""
        for number, line in enumerate(self.lines[self.first :], self.first):
            cells = self.dialect.cells(line)
            if cells and self.is_sample(cells):
                yield number, cells

    def is_sample(self, cells: Sequence[str]) -> bool:
        """Whether a line is a row: it holds a number, and a reading if these columns are known.

        This excludes words of a sketch between the rows, and merged rows of a slower sensor.
        """
        if not any(self.dialect.holds_number(cell) for cell in cells):
            return False
        if len(cells) != len(self.names):
            return True
        readings = [cell for name, cell in zip(self.names, cells, strict=True) if name in IN_TRIADS]
        return not readings or any(cell.lower() not in MISSING for cell in readings)

    @property
    def is_rewritten(self) -> bool:
        """Whether rows are rewritten with tabs for NumPy: dates, or commas with both meanings."""
        return self.dated is not None or (
            self.dialect.decimal_comma and self.dialect.delimiter == ",")

    def place(self, row: int) -> str:
        """File and line, from 1, of a row of the table."""
        return f"{self.path}:{next(line for i, (line, _) in enumerate(self.rows()) if i == row)}"


def log_text(path: Path, lines: list[str], columns: ColumnNames | None) -> LogText:
    """The log in ``lines``; columns that hold text in its first row are skipped.

    Raises
    ------
    UnreadableInput
        No header names a triad, or there is neither a header nor ``columns``.
    """
    head = find_head(lines, columns)
    if head.first is None:
        raise no_rows(path, head)
    dialect, cells, lines, header = _frame(path, lines, head)
    names = named_columns(f"{path}:{head.names_line}", header, len(cells), columns,
                          ends_open=cells[-1] == "")
    read = [(name, factor) if name in READINGS or dialect.holds_number(cell) else (SKIP, 1.0)
            for (name, factor), cell in zip(names, cells, strict=True)]
    dated = date_column(dialect, cells, [i for i, (name, _) in enumerate(read) if name == TIME])
    return LogText(path, lines, head.first, tuple(name for name, _ in read),
                   tuple(factor for _, factor in read), dialect, head.rate_hz, dated)


def raw_text(path: Path, lines: list[str]) -> LogText | None:
    """The table in ``lines`` under the names of the file, or ``1``, ``2``, ... without a header.

    None if no line is a row. Columns of text are skipped, except one of dates. Points between
    thousands raise UnreadableInput.
    """
    head = find_head(lines)
    if head.first is None:
        return None
    dialect, cells, lines, header = _frame(path, lines, head)
    names = [bare(name) for name in header or ()]
    if not any(names) or max(Counter(filter(None, names)).values()) > 1:  # repeated: no names
        names = [str(i) for i in range(1, len(cells) + 1)]
    names += [""] * (len(cells) - len(names))
    rows = lines[head.first : head.first + DIALECT_ROWS]
    dated = date_column(dialect, cells, moving_columns(dialect, cells, rows))
    read = [name if name not in ("", *names[:i]) and (i == dated or dialect.holds_number(cell))
            else SKIP for i, (name, cell) in enumerate(zip(names, cells, strict=False))]
    return LogText(path, lines, head.first, tuple(read), (1.0,) * len(read), dialect,
                   head.rate_hz, dated)


def _frame(
    path: Path, lines: list[str], head: Head
) -> tuple[Dialect, list[str], list[str], Sequence[str] | None]:
    """The dialect of the rows below ``head``; a representative cell of each column: the first that
    is not empty, or one of text if the column has more than a few; the lines without a footer; and
    the names of the columns.

    Points between thousands, and a second header of other columns, are refused.
    """
    first = head.first or 0
    rows = lines[first : first + DIALECT_ROWS]
    dialect = dialect_of_rows(rows)
    require_one_header(path, lines, head, dialect)
    cells = dialect.cells(rows[0])
    alike = [other for row in rows if len(other := dialect.cells(row)) == len(cells)]
    if not dialect.decimal_comma and (fault := of_points(alike)):
        raise UnreadableInput(f"{path}: {fault}")
    for i, column in enumerate(zip(*alike, strict=True)):
        there = (cell for cell in column if cell.lower() not in MISSING)
        if not dialect.hold_numbers(column):
            known = [(cell, dialect.holds_number(cell)) for cell in there]
            of_text = sum(not number for _, number in known) > MOST_LACKING * len(known)
            there = (cell for cell, number in known if number != of_text)
        cells[i] = next(there, cells[i])
    lines = without_footer(lines, dialect, len(cells))
    return dialect, cells, lines, without_sign(
        head.names, len(cells), are_numbered(dialect, lines, first))


def columns_of_text(text: LogText) -> tuple[int, dict[str, FloatArray]]:
    """The number of rows that are no samples, and the columns that are read, each of shape (t,).

    Raises
    ------
    UnreadableInput
    """
    table = numbers_of(text)
    whole = ~np.isnan(table).all(axis=1)
    lost = int((~whole).sum()) + sum(line.startswith(LOST) for line in text.lines)
    table = table[whole]
    return lost, {name: column for name, column in zip(text.names, table.T, strict=True)
            if name != SKIP}


def numbers_of(text: LogText) -> FloatArray:
    """The rows as an array (t, columns), each in its unit; skipped columns are NaN.

    A row that is not a sample is all NaN: an event, a marker, a truncated last line.

    Raises
    ------
    UnreadableInput
        More than a tenth of the rows have another number of cells, or a cell that is not a number;
        the message has the first such line.
    """
    wanted = [i for i, name in enumerate(text.names) if name != SKIP]
    all_wanted = len(wanted) == len(text.names)
    rows = _plain_rows(text)
    try:
        # With usecols NumPy accepts ragged rows, so these are counted here.
        if not all_wanted and any(len(cells) != len(text.names) for _, cells in text.rows()):
            raise ValueError("ragged rows")
        table = np.loadtxt(rows, delimiter="\t" if text.is_rewritten else text.dialect.delimiter,
                           ndmin=2, usecols=None if all_wanted else wanted,
                           quotechar='"' if '"' in rows[0] else None)
        full = np.full((len(table), len(text.names)), np.nan)
        full[:, wanted] = table
        lost = np.zeros(len(full), bool)
    except ValueError:
        full, lost = _row_by_row(text)
    readings = [i for i in wanted if text.names[i] in IN_TRIADS]
    there = ~np.isnan(full[:, readings]).all(axis=1) if readings else ~lost
    return np.asarray(full[there | lost])


def _row_by_row(text: LogText) -> tuple[FloatArray, BoolArray]:
    """The rows as numbers (t, columns), NaN for skipped or missing cells, and a mask (t,) of rows
    that are not samples."""
    every = list(_timed_rows(text))
    table = np.full((len(every), len(text.names)), math.nan)
    lost = np.zeros(len(every), bool)
    faults = []
    for i, (line, cells) in enumerate(every):
        if fault := _fault(text, cells):
            faults.append(f"{text.path}:{line}: {fault}")
            lost[i] = True
        else:
            table[i] = [math.nan if name == SKIP or cell.lower() in MISSING
                        else float(text.dialect.decimal_points(cell))
                        for name, cell in zip(text.names, cells, strict=True)]
    if lost.mean() > MOST_LACKING:
        share = f" {len(faults)} of its {len(every)} rows are no samples." if faults[1:] else ""
        raise UnreadableInput(f"{faults[0]}{share}")
    return table, lost


def _plain_rows(text: LogText) -> list[str]:
    """The rows with decimal points, and with seconds in place of dates."""
    if text.dialect.decimal_comma and (
            fault := of_commas([cell for _, cells in text.rows() for cell in cells])):
        raise UnreadableInput(f"{text.path}: {fault}")
    if text.is_rewritten:
        return ["\t".join(map(text.dialect.decimal_points, cells))
                for _, cells in _timed_rows(text)]
    return [text.dialect.decimal_points(row) for row in text.lines[text.first :]]


def _timed_rows(text: LogText) -> Iterator[tuple[int, list[str]]]:
    """Rows with dates or times of the day converted to seconds, and their line numbers."""
    first_date: str | None = None
    at = text.dated
    for line, cells in text.rows():
        if at is None or len(cells) != len(text.names):
            yield line, cells
            continue
        seconds = seconds_of(cells[at])
        if seconds is None and (local := local_date_seconds(cells[at])) is not None:
            date, seconds = local
            first_date = first_date or date
            if date != first_date:
                raise UnreadableInput(
                    f"{text.path}:{line}: the date changes from {first_date} to {date}, and which "
                    "number is the day differs from country to country. Write the times as "
                    "2024-12-31 23:59:59.999."
                )
        cells[at] = cells[at] if seconds is None else repr(seconds)
        yield line, cells


def _fault(text: LogText, cells: Sequence[str]) -> str:
    """The fault of a row: too short, too long, or an unreadable cell; empty for a sample."""
    if len(cells) != len(text.names):
        if joined := next((cell for cell in cells if cell.count(".") > 1
                           and not is_time(cell)), None):
            return (f"'{joined}' is two numbers without a blank between them. Write the file anew "
                    f"with a comma between the columns.")
        return (f"{len(cells)} values found, {len(text.names)} expected "
                f"({', '.join(text.names)}). Delete the damaged line, or record the log again.")
    wrong = next(((name, cell) for name, cell in zip(text.names, cells, strict=True)
                  if name != SKIP and cell.lower() not in MISSING
                  and not is_number(text.dialect.decimal_points(cell))), None)
    return "" if wrong is None else (
        f"column {wrong[0]}: found '{wrong[1]}', a number is expected. Delete the damaged line, or "
        f"record the log again.")
