"""Reasons why a text of numbers is not a table of samples, with the way to make one.

Each is the end of a sentence that names the file; empty if there is none.
"""

import re
from collections.abc import Sequence
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from calib.poses.imu_log import AXES
from pipeline.logs.dialect import SHOWN, delimiter_of, split_cells
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.head import find_head, width_of_numbers
from pipeline.logs.header_words import read_name
from pipeline.logs.row_kinds import MOST_KINDS
from pipeline.logs.sentences import LIST
from pipeline.logs.text import LogText
from pipeline.text.names import word

LONGEST_CHANNELS = 4
"""Ratio of the cells of a row to the number of rows above which each row is a channel. A judgement:
a log has more samples than columns, and 60 columns at most."""
BYTES = re.compile(
    r"#(?:[0-9A-Fa-f]{2}){3,}(?!\w)"
    r"|(?<![\w.])(?=(?:\d{2}[ :-])*(?:[A-Fa-f]\d|\d[A-Fa-f]|[A-Fa-f]{2})[ :-])"
    r"(?:[0-9A-Fa-f]{2}[ -]){5,}[0-9A-Fa-f]{2}(?!\w)(?!.*::)"
    r"|\b0x[0-9A-Fa-f]{2}[ ,;\t]+0x[0-9A-Fa-f]{2}\b")
NOT_LINES_OF_NUMBERS = (
    (re.compile(r"\b0x[0-9A-Fa-f]{2}\b|^[A-Za-z0-9+/]{12,}={0,2}$"),
     "its lines are the bytes of a bus, one by one, or bytes in letters, as base64 writes them. "
     "Decode them first, by the data sheet or an analyser's script for the sensor, and import the "
     "table that comes of it"),
    (re.compile(r"^\s*<.*>\s*$"),
     "it is XML or HTML. Open it in a spreadsheet or a browser, and save the table as CSV"),
)
"""Patterns of lines that are not rows of numbers, and advice on each. Facts."""
FACTOR = re.compile(r"\s*(\d+\.?\d*[eE][+-]\d+)\s*\*\s*")
"""A factor above a matrix, as MATLAB shows one: ``1.0e+03 *``."""
WHOLE = re.compile(r"[+-]?\d+")
LONGEST_SHOWN = 60  #: letters of a line in a message; of text
FEWEST_CARRIES = 3
"""Least number of rows in which one of two columns of 0 to 255 overflows and the other counts that:
two bytes of one number. A judgement: a sensor of eight bits does so by chance once in 256."""


