"""A log file's text and its head: where the rows begin, and what their columns are."""

import gzip
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.logs.columns import KNOWN_NAMES, SKIP, USUAL, missing_columns, our_name
from pipeline.names import nearest_names

GZIP_MAGIC = b"\x1f\x8b"
COMMENT_SIGNS = ("#", "//", "%")
#: Written by MT Manager among its comments; missing in some exports, so never assumed.
UPDATE_RATE = re.compile(r"Update Rate:\s*([0-9.]+)\s*Hz", re.IGNORECASE)
#: Settings that loggers write above the header ("Fs,100") take a few lines, not more.
LONGEST_HEAD = 200

LONGEST_SHOWN, CELLS_SHOWN = 30, 12  #: of a wrong header, in a message

MISSING_TRIAD = ("The header needs time_s and acc_x, acc_y, acc_z or gyr_x, gyr_y, gyr_z or both; "
                 "rename the columns, or give their names by `columns` in the configuration")


@dataclass(frozen=True)
class LogText:
    """A log as lines of text.

    Parameters
    ----------
    path : Path
        What messages call the file.
    lines : list of str
        All lines of the file, without line ends.
    first : int
        Index of the first line that may hold a row.
    names : tuple of str
        Our name of every column, ``skip`` for those not to be read.
    factors : tuple of float
        What brings each column to our unit.
    delimiter : str or None
        Between the columns; None stands for any blanks.
    rate_hz : float or None
        The sample rate, where the head states one.
    """

    path: Path
    lines: list[str]
    first: int
    names: tuple[str, ...]
    factors: tuple[float, ...]
    delimiter: str | None
    rate_hz: float | None

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line in the file, from 1, and cells of every row; the slow way, for messages."""
        for number, line in enumerate(self.lines[self.first :], self.first + 1):
            if cells := split_cells(line, self.delimiter):
                yield number, cells


def is_number(cell: str) -> bool:
    """Whether a cell holds a number as C reads it (Python would take ``1_000`` too)."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def split_cells(line: str, delimiter: str | None) -> list[str]:
    """The line's cells without blanks around them and without what follows a ``#``."""
    line = line.split("#", 1)[0]
    return [cell.strip() for cell in line.split(delimiter)] if line.strip() else []


