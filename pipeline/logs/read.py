"""Conversion of log files to :class:`calib.poses.imu_log.ImuLog`.

NumPy's C parser reads the rows of a text. Only if it fails or returns impossible values, the file
is read again line by line to locate the fault. Files of other kinds are read by the library of
their format (:mod:`pipeline.logs.formats`).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calib.poses.imu_log import FloatArray, ImuLog, IntArray
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import StatedClock, sample_times, within_the_log
from pipeline.logs.columns import (
    ACCELEROMETER,
    GYROSCOPE,
    READINGS,
    SKIP,
    TIME,
    ColumnNames,
)
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.header import named_columns
from pipeline.logs.join import join_logs
from pipeline.logs.tables import TextTable, tables_in
from pipeline.logs.text import MOST_LACKING, log_text, numbers_of
from pipeline.text.names import word

TABLES = 6  #: tables that a message lists


@dataclass(frozen=True, eq=False)
class LogTable:
    """The numeric columns of one log, by our names.

    Parameters
    ----------
    label : str
        Its name in messages.
    names : sequence of (str, float) pairs
        Our name of each column and the factor to our unit.
    numbers : callable
        The columns, each (t,), in their units; a text is parsed when they are first needed.
    rate_hz : float or None
        The sample rate, if the file states one.
    place : callable
        File and line (or row) of a row, for messages.
    """

    label: str
    names: Sequence[tuple[str, float]]
    numbers: Callable[[], Sequence[FloatArray]]
    rate_hz: float | None
    place: Callable[[int], str]

    @cached_property
    def values(self) -> Mapping[str, FloatArray]:
        """The columns (t,) in our units, except the time, whose unit may be stated otherwise."""
        return {name: column if name == TIME else column * factor for (name, factor), column in zip(
            self.names, self.numbers(), strict=True) if name != SKIP}

    @property
    def time_factor(self) -> float:
        """Seconds per unit of the column of times, by its name in the file."""
        return dict(self.names).get(TIME, 1.0)

    def at(self, rows: IntArray, without: Collection[str] = ()) -> "LogTable":
        """The table of these rows, without some columns."""
        names = [(SKIP if name in without else name, factor) for name, factor in self.names]
        columns = self.numbers()
        return LogTable(self.label, names, lambda: [column[rows] for column in columns],
                        self.rate_hz, lambda row: self.place(int(rows[row])))


def read_log(
    path: Path,
    columns: ColumnNames | None = None,
    clock: StatedClock | None = None,
) -> ImuLog:
    """Read one log file.

    Parameters
    ----------
    path : Path
        Text, compressed with gzip or not; columns separated by commas, semicolons, tabs, bars or
        blanks, with decimal points or commas; lines that begin with ``#``, ``//`` or ``%`` are
        comments.
    columns : sequence of str or Renamed, optional
        Names of all columns in their order, which replace a header (``skip`` marks a column that is
        not read); or the names in the header that correspond to ours.
    clock : StatedClock, optional
        The sample rate of files without ``time_s`` (a ``counter`` column then shows lost samples),
        or the unit of the column of times, if its name does not state it.

    Returns
    -------
    ImuLog
        Every numeric column of the file; an absent triad is NaN.

    Raises
    ------
    UnreadableInput
        The message has file, line, column, the found and the expected content, and advice.
    """
    stated = clock or StatedClock()
    logs = [_imu_log(table, stated, path.name) for table in read_tables(path, columns)]
    return logs[0] if len(logs) == 1 else replace(join_logs(logs), label=path.name)


def column_names(path: Path, columns: ColumnNames | None = None) -> list[str]:
    """The names of a log's columns, ours where known, without parsing the rows of a text.

    Raises
    ------
    UnreadableInput
        As in :func:`read_log`.
    """
    return [name for table in _named_tables(path, columns) for name, _ in table.names
            if name != SKIP]


def read_tables(path: Path, columns: ColumnNames | None = None) -> list[LogTable]:
    """Read the columns of one log file, as several tables if its triads are separate.

    Parameters are those of :func:`read_log`.

    Raises
    ------
    UnreadableInput
        As in :func:`read_log`, or ``path`` names a member of a file that is one table of text.
    """
    return [part for table in _named_tables(path, columns) for part in _by_rate(table)]


def _named_tables(path: Path, columns: ColumnNames | None) -> list[LogTable]:
    """The only table of a file, or those with our names if they hold each triad once."""
    tables = tables_in(path)
    if len(tables) == 1:
        return [_named(path, tables[0], columns)]
    whole: list[LogTable] = []
    for table in tables if columns is None else ():
        with suppress(UnreadableInput):
            whole.append(_named(path, table, None))
    triads = [name for table in whole for name, _ in table.names
              if name in (ACCELEROMETER[0], GYROSCOPE[0])]
    if whole and len(set(triads)) == len(triads):
        return whole
    listed = "; ".join(_listed(table) for table in tables[:TABLES])
    raise UnreadableInput(
        f"{path}: which of its tables holds the readings is not clear: {listed}. Name one as a "
        f"file, as in `{path.name}/{tables[0].name}`, with `columns` for names that are not ours; "
        f"`pipeline import {word(path.name)}` guesses both."
    )


def _listed(table: TextTable | FileTable) -> str:
    names = f" ({', '.join(table.columns)})" if isinstance(table, FileTable) else ""
    return f"{table.name}{names}"


def _named(path: Path, table: TextTable | FileTable, columns: ColumnNames | None) -> LogTable:
    """A table with our names for its columns."""
    if isinstance(table, FileTable):
        theirs = list(table.columns)
        return LogTable(str(path), named_columns(str(path), theirs, len(theirs), columns),
                        lambda: [*table.columns.values()], None,
                        lambda row: f"{path}{table.place(row)}")
    text = log_text(path, table.lines, columns)
    return LogTable(str(path), list(zip(text.names, text.factors, strict=True)),
                    cache(lambda: [*numbers_of(text).T]), text.rate_hz, text.place)


def _by_rate(table: LogTable) -> list[LogTable]:
    """One table for each triad if their readings are in different rows, else the table."""
    there = {triad: ~np.isnan([table.values[name] for name in triad]).all(axis=0)
             for triad in (ACCELEROMETER, GYROSCOPE) if triad[0] in table.values}
    if len({rows.tobytes() for rows in there.values()}) < 2:
        return [table]
    return [table.at(np.flatnonzero(rows), [name for other in there if other is not triad
                                            for name in other])
            for triad, rows in there.items()]


def _imu_log(table: LogTable, stated: StatedClock, label: str) -> ImuLog:
    table, gaps = _without_gaps(table)
    if newest_first(table.values.get(TIME, np.zeros(0))):
        table = table.at(np.arange(len(table.values[TIME]))[::-1])
        gaps = (*gaps, "its newest row is first, and it is read from its end")
    table, ends = _without_ends(table)
    table, repeats = _without_repeats(table)
    time_s, notes = sample_times(
        table.label, table.values, table.time_factor, stated, table.rate_hz, table.place)
    values = dict(table.values)
    absent = np.full((len(time_s), 3), np.nan)
    triads = {triad: np.column_stack([values.pop(name) for name in triad])
              if triad[0] in values else absent for triad in (ACCELEROMETER, GYROSCOPE)}
    values.pop(TIME, None)
    return ImuLog(label, time_s, triads[ACCELEROMETER], triads[GYROSCOPE], values,
                  (*gaps, *ends, *repeats, *notes))


def _without_ends(table: LogTable) -> tuple[LogTable, tuple[str, ...]]:
    """The table without a first or last row that stands apart, and a note on their number."""
    if TIME not in table.values:
        return table, ()
    kept = within_the_log(table.values[TIME])
    return (table, ()) if kept.all() else (table.at(np.flatnonzero(kept)), (
        f"first or last rows whose times are far from those of the others, and that are left out: "
        f"{(~kept).sum()} of {len(kept)}",))


def repeats(columns: Sequence[FloatArray]) -> NDArray[np.bool_]:
    """Whether each row (t,) was there before, with its time, the first of ``columns``, and all
    readings: a logger wrote it again, or a file was put together from parts that overlap."""
    again = np.zeros(len(columns[0]), bool)
    if (np.diff(columns[0]) <= 0).any():
        again[:] = True
        again[np.unique(np.column_stack(columns), axis=0, return_index=True)[1]] = False
    return again


def newest_first(time_s: FloatArray) -> bool:
    """Whether all times (t,) decrease, as in a table that a web page or a spreadsheet sorted."""
    return len(time_s) > 1 and bool((np.diff(time_s) < 0).all())


def _without_repeats(table: LogTable) -> tuple[LogTable, tuple[str, ...]]:
    """The table without rows that are there twice, and a note on their number."""
    if TIME not in table.values:
        return table, ()
    rows = repeats([table.values[name] for name in (TIME, *ACCELEROMETER, *GYROSCOPE)
                    if name in table.values])
    return (table.at(np.flatnonzero(~rows)), (
        f"rows that repeat those before and are left out: {rows.sum()} of {len(rows)}",)
    ) if rows.any() else (table, ())


def _without_gaps(table: LogTable) -> tuple[LogTable, tuple[str, ...]]:
    """The table without the few rows that lack a time or a reading, and a note on their number.

    Other columns may be NaN, as absent telemetry is.
    """
    read = [name for name in READINGS if name in table.values]
    lacking = ~np.isfinite(np.array([table.values[name] for name in read]))
    rows: NDArray[np.bool_] = lacking.any(axis=0)
    if not rows.any():
        return table, ()
    if rows.mean() > MOST_LACKING:
        row = int(np.flatnonzero(rows)[0])
        name = read[int(np.flatnonzero(lacking[:, row])[0])]
        raise UnreadableInput(
            f"{table.place(row)}: column {name}: found {table.values[name][row]}, a finite number "
            f"is expected; {rows.mean():.0%} of the rows lack one. Delete the damaged lines, or "
            f"record the log again.")
    return table.at(np.flatnonzero(~rows)), (
        f"rows that lack a reading and are left out: {rows.sum()} of {len(rows)}",)
