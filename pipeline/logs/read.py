"""Conversion of log files to :class:`calib.poses.imu_log.ImuLog`.

NumPy's C parser reads the rows of a text. Only if it fails or returns impossible values, the file
is read again line by line to locate the fault. Files of other kinds are read by the library of
their format (:mod:`pipeline.logs.formats`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calib.poses.imu_log import FloatArray, ImuLog, IntArray
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import StatedClock, sample_times
from pipeline.logs.columns import (
    ACCELEROMETER,
    GYROSCOPE,
    READINGS,
    SKIP,
    TIME,
    ColumnNames,
    missing_columns,
)
from pipeline.logs.formats.archive import member_lines
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.formats.kinds import ARCHIVE, kind_of, split_member, tables_of
from pipeline.logs.header import named_columns, our_names
from pipeline.logs.join import join_logs
from pipeline.logs.source import picked_lines, read_bytes, tables_of_text
from pipeline.logs.text import MOST_LACKING, LogText, log_text, numbers_of
from pipeline.text.names import nearest_name

MOST_DISTINCT = 0.9
"""Least share of distinct rows in a log without copies of its own rows. A judgement: the readings
of a board that was reset differ by noise, whatever its clock does."""
TABLES = 6  #: tables that a message lists


@dataclass(frozen=True, eq=False)
class LogTable:
    """The numeric columns of one log, by our names.

    Parameters
    ----------
    label : str
        Its name in messages.
    values : mapping of str to array, shape (t,)
    time_factor : float
        Seconds per unit of the column of times, by its name in the file.
    rate_hz : float or None
        The sample rate, if the file states one.
    place : callable
        File and line (or row) of a row, for messages.
    """

    label: str
    values: Mapping[str, FloatArray]
    time_factor: float
    rate_hz: float | None
    place: Callable[[int], str]


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
    file, member = split_member(path)
    if file.is_file() and kind_of(file) is None:
        lines = picked_lines(file, tables_of_text(file, read_bytes(file)), member)
        names = log_text(path, lines, columns).names
        return [name for name in names if name != SKIP]
    return [name for table in read_tables(path, columns) for name in table.values]


def read_tables(path: Path, columns: ColumnNames | None = None) -> list[LogTable]:
    """Read the columns of one log file, as several tables if its triads are separate.

    Parameters are those of :func:`read_log`.

    Raises
    ------
    UnreadableInput
        As in :func:`read_log`, or ``path`` names a member of a file that is one table of text.
    """
    file, member = split_member(path)
    kind = kind_of(file)
    if kind is None:
        lines = picked_lines(file, tables_of_text(file, read_bytes(file)), member)
        return _by_rate(_text_table(log_text(path, lines, columns)))
    if kind == ARCHIVE and (inside := member_lines(file, member)) is not None:
        return _by_rate(_text_table(log_text(path, inside, columns)))
    return _picked(path, member, tables_of(file, kind), columns)


def _picked(
    path: Path, member: str, tables: Sequence[FileTable], columns: ColumnNames | None
) -> list[LogTable]:
    """The table with the name ``member``, else the tables that hold each triad once."""
    if member:
        named = [table for table in tables if table.name == member]
        if not named:
            names = [table.name for table in tables]
            raise UnreadableInput(f"{path}: no table is named '{member}'"
                                  f"{nearest_name(member, names)}; there are: {', '.join(names)}.")
        return [_named_table(path, named[0], columns)]
    if columns is not None and len(tables) == 1:
        return [_named_table(path, tables[0], columns)]
    whole = [table for table in tables
             if missing_columns([name for name, _ in our_names(list(table.columns))]) is None]
    triads = [triad for table in whole for triad in (ACCELEROMETER, GYROSCOPE)
              if triad[0] in {name for name, _ in our_names(list(table.columns))}]
    if columns is None and whole and len(set(triads)) == len(triads):
        return [_named_table(path, table, None) for table in whole]
    listed = "; ".join(f"{table.name} ({', '.join(table.columns)})" for table in tables[:TABLES])
    raise UnreadableInput(
        f"{path}: which of its tables holds the readings is not clear: {listed}. Name one as a "
        f"file, as in `{path.name}/{tables[0].name}`, with `columns` for names that are not ours; "
        f"`pipeline import {path.name}` guesses both."
    )


def _named_table(path: Path, table: FileTable, columns: ColumnNames | None) -> LogTable:
    """A table of a file, with our names for its columns."""
    theirs = list(table.columns)
    names = named_columns(str(path), theirs, len(theirs), columns)
    return _log_table(str(path), names, list(table.columns.values()), None,
                      lambda row: f"{path}, row {row + 1}")


def _text_table(text: LogText) -> LogTable:
    names = list(zip(text.names, text.factors, strict=True))
    return _log_table(str(text.path), names, list(numbers_of(text).T), text.rate_hz, text.place)


def _by_rate(table: LogTable) -> list[LogTable]:
    """One table for each triad if their readings are in different rows, else the table."""
    there = {triad: ~np.isnan([table.values[name] for name in triad]).all(axis=0)
             for triad in (ACCELEROMETER, GYROSCOPE) if triad[0] in table.values}
    if len({rows.tobytes() for rows in there.values()}) < 2:
        return [table]
    parts = []
    for triad, rows in there.items():
        at = np.flatnonzero(rows)
        other = {name for names in there if names is not triad for name in names}
        parts.append(replace(table, place=_row_of(table, at), values={
            name: values[at] for name, values in table.values.items() if name not in other}))
    return parts


def _row_of(table: LogTable, at: IntArray) -> Callable[[int], str]:
    """The place function for a table of the rows ``at`` of ``table``."""
    return lambda row: table.place(int(at[row]))


def _log_table(
    label: str,
    names: Sequence[tuple[str, float]],
    columns: Sequence[FloatArray],
    rate_hz: float | None,
    place: Callable[[int], str],
) -> LogTable:
    """A table in our units, except the time, whose unit the configuration may override."""
    values: dict[str, FloatArray] = {}
    time_factor = 1.0
    for (name, factor), column in zip(names, columns, strict=True):
        if name == TIME:
            time_factor = factor
        if name != SKIP:
            values[name] = column if name == TIME else column * factor
    return LogTable(label, values, time_factor, rate_hz, place)


def _imu_log(table: LogTable, stated: StatedClock, label: str) -> ImuLog:
    table, gaps = _without_gaps(table)
    values = dict(table.values)
    time_s, notes = sample_times(
        table.label, values, table.time_factor, stated, table.rate_hz, table.place)
    if notes:
        _require_no_copy(table)
    absent = np.full((len(time_s), 3), np.nan)
    triads = {triad: np.column_stack([values.pop(name) for name in triad])
              if triad[0] in values else absent for triad in (ACCELEROMETER, GYROSCOPE)}
    values.pop(TIME, None)
    return ImuLog(label, time_s, triads[ACCELEROMETER], triads[GYROSCOPE], values, (*gaps, *notes))


def _require_no_copy(table: LogTable) -> None:
    """Refuse a log that repeats its times and readings, because it was joined to itself."""
    rows = np.column_stack([table.values[name] for name in READINGS if name in table.values])
    distinct = len(np.unique(rows, axis=0))
    if distinct < MOST_DISTINCT * len(rows):
        raise UnreadableInput(
            f"{table.label}: {len(rows) - distinct} of its {len(rows)} rows stand in it twice, "
            "times and readings alike. The file was joined to itself; delete the second copy.")


def _without_gaps(table: LogTable) -> tuple[LogTable, tuple[str, ...]]:
    """The table without the few rows that lack a time or a reading, and a note on their number.

    Other columns may be NaN, as absent telemetry is.
    """
    read = [name for name in READINGS if name in table.values]
    lacking = ~np.isfinite(np.array([table.values[name] for name in read]))
    rows: NDArray[np.bool_] = lacking.any(axis=0)
    if not rows.any():
        return table, ()
    infinite = any(np.isinf(table.values[name]).any() for name in read)
    if infinite or rows.mean() > MOST_LACKING:
        row = int(np.flatnonzero(rows)[0])
        name = read[int(np.flatnonzero(lacking[:, row])[0])]
        raise UnreadableInput(
            f"{table.place(row)}: column {name}: found {table.values[name][row]}, a finite number "
            f"is expected; {rows.mean():.0%} of the rows lack one. Delete the damaged lines, or "
            f"record the log again.")
    at = np.flatnonzero(~rows)
    whole = {name: values[at] for name, values in table.values.items()}
    return replace(table, values=whole, place=_row_of(table, at)), (
        f"rows that lack a reading and are left out: {rows.sum()} of {len(rows)}",)
