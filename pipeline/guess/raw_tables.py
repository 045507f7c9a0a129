"""Files as tables of numbers under the names that stand in them; nothing is guessed yet."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from calib.poses.imu_log import FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import bare
from pipeline.logs.formats.kinds import kind_of, split_member, tables_of
from pipeline.logs.head import find_head
from pipeline.logs.source import read_bytes, text_lines
from pipeline.logs.text import LogText, columns_of_text, raw_text
from pipeline.text.commands import word

#: What loggers write above the rows: "Fs,100", "sample_rate: 100 Hz", "Update Rate: 100.0Hz".
STATED_RATE = re.compile(
    r"(?:\bfs\b|\bodr\b|(?:sample|sampling|update|output)[ _]?(?:rate|frequency|freq))"
    r"(?:[ _]?\(?hz\)?)?\s*[,:=\s]\s*([0-9.]+)", re.IGNORECASE)


EVENTS = 200  #: rows that show whether a file is a list of events
MOST_KINDS = 12  #: sensors of a phone


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
            raise UnreadableInput(
                f"{path}: no line holds three numbers. Is it a log? Readings are expected as a "
                f"table, one row for each sample, as in `time_s,acc_x,acc_y,acc_z`.")
        _require_no_events(text)
        _require_whole_rows(text)
        return [_text_table(text)]
    tables = [table for table in tables_of(file, kind) if member in ("", table.name)]
    whole = len(tables) == 1 and kind.si
    return [RawTable(file if whole else file / table.name, table.columns, si=kind.si,
                     header=tuple(table.columns))
            for table in tables if table.columns]


def _require_no_events(text: LogText) -> None:
    """Refuse a list of events of several sensors, each row named by a word."""
    rows = [cells for _, cells in islice(text.rows(), EVENTS)]
    for i in range(min(map(len, rows), default=0)):
        words = [cells[i] for cells in rows]
        kinds = dict.fromkeys(words)
        readings = [word for word in kinds if hint_word(word)]
        if len(readings) > 1 and len(kinds) <= MOST_KINDS:
            listed = ", ".join(list(kinds)[:MOST_KINDS])
            raise UnreadableInput(
                f"{text.path}: column {i + 1} names the sensor of each row ({listed}): the rows "
                f"are events of several sensors and no samples of one. Write a file for each "
                f"sensor, for example by `grep {readings[0]} {text.path.name} > "
                f"{readings[0].lower()}.csv`, and import these files together.")


def _require_whole_rows(text: LogText) -> None:
    """Refuse rows that hold the readings of one sensor at a time, the cells of the other empty."""
    rows = [cells for _, cells in islice(text.rows(), EVENTS)]
    names = [bare(name) for name in find_head(text.lines).names or ()]
    filled = {tuple(bool(cell) for cell in cells) for cells in rows if len(cells) == len(names)}
    if not 2 <= len(filled) <= MOST_KINDS or any(map(all, filled)):
        return
    # Sensors that take turns: no column but the times is filled in rows of two kinds.
    shared = [i for i in range(len(names)) if sum(kind[i] for kind in filled) > 1]
    alone = [[i for i, there in enumerate(kind) if there and i not in shared] for kind in filled]
    if all(all(kind[i] for kind in filled) for i in shared) and all(map(len, alone)):
        parts = "; ".join(", ".join(names[i] for i in places) for places in sorted(alone))
        sign, places = text.dialect.delimiter or " ", sorted(alone)[0]
        kept = ", ".join(f"${i + 1}" for i in sorted({*shared, *places}))
        raise UnreadableInput(
            f"{text.path}: each row holds the readings of one sensor only ({parts}). Write a file "
            f"for each, for example by `awk -F'{sign}' -v OFS='{sign}' '${places[0] + 1} != \"\" "
            f"{{print {kept}}}' {word(text.path.name)} > {word(names[places[0]])}.csv`, and import "
            f"these files together.")


def hint_word(word: str) -> str:
    """``acc`` or ``gyr`` where a word of a row names that sensor."""
    return next((name for name in ("acc", "gyr") if word.lower().startswith(name)), "")


def _text_table(text: LogText) -> RawTable:
    above = "\n".join(text.lines[: text.first])
    stated = STATED_RATE.search(above)
    rate_hz = text.rate_hz or (float(stated.group(1)) if stated else None)
    columns = columns_of_text(text)
    if not columns:
        raise UnreadableInput(f"{text.path}: no column holds numbers in its first row.")
    without_header = all(name.isdecimal() for name in columns)
    positions = tuple(name if name in columns else "" for name in text.names)
    names = find_head(text.lines).names or ()
    return RawTable(text.path, columns, positions if without_header else (), rate_hz=rate_hz,
                    header=tuple(map(bare, names)))