def fault_of_lines(lines: Sequence[str]) -> str:
    """Lines of bytes, of which some look like numbers, or cells with a list of samples in each."""
    if _are_mostly(lines, BYTES):
        return ("its lines are messages of a bus or a port, with their bytes in hexadecimal. The "
                "description of the device says what they mean. Decode them first, those of a CAN "
                "bus for example by `cantools decode`, and import the table that comes of it")
    rows = [LIST.findall(line) for line in lines[len(lines) // 2 :][:SHOWN]]
    full = next((cells for cells in rows if len(cells) >= len(AXES)), None)
    if full and sum(len(cells) == len(full) for cells in rows) > len(rows) / 2:
        return (f"{len(full)} cells of each row hold {full[0].count('|') + 1} numbers each, as "
                f"'{full[0][:LONGEST_SHOWN]}': a row is several samples. Write a row for each "
                f"sample, for example by `explode()` in pandas")
    return ""


def fault_of_columns(table: FileTable) -> str:
    """A table with far more columns than rows."""
    rows = max((len(values) for values in table.columns.values()), default=1)
    if len(table.columns) <= LONGEST_CHANNELS * rows:
        return ""
    shown = ", ".join(list(table.columns)[: len(AXES)])
    return (f"it has {len(table.columns)} columns ({shown}, ...) and hardly a row: its samples "
            f"stand beside each other. Write a row for each sample")


def _are_mostly(lines: Sequence[str], manner: re.Pattern[str]) -> bool:
    shown = [line for line in lines[-SHOWN:] if line.strip()]
    return sum(manner.search(line) is not None for line in shown) > len(shown) / 2


def why_no_table(lines: Sequence[str], beside: Sequence[Path] = ()) -> str:
    """Why no line of a text, imported ``beside`` others, is a row of readings."""
    for manner, what in NOT_LINES_OF_NUMBERS:
        if _are_mostly(lines, manner):
            return what
    shown = [line for line in lines[-SHOWN:] if line.strip()]
    last = shown[-1].strip()[:LONGEST_SHOWN] if shown else ""
    axes = beside if len(beside) >= len(AXES) else [Path(f"{axis}.csv") for axis in AXES]
    if len(shown) > MOST_KINDS and 0 < width_of_numbers(shown[-1]) < len(AXES):
        return (
            f"each row holds one value, as '{last}', and the axes of a sensor are expected beside "
            f"each other. If each has its file, put them together and import that: by "
            f"`paste -d '{delimiter_of(shown[-1]) or ','}' {' '.join(map(word, axes))} >log.csv` "
            f"if their rows have the same times, else by `pandas.merge_asof()` over these. If each "
            f"row names its axis, bring the names into the header, as `pivot()` does in pandas")
    return (f"its lines are no rows of three numbers in one form; the last one is '{last}'. Is it "
            f"a log? Readings are expected as a table, one row for each sample, as in "
            f"`time_s,acc_x,acc_y,acc_z`")


def fault_of_rows(text: LogText) -> str:
    """A printed matrix with a factor above it, rows that are channels, decimal commas between
    commas, or columns of bytes."""
    factor = next(filter(None, map(FACTOR.fullmatch, text.lines[: text.first])), None)
    if factor is not None:
        return (f"the numbers are to be multiplied by {factor[1]}, which stands above them, and "
                f"have lost digits so. Save the matrix itself, in MATLAB for example by "
                f"`writematrix(m, 'log.csv')`, and import that")
    rows = [split_cells(line, delimiter_of(line)) for line in islice(text.lines, SHOWN)]
    rows = [row for row in rows if row]
    named = [row[0] for row in rows if read_name(row[0]).quantity in ("acc", "gyr")]
    if len(named) >= len(AXES) and min(map(len, rows)) > LONGEST_CHANNELS * len(rows):
        return (f"each row is a channel ({', '.join(named)}) with its samples beside each other. "
                f"Transpose it to a row for each sample, for example in Python: `pandas.read_csv("
                f"{text.path.name!r}, header=None, index_col=0).T.to_csv('samples.csv', "
                f"index=False)`")
    header = find_head(text.lines).names or ()
    wide = [row for row in rows if len(row) >= 2 * len(header) - 1 > len(AXES)]
    if 2 * len(wide) > len(rows) and all(WHOLE.fullmatch(cell) for row in wide for cell in row):
        return (f"its numbers have decimal commas, and commas stand between them too, as in "
                f"'{','.join(wide[0])[:LONGEST_SHOWN]}'. Save it with semicolons between the "
                f"columns, or with decimal points")
    columns = zip(*(row for row in rows if len(row) == len(text.names)), strict=True)
    pair = next((names for names, cells in zip(pairwise(text.names), pairwise(columns), strict=True)
                 if _are_bytes(*cells)), None)
    return "" if pair is None else (
        f"{pair[0]} and {pair[1]} are the high and the low byte of one number, and others may be "
        f"too. Write each pair as one number, 256 times the high byte plus the low one, and 65536 "
        f"less from 32768 on")


def _are_bytes(one: Sequence[str], other: Sequence[str]) -> bool:
    """Whether two columns are the bytes of one number, in either order."""
    values = [pair for pair in zip(one, other, strict=True) if all(map(str.isdigit, pair))]
    steps = np.diff(np.array([*values, (0, 0)], float), axis=0)[:-1].T
    able = max((int(value) for pair in values for value in pair), default=0) < 256
    carries = [(np.abs(low) > 128, (high + np.sign(low)) % 256 == 0)
               for high, low in (steps, steps[::-1]) if able]
    return any((over & counted).sum() > max(FEWEST_CARRIES - 1, over.sum() / 2)
               for over, counted in carries)
