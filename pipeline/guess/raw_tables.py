"""Files as tables of numbers under the names in the files, before any guess."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.poses.imu_log import AXES, BoolArray, FloatArray
from pipeline.errors import NoReadings, UnreadableInput
from pipeline.guess.no_log import fault_of_columns, fault_of_lines, fault_of_rows, why_no_table
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, bare
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.formats.kinds import kind_of, split_member
from pipeline.logs.head import find_head
from pipeline.logs.header_words import read_name
from pipeline.logs.tables import TextTable, tables_in
from pipeline.logs.text import LogText, columns_of_text, raw_text

IN_SI = {**dict.fromkeys(ACCELEROMETER, " (m/s^2)"), **dict.fromkeys(GYROSCOPE, " (rad/s)")}
"""Units behind our names of columns, of formats that state them."""


@dataclass(frozen=True, eq=False)
class RawTable:
    """One table of one file.

    Parameters
    ----------
    path : Path
        The path in a configuration: the file, or the file with the name of a table in it.
    columns : mapping of str to array, shape (t,)
        Numeric columns by their names in the file; by position from 1 if it has no header.
    positions : tuple of str
        The names of all columns, empty for columns of text; only for files without a header.
    rate_hz : float or None
        A sample rate that the file states.
    header : tuple of str
        The names of all columns, including those of text; empty if the file has no header.
    lost : int
        Number of lines of numbers that are no samples.
    """

    path: Path
    columns: Mapping[str, FloatArray]
    positions: tuple[str, ...] = ()
    rate_hz: float | None = None
    header: tuple[str, ...] = ()
    lost: int = 0

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())))


def raw_tables(path: Path, beside: Sequence[Path] = ()) -> list[RawTable]:
    """All tables of a file, imported ``beside`` others, that hold numbers.

    Raises
    ------
    UnreadableInput
        The file cannot be read, or holds no table.
    """
    file, _ = split_member(path)
    kind = kind_of(file)
    units = IN_SI if kind and kind.si else {}
    tables = tables_in(path)
    faults = [fault_of_columns(table) for table in tables if isinstance(table, FileTable)]
    if faults and all(faults):
        raise UnreadableInput(f"{path}: {faults[0]}.")
    several = len(tables) > 1
    read: list[RawTable | None] = []
    for table in tables:
        place = file / table.name
        if isinstance(table, TextTable):
            read.append(_table_of_lines(place, table.lines, several, beside))
        elif table.columns and not fault_of_columns(table):
            columns = {name + units.get(name, ""): values for name, values in table.columns.items()}
            read.append(RawTable(place if several else file, columns, header=tuple(columns)))
    return [table for table in read if table is not None]


def _table_of_lines(
    path: Path, lines: list[str], one_of_many: bool, beside: Sequence[Path]
) -> RawTable | None:
    """The table of a text; None if it is one of many and has no rows."""
    if not (fault := fault_of_lines(lines)):
        text = raw_text(path, lines)
        if text is None and one_of_many:
            return None
        if text is None:
            raise NoReadings(f"{path}: {why_no_table(lines, beside)}.")
        if not (fault := fault_of_rows(text)):
            return _text_table(text)
    raise UnreadableInput(f"{path}: {fault}.")


def _continued(values: FloatArray) -> FloatArray:
    """A column (t,) of a sensor slower than the rows, with its missing values interpolated."""
    there = np.flatnonzero(np.isfinite(values))
    if not 2 <= len(there) < len(values):
        return values
    return np.asarray(np.interp(np.arange(len(values)), there, values[there]))


def _rows_of_sensors(columns: Mapping[str, FloatArray]) -> BoolArray:
    """Whether three columns or more have a number in each row (t,), those of other quantities
    aside: a magnetometer or a pressure may have rows of its own between those of the sensor."""
    there = [np.isfinite(values) for name, values in columns.items()
             if not read_name(name).is_other and read_name(name).quantity != "time"]
    none = np.zeros(len(next(iter(columns.values()))), bool)
    rows = np.sum([none, *there], axis=0) >= len(AXES)
    return rows if rows.any() else np.ones_like(rows)


def _text_table(text: LogText) -> RawTable:
    lost, columns = columns_of_text(text)
    if not columns:
        raise UnreadableInput(f"{text.path}: no column holds numbers in its first row. A row of "
                              f"readings is expected there: delete what is none.")
    rows = _rows_of_sensors(columns)
    columns = {name: _continued(values)[rows] for name, values in columns.items()}
    without_header = all(name.isdecimal() for name in columns)
    positions = tuple(name if name in columns else "" for name in text.names)
    names = find_head(text.lines).names or ()
    return RawTable(text.path, columns, positions if without_header else (),
                    rate_hz=text.rate_hz, header=tuple(map(bare, names)), lost=lost)
