"""Files as tables of numbers under the names that stand in them; nothing is guessed yet."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import bare
from pipeline.logs.dialect import delimiter_of, split_cells
from pipeline.logs.formats.kinds import kind_of, split_member, tables_of
from pipeline.logs.head import find_head
from pipeline.logs.header_words import read_name
from pipeline.logs.source import read_bytes, text_lines
from pipeline.logs.text import LogText, columns_of_text, raw_text
from pipeline.text.names import word

#: What loggers write above the rows: "Fs,100", "sample_rate: 100 Hz", "Update Rate: 100.0Hz".
STATED_RATE = re.compile(
    r"(?:\bfs\b|\bodr\b|(?:sample|sampling|update|output)[ _]?(?:rate|frequency|freq))"
    r"(?:[ _]?\(?hz\)?)?\s*[,:=\s]\s*([0-9.]+)", re.IGNORECASE)


EVENTS = 200  #: rows that show whether a file is a list of events
MOST_KINDS = 12  #: sensors of a phone
LEAST_TURNS = 0.25
"""Share of the rows that name another board than the one before. A judgement: boards that send in
turns change in half of the rows or more, the state of one board changes seldom."""
NAMES_A_BOARD = re.compile(r"(?<![a-z])(id|node|device|board|sensor|addr|address|mac|imu)(?![a-z])",
                           re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class RawTable:
    """One table of one file.

    Parameters
    ----------
    path : Path
        As a configuration names it: the file, or the file with the name of the table in it.
    columns : mapping of str to array, shape (t,)
        Numeric columns by the names in the file; by their position from 1 where it has no header.
    positions : tuple of str
        The names of all columns, empty for those that hold text; only of a file without a header.
    si : bool
        The format states its units; the names are ours.
    rate_hz : float or None
        A sample rate that the file states.
    header : tuple of str
        The names of all columns, those of text too; empty where the file has no header.
    """

    path: Path
    columns: Mapping[str, FloatArray]
    positions: tuple[str, ...] = ()
    si: bool = False
    rate_hz: float | None = None
    header: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """Their number."""
        return len(next(iter(self.columns.values())))


def raw_tables(path: Path) -> list[RawTable]:
    """All tables of a file that hold numbers.

    Raises
    ------
    UnreadableInput
        The file cannot be read, or holds no table.
    """
    file, member = split_member(path)
    kind = kind_of(file)
    if kind is None:
        lines = text_lines(path, read_bytes(path))
        text = raw_text(path, lines)
        if text is None:
            _require_one_row_a_sample(path, lines)
            raise UnreadableInput(
                f"{path}: no line holds three numbers. Is it a log? Readings are expected as a "
                f"table, one row for each sample, as in `time_s,acc_x,acc_y,acc_z`.")
        _require_one_sensor(text)
        return [_text_table(text)]
    tables = [table for table in tables_of(file, kind) if member in ("", table.name)]
    whole = len(tables) == 1 and kind.si
    return [RawTable(file if whole else file / table.name, table.columns, si=kind.si,
                     header=tuple(table.columns))
            for table in tables if table.columns]


def _require_one_sensor(text: LogText) -> None:
    """Refuse rows of several sensors or boards, each named by a word or a number in its row."""
    rows = [cells for _, cells in islice(text.rows(), EVENTS)]
    names = find_head(text.lines).names or ()
    for i in range(min(map(len, rows), default=0)):
        words = [cells[i] for cells in rows]
        kinds = list(dict.fromkeys(words))
        readings = [word for word in kinds if hint_word(word)]
        turns = sum(one != other for one, other in pairwise(words)) / len(words)
        named = not text.dialect.holds_number(kinds[0]) or (
            i < len(names) and NAMES_A_BOARD.search(names[i]) is not None)
        boards = kinds if named and turns > LEAST_TURNS and all(kinds) else []
        if 1 < len(kinds) <= MOST_KINDS and len(readings or boards) > 1:
            one = (readings or boards)[0]
            sign, header = text.dialect.delimiter or " ", "NR==1 || " if names else ""
            raise UnreadableInput(
                f"{text.path}: column {i + 1} names the sensor of each row ({', '.join(kinds)}): "
                f"the rows are those of several sensors and no samples of one. Write a file for "
                f"each, for example by `awk -F'{sign}' '{header}${i + 1} ~ /{re.escape(one)}/' "
                f"{word(text.path.name)} > {word(re.sub(r'[^a-z0-9]+', '_', one.lower()))}.csv`, "
                f"and import {'these files together' if readings else 'each by itself'}.")


def _require_one_row_a_sample(path: Path, lines: Sequence[str]) -> None:
    """Refuse rows of one value each, whose name stands beside it, as data bases export them."""
    rows = [split_cells(line, delimiter_of(line)) for line in lines[-EVENTS:]]
    rows = [row for row in rows if row and len(row) == len(rows[0])]
    for i, cells in enumerate(zip(*rows, strict=True)):
        kinds = sorted({*cells})
        quantities = {read_name(kind).quantity for kind in kinds}
        if len(kinds) <= MOST_KINDS and quantities & {"acc", "gyr"}:
            raise UnreadableInput(
                f"{path}: each row holds one value, whose name stands in column {i + 1} "
                f"({', '.join(kinds)}). Write one row for each sample with a column for each name: "
                f"`pivot()` does so in InfluxDB, pandas and SQL.")


def _continued(values: FloatArray) -> FloatArray:
    """A column (t,) of a sensor that is slower than the rows, interpolated in the others."""
    there = np.flatnonzero(np.isfinite(values))
    if not 2 <= len(there) < len(values):
        return values
    return np.asarray(np.interp(np.arange(len(values)), there, values[there]))


def hint_word(word: str) -> str:
    """``acc`` or ``gyr`` where a word of a row names that sensor."""
    return next((name for name in ("acc", "gyr") if word.lower().startswith(name)), "")


def _text_table(text: LogText) -> RawTable:
    above = "\n".join(text.lines[: text.first])
    stated = STATED_RATE.search(above)
    rate_hz = text.rate_hz or (float(stated.group(1)) if stated else None)
    columns = {name: _continued(values) for name, values in columns_of_text(text).items()}
    if not columns:
        raise UnreadableInput(f"{text.path}: no column holds numbers in its first row.")
    without_header = all(name.isdecimal() for name in columns)
    positions = tuple(name if name in columns else "" for name in text.names)
    names = find_head(text.lines).names or ()
    return RawTable(text.path, columns, positions if without_header else (), rate_hz=rate_hz,
                    header=tuple(map(bare, names)))
