"""Refusal of texts of numbers that are not a table of samples, with the way to make one."""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import islice, pairwise
from pathlib import Path

from calib.poses.imu_log import AXES
from pipeline.errors import UnreadableInput
from pipeline.logs.dialect import delimiter_of, split_cells
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.head import width_of_numbers
from pipeline.logs.header_words import read_name
from pipeline.logs.sentence_names import COLOURS, SLOT
from pipeline.logs.sentences import LIST
from pipeline.logs.text import LogText
from pipeline.text.names import word

EVENTS = 200  #: rows that show whether a file is a list of events
MOST_KINDS = 12  #: largest number of sensors: those of a phone
LONGEST_CHANNELS = 4
"""Ratio of the cells of a row to the number of rows above which each row is a channel. A judgement:
a log has more samples than columns, and 60 columns at most."""
NOT_LINES_OF_NUMBERS = (
    (re.compile(r"#(?:[0-9A-Fa-f]{2}){3,}(?!\w)"
                r"|(?<![\w.])(?=(?:\d{2}[ :-])*(?:[A-Fa-f]\d|\d[A-Fa-f]|[A-Fa-f]{2})[ :-])"
                r"(?:[0-9A-Fa-f]{2}[ -]){5,}[0-9A-Fa-f]{2}(?!\w)(?!.*::)"
                r"|\b0x[0-9A-Fa-f]{2}[ ,;\t]+0x[0-9A-Fa-f]{2}\b"),
     "its lines are messages of a bus or a port, with their bytes in hexadecimal. The description "
     "of the device says what they mean. Decode them first, those of a CAN bus for example by "
     "`cantools decode`, and import the table that comes of it"),
    (re.compile(r"\b0x[0-9A-Fa-f]{2}\b"),
     "its lines are the bytes of a bus, one by one. Decode them first, by the data sheet or an "
     "analyser's script for the sensor, and import the table that comes of it"),
    (re.compile(r"^[A-Za-z0-9+/]{12,}={0,2}$"),
     "its lines are bytes in letters, as base64 writes them. Decode them first, and import the "
     "table that comes of it"),
    (re.compile(r"^\s*<.*>\s*$"),
     "it is XML or HTML. Open it in a spreadsheet or a browser, and save the table as CSV"),
)
"""Patterns of lines that are not rows of numbers, and advice on each. Facts."""
FACTOR = re.compile(r"\s*(\d+\.?\d*[eE][+-]\d+)\s*\*\s*")
"""A factor above a matrix, as MATLAB shows one: ``1.0e+03 *``."""
LONGEST_SHOWN = 60  #: letters of a line in a message; of text
BYTE = re.compile(r"(.*?)[ _.]?(h|l|hi|lo|high|low|msb|lsb)", re.IGNORECASE)
"""Name of a column with one byte of a number: ``AXH``, ``acc_x_lsb``."""