def read_text(path: Path) -> list[str]:
    """The lines of a text file, compressed or not.

    Raises
    ------
    UnreadableInput
        The file is missing or empty, the compression is damaged, or it is not text.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UnreadableInput(f"{path}: cannot be read ({error.strerror}). Check the name, and "
                              "that you may read the file.") from error
    if data.startswith(GZIP_MAGIC):
        try:
            data = gzip.decompress(data)
        except (EOFError, OSError, zlib.error) as error:
            raise UnreadableInput(
                f"{path}: the compressed file is damaged or cut off ({error}). Copy it again from "
                "where it was made, or pack it again with gzip."
            ) from error
    if not data.strip():
        raise UnreadableInput(f"{path}: the file is empty; a header and rows of readings are "
                              "expected. Record the pose again.")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise UnreadableInput(f"{path}: the text is UTF-16, as PowerShell's '>' writes it; UTF-8 "
                              "is expected. Save it as UTF-8.")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _not_text(path, data, error.start) from error
    if "\0" in text:
        raise _not_text(path, data, data.index(0))
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _not_text(path: Path, data: bytes, start: int) -> UnreadableInput:
    line = data.count(b"\n", 0, start) + 1
    return UnreadableInput(
        f"{path}:{line}: byte 0x{data[start]:02x} is not text (UTF-8 is expected). If this is a "
        "log, delete the damaged line or save the file as UTF-8; video and binary logs cannot be "
        "read here."
    )


def read_head(path: Path, lines: list[str], columns: Sequence[str] | None) -> LogText:
    """Find the columns' names and the first row.

    Parameters
    ----------
    path : Path
        What messages call the file.
    lines : list of str
        The file.
    columns : sequence of str, optional
        Names that replace the header's, for files without one.

    Raises
    ------
    UnreadableInput
        No header names a triad, or rows have no header and no ``columns``.
    """
    rate_hz: float | None = None
    header: list[str] | None = None
    strange: tuple[int, list[str]] | None = None  # the first line that is neither
    for i, line in enumerate(lines[:LONGEST_HEAD]):
        bare = line.strip()
        if bare.startswith(COMMENT_SIGNS):
            stated = UPDATE_RATE.search(bare)
            rate_hz = float(stated.group(1)) if stated else rate_hz
            cells = split_cells(bare.lstrip("#/% "), _delimiter(bare))
            header = cells if columns is None and _names_a_log(cells) else header
            continue
        cells = split_cells(line, _delimiter(line))
        if not cells:
            continue
        if columns is None and _names_a_log(cells):
            header = cells
        elif header or (columns and any(map(is_number, cells))):
            return _log_text(path, lines, i, columns or header or (), rate_hz)
        elif columns is None and all(map(is_number, cells)):
            raise _wrong_header(path, *strange) if strange else _headerless(path, i, len(cells))
        else:
            strange = strange or (i, cells)
    if strange and not columns and not header:
        raise _wrong_header(path, *strange)
    raise UnreadableInput(f"{path}: there is no row of numbers below the header. Record the pose "
                          "again, or name the right file.")


def _delimiter(line: str) -> str | None:
    """Semicolons before commas: these may be decimal commas, which a message then explains."""
    return next((sign for sign in ("\t", ";", ",") if sign in line), None)


def _names_a_log(cells: Sequence[str]) -> bool:
    return missing_columns([our_name(cell)[0] for cell in cells]) is None


def _headerless(path: Path, i: int, n: int) -> UnreadableInput:
    """The error for rows without a header: what they mean is asked, not guessed."""
    usual = ", ".join(USUAL.get(n, USUAL[7]))
    return UnreadableInput(
        f"{path}:{i + 1}: {n} column{'' if n == 1 else 's'} of numbers without a header. Name them "
        f"beside the file in the configuration, for example `columns: [{usual}]`; '{SKIP}' names "
        f"a column not to be read."
    )


def _wrong_header(path: Path, i: int, cells: list[str]) -> UnreadableInput:
    """The error for a header that names no triad, with the nearest right names."""
    names = [our_name(cell)[0] for cell in cells]
    near = [f"'{name}' for '{cell}'" for cell in cells if our_name(cell)[0] not in KNOWN_NAMES
            for name in nearest_names(cell, KNOWN_NAMES)]
    meant = f" (did you mean {', '.join(near)}?)" if near else ""
    shown = ", ".join(cell[:LONGEST_SHOWN] for cell in cells[:CELLS_SHOWN])
    return UnreadableInput(
        f"{path}:{i + 1}: found {shown}{', ...' if len(cells) > CELLS_SHOWN else ''}: "
        f"{missing_columns(names)}{meant}. {MISSING_TRIAD}."
    )


def _log_text(
    path: Path, lines: list[str], first: int, header: Sequence[str], rate_hz: float | None
) -> LogText:
    """The log whose first row is line ``first``; columns that hold text there are skipped."""
    delimiter = _delimiter(lines[first])
    cells = split_cells(lines[first], delimiter)
    names = [our_name(name) for name in header]
    if cells[-1] == "" and len(cells) == len(names) + 1:  # every row ends in a delimiter
        names.append((SKIP, 1.0))
    if len(cells) != len(names):
        raise UnreadableInput(
            f"{path}:{first + 1}: {len(cells)} values found, {len(names)} expected "
            f"({', '.join(header)}). Name every column of the file, '{SKIP}' for those not to be "
            f"read, or delete the damaged line."
        )
    if lacks := missing_columns([name for name, _ in names]):
        raise UnreadableInput(f"{path}: {lacks}. {MISSING_TRIAD}.")
    read = [(name, factor) if name in KNOWN_NAMES or is_number(cell) else (SKIP, 1.0)
            for (name, factor), cell in zip(names, cells, strict=True)]
    return LogText(path, lines, first, tuple(name for name, _ in read),
                   tuple(factor for _, factor in read), delimiter, rate_hz)
