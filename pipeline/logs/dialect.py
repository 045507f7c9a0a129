"""Cells of a line of a text table, and the numbers and times in them."""

import csv
import re
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

SHOWN = 400  #: number of lines that show the kinds, forms and columns of a log; one of ROS has 50
DELIMITERS = ("\t", ";", "|", ",")
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
FLAGS = re.compile(r"(?<=[A-Za-z])\|(?=[A-Za-z])")  #: a bar between words of a cell: ``ANGLE|ARM``
COMMENT = re.compile(r"^#|(?<![A-Za-z])#(?!\d)")  #: not part of a name: ``Tick#``, ``Run #1``
NUMPY = re.compile(r"\bnp\.(?:float|u?int)\d+\(([^()]*)\)")  #: a number as NumPy 2 shows it
LOST = "#!"  #: comment sign of a line of numbers that is no sample
CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})(?:[.,:](\d+))?\s*([AaPp][Mm])?")
DAYS = re.compile(r"(\d+) days? \+?(.+)")  #: before a time, in a difference of pandas
WATCH = re.compile(r"(\d{1,3}):([0-5]\d[.,]\d+)")  #: minutes, seconds and a fraction
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
NAMED_MONTH = re.compile(rf"(\d{{1,2}})[-/. ]+({'|'.join(MONTHS)})[a-z]*[-/. ]+(\d{{4}})[ T](.+)",
                         re.IGNORECASE)
"""Date of MATLAB, ``21-Mar-2024 14:05:00.123``, with any sign beside the month."""
LOCAL_DATE = re.compile(r"(\d{1,4}[./-]\d{1,2}(?:[./-]\d{1,4})?)[ /](.+)")


@dataclass(frozen=True)
class Dialect:
    """The delimiter of the columns of a line (None: any blanks), and the decimal sign."""

    delimiter: str | None
    decimal_comma: bool = False

    def cells(self, line: str) -> list[str]:
        """The line's cells without blanks around them and without what follows a ``#``."""
        return split_cells(line, self.delimiter)

    def holds_number(self, cell: str) -> bool:
        """Whether a cell is a number in this dialect."""
        return is_number(self.decimal_points(cell))

    def hold_numbers(self, cells: Sequence[str]) -> bool:
        """Whether all of many cells are numbers in this dialect."""
        text = self.decimal_points("\n".join(cells))
        try:
            deque(map(float, text.split("\n") if cells else ()), maxlen=0)
        except ValueError:
            return False
        return "_" not in text and text.isascii()

    def decimal_points(self, text: str) -> str:
        """``text`` with decimal points."""
        return text.replace(",", ".") if self.decimal_comma else text


def is_number(cell: str) -> bool:
    """Whether a cell holds a number as C reads it (Python takes ``1_000`` and ``１`` too)."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell and cell.isascii()


def split_cells(line: str, delimiter: str | None) -> list[str]:
    """The line's cells without blanks around them and without what follows a ``#``."""
    if "#" in line:
        line = COMMENT.split(line, 1)[0]
    if '"' in line and delimiter is not None:
        try:
            return [cell.strip() for cell in next(csv.reader([line.strip()], delimiter=delimiter))]
        except csv.Error:  # a control character: not a table, which its cells will show
            return line.split(delimiter)
    words = line.split()
    if words == [line]:  # no blank to strip: half of the time of most logs
        return line.split(delimiter)
    return [cell.strip() for cell in line.split(delimiter)] if words else []


def delimiter_of(line: str) -> str | None:
    """The delimiter of the cells of a line of names, None for blanks."""
    if "|" in line and "," in line:
        line = FLAGS.sub(" ", line)
    return next((sign for sign in DELIMITERS if sign in line), None)


def dialect_of(line: str) -> Dialect:
    """The dialect in which most cells of a row are numbers."""
    delimiter = delimiter_of(line)
    if delimiter != ",":
        commas = any(DECIMAL_COMMA.fullmatch(cell) for cell in split_cells(line, delimiter))
        return Dialect(delimiter, commas)
    blanks = line.split()
    if len(blanks) > 1 and all(is_number(cell) or DECIMAL_COMMA.fullmatch(cell)
                               for cell in blanks):
        return Dialect(None, True)  # "0,01 9,81 0,02": commas inside the numbers only
    if '"' in line and (quoted := split_cells(line, ",")):
        return Dialect(",", any(DECIMAL_COMMA.fullmatch(cell) for cell in quoted))
    return Dialect(",")


def dialect_of_rows(lines: Sequence[str]) -> Dialect:
    """The dialect of many rows; a decimal comma may be absent in the first of them."""
    first = dialect_of(lines[0])
    if first.decimal_comma or first.delimiter == ",":
        return first
    commas = any("," in line and dialect_of(line).decimal_comma for line in lines)
    return Dialect(first.delimiter, commas)


def seconds_of(cell: str) -> float | None:
    """A date and a time, a time of the day, or of a stopwatch, as seconds; None if it is neither.

    >>> seconds_of("00:01:00.25"), seconds_of("1970-01-02 00:00:01"), seconds_of("01:05,25")
    (60.25, 86401.0, 65.25)
    """
    text = cell.strip().strip('"')
    days = DAYS.fullmatch(text)
    if match := CLOCK.fullmatch(days[2] if days else text):
        return 86_400.0 * int(days[1] if days else 0) + _day_seconds(match)
    if match := WATCH.fullmatch(text):
        return 60.0 * int(match[1]) + float(match[2].replace(",", "."))
    if match := NAMED_MONTH.fullmatch(text):
        text = f"{match[3]}-{MONTHS.index(match[2].lower()) + 1:02d}-{int(match[1]):02d} {match[4]}"
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return None
    if not any(sign in text for sign in ":T"):
        return None  # a date alone, or a number that reads as one
    return when.replace(tzinfo=when.tzinfo or UTC).timestamp()


def local_date_seconds(cell: str) -> tuple[str, float] | None:
    """The date as a text and the time of the day of ``3.4.2024 12:00:00``, ``11-27 18:09:28`` or
    ``2024/04/03/12:00:00``; else None.

    The position of the day differs between countries, so the date is only compared.
    """
    dated = LOCAL_DATE.fullmatch(cell.strip().strip('"'))
    match = CLOCK.fullmatch(dated[2].strip()) if dated else None
    return None if dated is None or match is None else (dated[1], _day_seconds(match))


def _day_seconds(match: re.Match[str]) -> float:
    hours, minutes, seconds, fraction, half = match.groups()
    hour = int(hours) % 12 + (12 if half.lower() == "pm" else 0) if half else int(hours)
    return hour * 3600.0 + int(minutes) * 60.0 + int(seconds) + float(f"0.{fraction or 0}")
