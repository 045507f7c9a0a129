"""The bytes of a log file and the lines of its text, before its columns are known."""

import gzip
import re
import struct
import zlib
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import BinaryIO

from pipeline.errors import NoReadings, UnreadableInput
from pipeline.files import may_never_end
from pipeline.logs.dialect import NUMPY, delimiter_of, split_cells
from pipeline.logs.head import FEWEST_NUMBERS, LONGEST_HEAD, width_of_numbers
from pipeline.logs.header_words import read_name
from pipeline.logs.memory import largest_text, too_large
from pipeline.text.names import word

REGISTER = re.compile(r"(?<![\w.])0[xX](?:[0-9A-Fa-f]{4}|[0-9A-Fa-f]{8})(?![\w.])")
WORDS = re.compile(r"(?<![\w.+-])[0-9A-Fa-f]{1,8}(?:[ ,;:\t]+[0-9A-Fa-f]{1,8}){2,}(?![\w.])")
"""Three or more registers without ``0x``, written with or without leading zeros."""
SIGNED = (4, 8)  #: fact: digits of registers of two and four bytes
DIGIT = re.compile(r"\d")
MIXED = re.compile(r"(?!\d+[eE]\d+$)(?=.*\d)(?=.*[A-Fa-f])\w+")
"""A word of digits and letters that is no number with an exponent: ``1e05``."""
FOUR_BYTES = re.compile(r"(?<![\w.])(?:0[xX])?(?=\d*[A-Fa-f])([0-9A-Fa-f]{8})(?![\w.])")
FLOATS = (1e-9, 1e9)
"""Range of the numbers of IEEE 754 in four bytes. A fact: whole numbers of 24 bits with their sign
before them are smaller than 1e-37 or larger than 1e38 in that format, or none."""
SHOWN_LENGTH = 5000  #: number of last characters that show which of them hold letters
FORTRAN = re.compile(r"(?<![\w.])([+-]?\d*\.\d*)[Dd]([+-]\d{1,3})(?!\w)")
MINUS = re.compile(r"(?<![\w.])[\u2212\u2010-\u2014\uff0d](?=[\d.,])")
"""Signs that a word processor writes for a minus."""
DRAWN = str.maketrans("│┃║─━═┌┬┐├┼┤└┴┘╔╦╗╠╬╣╚╩╝╭╮╰╯", "|||---" + 22 * "+")
"""Lines that a database draws around its cells, by the signs of those who draw with letters."""
THOUSANDS = re.compile(r"(?<=\d)[\u00a0\u202f\u2009'\u2019](?=\d{3}(?!\d))")
"""Separators of thousands in spreadsheets, which no table uses as delimiter."""
NO_BLANK = re.compile(r"(\.\d++)(?=[-+]\d*+\.\d)")
"""Boundary of two decimal numbers of fixed width without a blank before the second one's sign."""
QUOTED_THOUSANDS = re.compile(r'"[-+]?\d{1,3}(?:,\d{3})+\.\d+"')
"""A number as spreadsheets group it; its point shows that the commas separate thousands."""
IN_BRACKETS = re.compile(r"(?<=[,;\t])\((\d+\.?\d*)\)(?=[,;\t\r\n]|$)")
"""A negative number as accountants write it, alone in its cell."""
MOST_ZEROS = 0.001  #: largest share of gaps of zero bytes in a text, as a port begins with one
SPREADSHEET_ERROR = re.compile(r"#(?:N/A|NV|DIV/0!|VALUE!|WERT!|NUM!|ZAHL!|REF!|NAME\?)")
"""Error values of a spreadsheet, whose ``#`` begins no comment."""
UNIT_BEHIND = re.compile(r"[\[(].*")  #: a unit in brackets, which are the same in any code page
CODE_PAGES = ("cp1252", "cp1251", "gb18030", "shift_jis")
"""Code pages of Windows in the West, Russia, China and Japan; in a tie the first is taken, which
has the letters of units."""
CORRECTED = re.compile(rb"time_s[,;\t](?:acc_x_m_s2|gyr_x_rad_s)[,;\t].*[,;\t]saturated\s*")
"""Header of a log that `pipeline apply` has written."""
LONGEST_HEADER = 10_000  #: bytes
GZIP_MAGIC = b"\x1f\x8b"
TAR_AT, TAR_MAGIC = 257, b"ustar"  #: facts: position and mark of a tar archive