def require_numbers_in_cells(path: Path, lines: Sequence[str]) -> None:
    """Refuse rows in which each of several cells holds a list of samples.

    Raises
    ------
    UnreadableInput
    """
    rows = [LIST.findall(line) for line in lines[len(lines) // 2 :][:EVENTS]]
    full = next((cells for cells in rows if len(cells) >= len(AXES)), None)
    if full and sum(len(cells) == len(full) for cells in rows) > len(rows) / 2:
        raise UnreadableInput(
            f"{path}: {len(full)} cells of each row hold {full[0].count('|') + 1} numbers each, as "
            f"'{full[0][:LONGEST_SHOWN]}': a row is several samples. Write a row for each sample, "
            f"for example by `explode()` in pandas.")


def with_samples_in_rows(path: Path, tables: Sequence[FileTable]) -> list[FileTable]:
    """The tables without those that have far more columns than rows.

    Raises
    ------
    UnreadableInput
        All tables have.
    """
    able = [table for table in tables if not table.columns
            or len(table.columns) <= LONGEST_CHANNELS * len(next(iter(table.columns.values())))]
    if tables and not able:
        shown = ", ".join(list(tables[0].columns)[: len(AXES)])
        raise UnreadableInput(
            f"{path}: it has {len(tables[0].columns)} columns ({shown}, ...) and hardly a row: its "
            f"samples stand beside each other. Write a row for each sample.")
    return able


def require_no_bytes(path: Path, lines: Sequence[str]) -> None:
    """Refuse lines of bytes in hexadecimal, of which some look like numbers.

    Raises
    ------
    UnreadableInput
    """
    manner, what = NOT_LINES_OF_NUMBERS[0]
    if _are_mostly(lines, manner):
        raise UnreadableInput(f"{path}: {what}.")


def _are_mostly(lines: Sequence[str], manner: re.Pattern[str]) -> bool:
    shown = [line for line in lines[-EVENTS:] if line.strip()]
    return sum(manner.search(line) is not None for line in shown) > len(shown) / 2


def no_table(path: Path, lines: Sequence[str], beside: Sequence[Path] = ()) -> UnreadableInput:
    """The error for a text, imported ``beside`` others, in which no line is a row of readings."""
    _require_one_row_a_sample(path, lines)
    for manner, what in NOT_LINES_OF_NUMBERS:
        if _are_mostly(lines, manner):
            return UnreadableInput(f"{path}: {what}.")
    shown = [line for line in lines[-EVENTS:] if line.strip()]
    last = shown[-1].strip()[:LONGEST_SHOWN] if shown else ""
    axes = beside if len(beside) >= len(AXES) else [Path(f"{axis}.csv") for axis in AXES]
    if len(shown) > MOST_KINDS and 0 < width_of_numbers(shown[-1]) < len(AXES):
        return UnreadableInput(
            f"{path}: each row holds one value, as '{last}', and the axes of a sensor are expected "
            f"beside each other. If each has its file, put them together and import that: by "
            f"`paste -d '{delimiter_of(shown[-1]) or ','}' {' '.join(map(word, axes))} >log.csv` "
            f"if their rows have the same times, else by `pandas.merge_asof()` over these.")
    of_numbers = [line.lstrip("#! ") for line in shown if len(SLOT.findall(line)) >= len(AXES)]
    if 2 * len(of_numbers) > len(shown):
        samples = " and ".join(f"'{line[:LONGEST_SHOWN]}'" for line in of_numbers[-2:])
        return UnreadableInput(
            f"{path}: its lines of numbers have no common form, as {samples}. Write a row for each "
            f"sample, as in `time_s,acc_x,acc_y,acc_z`, or keep the lines of one sensor by `grep`.")
    return UnreadableInput(
        f"{path}: no line holds three numbers; the last one is '{last}'. Is it a log? Readings are "
        f"expected as a table, one row for each sample, as in `time_s,acc_x,acc_y,acc_z`.")


def require_samples(text: LogText) -> None:
    """Refuse tables whose rows are not samples.

    Raises
    ------
    UnreadableInput
        Its rows are channels, or its columns are single bytes.
    """
    _require_no_factor(text)
    _require_samples_in_rows(text)
    _require_whole_numbers(text)


def _require_no_factor(text: LogText) -> None:
    """Refuse a printed matrix, which has few digits and a factor above it."""
    factor = next(filter(None, map(FACTOR.fullmatch, text.lines[: text.first])), None)
    if factor is not None:
        raise UnreadableInput(
            f"{text.path}: the numbers are to be multiplied by {factor[1]}, which stands above "
            f"them, and have lost digits so. Save the matrix itself, in MATLAB for example by "
            f"`writematrix(m, 'log.csv')`, and import that.")


def _require_samples_in_rows(text: LogText) -> None:
    """Refuse rows that are channels, with their samples side by side."""
    rows = [split_cells(line, delimiter_of(line)) for line in islice(text.lines, EVENTS)]
    rows = [row for row in rows if row]
    named = [row[0] for row in rows if read_name(row[0]).quantity in ("acc", "gyr")]
    if len(named) >= 3 and min(map(len, rows)) > LONGEST_CHANNELS * len(rows):
        raise UnreadableInput(
            f"{text.path}: each row is a channel ({', '.join(named)}) with its samples beside each "
            f"other. Transpose it to a row for each sample, for example in Python: "
            f"`pandas.read_csv({text.path.name!r}, header=None, index_col=0).T.to_csv('samples.csv'"
            f", index=False)`.")


def _require_whole_numbers(text: LogText) -> None:
    """Refuse numbers whose two bytes are in two columns."""
    parts = [BYTE.fullmatch(name) for name in text.names]
    pairs = [one[1] for one, other in pairwise(parts)
             if one and other and one[1] == other[1] and one[2][0].lower() != other[2][0].lower()]
    if len(pairs) >= 3:
        raise UnreadableInput(
            f"{text.path}: {', '.join(pairs)} stand in two columns each, a high and a low byte. "
            f"Write them as one number, 256 times the high byte plus the low one, and 65536 less "
            f"from 32768 on.")


def _require_one_row_a_sample(path: Path, lines: Sequence[str]) -> None:
    """Refuse rows with one value and its name, whose times do not make them samples."""
    every = [line for line in lines if line.strip()]
    shown = every[:: 1 + len(every) // EVENTS]
    texts = Counter(SLOT.sub("#", COLOURS.sub("", line)) for line in shown)
    called = [text for text in texts if any(read_name(part).quantity in ("acc", "gyr")
                                            for part in re.split(r"['\":=#,;\t]", text))]
    if called and len(texts) <= MOST_KINDS:
        raise UnreadableInput(
            f"{path}: each line holds one value, as '{called[0].strip()[:LONGEST_SHOWN]}'. Have "
            f"the logger write the six values of a sample into one line, or bring the names into "
            f"the header, as `pivot()` does in InfluxDB, pandas and SQL.")