def read_bytes(path: Path) -> bytes:
    """The content of a file, unpacked if it is compressed with gzip.

    Raises
    ------
    UnreadableInput
        The file is missing or empty, is not a regular file, is larger than the memory allows, or
        its compression is damaged.
    """
    limit = largest_text()
    try:
        require_file(path)
        with path.open("rb") as file:
            packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
            file.seek(0)
            data = _unpacked(path, file, limit) if packed else file.read(limit + 1)
    except OSError as error:
        raise UnreadableInput(f"{path}: cannot be read ({error.strerror}). Check the name, and "
                              "that you may read the file.") from error
    if len(data) > limit:
        raise too_large(path, limit)
    if not data.strip():
        raise NoReadings(f"{path}: the file is empty; a header and rows of readings are "
                              "expected. Record the pose again.")
    return data


def is_corrected(path: Path) -> bool:
    """Whether a file has the header of a log that `pipeline apply` has corrected."""
    with suppress(OSError):
        if path.is_file():
            with path.open("rb") as file:
                return CORRECTED.fullmatch(file.readline(LONGEST_HEADER)) is not None
    return False


def require_uncorrected(path: Path) -> None:
    """Refuse a log that `pipeline apply` has corrected where a pose is expected.

    Raises
    ------
    UnreadableInput
        With the path.
    """
    if is_corrected(path):
        raise UnreadableInput(
            f"{path}: `pipeline apply` has corrected this log, and raw readings are expected of a "
            f"pose. Name the raw log, and move this one to another folder or `exclude` it.")


def require_file(path: Path) -> None:
    """Refuse pipes, sockets and devices, which may block or never end.

    Raises
    ------
    UnreadableInput
        ``path`` is neither a file nor a folder.
    OSError
        It is missing, or its type cannot be read.
    """
    if may_never_end(path):
        raise UnreadableInput(f"{path}: is a pipe or a device; a file is expected. Save the log to "
                              "a file first.")


def _unpacked(path: Path, file: BinaryIO, limit: int) -> bytes:
    """The unpacked bytes of a file, at most one more than ``limit``."""
    try:
        with gzip.GzipFile(fileobj=file) as unpacked:
            return unpacked.read(limit + 1)
    except (EOFError, OSError, zlib.error) as error:
        raise UnreadableInput(
            f"{path}: the compressed file is damaged or cut off ({error}). Copy it again from "
            "where it was made, or pack it again with gzip."
        ) from error


def text_lines(path: Path, data: bytes) -> list[str]:
    """The lines of a text by their numbers, with an empty line 0.

    The text is in UTF-8, or in UTF-16, whose byte order follows from the first letter.

    Outside the rows of numbers, letters and signs such as ² and ° may be in a code page of Windows:
    the one in which most names of a header are known is taken.

    Raises
    ------
    UnreadableInput
        It is not text; the message has the file and the line.
    """
    halves = 4 * data.count(0) > len(data)  # a port may begin with any two bytes
    utf_16 = ("utf-16" if halves and data.startswith((b"\xff\xfe", b"\xfe\xff")) else
              "utf-16-be" if all(data[1:8:2]) and not any(data[:8:2]) else
              "utf-16-le" if all(data[:8:2]) and not any(data[1:8:2]) else "")
    try:
        text = data.decode(utf_16 or "utf-8-sig")
    except UnicodeDecodeError as error:
        text = _in_code_page(data)
        damaged = utf_16 or any(
            not cell.isascii() and not re.search("[A-Za-z]", cell) for line in text.split("\n")
            if not line.isascii() and width_of_numbers(line) >= FEWEST_NUMBERS
            for cell in split_cells(line, delimiter_of(line)))
        if damaged:
            raise _not_text(path, data, error.start) from error
    text = text.rstrip("\0\r\n") + "\n" if "\0" in text else text  # a card's empty blocks
    text = re.sub("\0+", "\0", text)  # a block of them is one gap
    if text.count("\0") > MOST_ZEROS * len(text) or _is_tar(data):
        raise _not_text(path, data, data.index(0))
    text = decimal_numbers(text.replace("\0", "")).replace("\r\n", "\n").replace("\r", "\n")
    return ["", *text.split("\n")]


def _in_code_page(data: bytes) -> str:
    """Text that is not in UTF-8, decoded by the code page in which most of its names are known."""
    head = b"\n".join(line for line in data.split(b"\n", LONGEST_HEAD)[:LONGEST_HEAD]
                      if not line.isascii())  # the others are the same in all of them

    def known(page: str) -> int:
        names = head.decode(page, "ignore").splitlines()
        return max((sum((read_name(UNIT_BEHIND.sub("", cell)).quantity != "")
                        + (read_name(cell).quantity != "") for cell in split_cells(
                            line, delimiter_of(line))) for line in names), default=0)
    return data.decode(max(CODE_PAGES, key=known), "replace")


def decimal_numbers(text: str) -> str:
    """``text`` with registers, Fortran's exponents, an office's minuses and thousands converted.

    Registers of two and four bytes are signed, as inertial sensors deliver them, or numbers of
    IEEE 754.

    >>> decimal_numbers("0x0010 0xFFFE"), decimal_numbers("-0.25D+01")
    ('16 -2', '-0.25E+01')
    >>> decimal_numbers("1200 00A0 F0FE 0A10"), decimal_numbers("1e05 2E05 1000")
    ('1200 160 -3842 2576', '1e05 2E05 1000')
    >>> decimal_numbers("0x10 0x411D0000 0xBF000000 0x80000000")
    '0x10 9.8125 -0.5 -0'
    >>> decimal_numbers('20,FFFFD25B,46,2F\\n40,FFFFD26D,5A,3\\n'), decimal_numbers('"-1,006.7"')
    ('20,-11685,70,47\\n40,-11667,90,3\\n', '"-1006.7"')
    """
    if not text.isascii() or "'" in text:
        text = THOUSANDS.sub("", MINUS.sub("-", text)).translate(DRAWN)
    if '"' in text:
        text = QUOTED_THOUSANDS.sub(lambda number: number[0].replace(",", ""), text)
    if ",(" in text or ";(" in text or "\t(" in text:
        text = IN_BRACKETS.sub(r"-\1", text)
    if "#" in text:
        text = SPREADSHEET_ERROR.sub("nan", text)
    if "np." in text:
        text = NUMPY.sub(r"\1", text)
    text = NO_BLANK.sub(r"\1 ", text)
    shown = text[-SHOWN_LENGTH:]
    words = FOUR_BYTES.findall(shown)
    are_floats = 2 * sum(_float_in(word) is not None for word in words) > len(words)
    value = partial(_value, are_floats=are_floats)
    if "0x" in text or "0X" in text:
        text = REGISTER.sub(lambda register: value(register[0]), text)
    if count := _words_without_prefix(shown):
        text = WORDS.sub(lambda run: _last_converted(run[0], count, value), text)
    return FORTRAN.sub(r"\1E\2", text) if "D+" in text or "D-" in text else text


def _words_without_prefix(text: str) -> int:
    """Number of words at the end of runs that are registers: a tenth or more have digits and
    letters that are no exponent's, which a time before them has not."""
    runs = [re.findall(r"\w+", run)[::-1] for run in WORDS.findall(text) if DIGIT.search(run)]
    shown = [10 * sum(MIXED.fullmatch(word) is not None for word in words) >= len(runs)
             for words in zip_longest(*runs, fillvalue="0")]
    count = [*shown, False].index(False)
    return count if count >= FEWEST_NUMBERS else 0


def _last_converted(run: str, count: int, value: Callable[[str], str]) -> str:
    """A run of words whose last ``count`` are registers."""
    parts = re.split(r"(\W+)", run)
    first = max(len(parts) + 1 - 2 * count, 0)
    parts[first::2] = map(value, parts[first::2])
    return "".join(parts)


def _value(register: str, are_floats: bool) -> str:
    digits = register.lower().removeprefix("0x")
    if are_floats and len(digits) == SIGNED[-1] and (number := _float_in(digits)) is not None:
        return f"{number:.9g}"
    half = 1 << (4 * len(digits) - 1)
    value = int(digits, 16)
    return str(value - 2 * half if value >= half and len(digits) in SIGNED else value)


def _float_in(digits: str) -> float | None:
    """The number of IEEE 754 in four bytes; None if it is none of a sensor."""
    number: float = struct.unpack(">f", bytes.fromhex(digits))[0]
    return number if number == 0 or FLOATS[0] < abs(number) < FLOATS[1] else None


def _is_tar(data: bytes) -> bool:
    return data[TAR_AT : TAR_AT + len(TAR_MAGIC)] == TAR_MAGIC


def _not_text(path: Path, data: bytes, start: int) -> UnreadableInput:
    if _is_tar(data):
        return UnreadableInput(f"{path}: is an archive of tar. Unpack it by `tar xf "
                               f"{word(path.name)}`, and name the files in it.")
    line = data.count(b"\n", 0, start) + 1
    kind = UnreadableInput if start else NoReadings  # a damaged log begins as text
    return kind(
        f"{path}:{line}: byte 0x{data[start]:02x} is not text (UTF-8 is expected). If this is a "
        "log, delete the damaged line or save the file as UTF-8; video and binary logs cannot be "
        "read here."
    )
