"""Rows of plain decimal numbers, read all at once: twice as fast as the general parser.

Loggers write every column with a fixed number of decimals. The cells of a column are then integers
with a point at a known place, and their digits can be added up for thousands of cells at a time,
from the last digit to the first. Whatever is not that plain is left to the general parser, which
also says what is wrong with it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calib.poses.imu_log import FloatArray

BLOCK_ROWS = 20_000  #: few enough to stay in the processor's cache
MOST_DIGITS = 15  #: that a float holds exactly
ZERO, MINUS, POINT, LINE_END = (ord(sign) for sign in "0-.\n")

Bytes = NDArray[np.uint8]
Places = NDArray[np.intp]


def read_plain(lines: Sequence[str], delimiter: str | None, columns: int) -> FloatArray | None:
    """The numbers in ``lines``, shape (t, columns); None where a cell is not a plain number.

    Parameters
    ----------
    lines : sequence of str
        Rows without line ends; empty ones only after the last.
    delimiter : str or None
        One character; None (any blanks) is not plain.
    columns : int
        Cells in a row.
    """
    text = "\n".join(lines).rstrip("\n") + "\n"
    if delimiter is None or len(delimiter) != 1 or not text.isascii():
        return None
    characters = np.frombuffer(text.encode(), np.uint8)
    ends = np.flatnonzero((characters == ord(delimiter)) | (characters == LINE_END))
    if len(ends) % columns:
        return None
    is_line_end = (characters[ends] == LINE_END).reshape(-1, columns)
    if not is_line_end[:, -1].all() or is_line_end[:, :-1].any():
        return None
    starts = np.concatenate([[0], ends[:-1] + 1])
    table = np.empty((len(ends) // columns, columns))
    for first in range(0, len(table), BLOCK_ROWS):
        block = slice(first * columns, (first + BLOCK_ROWS) * columns)
        for j in range(columns):
            cells = slice(block.start + j, block.stop, columns)
            values = _column(characters, starts[cells], ends[cells])
            if values is None:
                return None
            table[first : first + BLOCK_ROWS, j] = values
    return table


def _column(characters: Bytes, start: Places, end: Places) -> FloatArray | None:
    """The numbers between ``start`` and ``end`` (t,), all with as many decimals as the first."""
    if (end <= start).any():
        return None
    negative = characters[start] == MINUS
    width = end - start - negative
    head = characters[start[0] : end[0]].tobytes()
    point = head.find(b".")
    decimals = 0 if point < 0 else len(head) - 1 - point
    fewest = decimals + 2 if decimals else 1  # a digit before the point, where there is one
    if width.min() < fewest or width.max() > MOST_DIGITS or head.endswith(b"."):
        return None
    value = np.zeros(len(start), np.int64)
    power = 1
    for k in range(int(width.max())):
        there = k < width
        # A cell that is shorter than others reads on in the cell before it; that is masked out.
        character = characters[end - 1 - k]
        if decimals and k == decimals:
            if not (character[there] == POINT).all():
                return None
            continue
        digit = character - np.uint8(ZERO)  # wraps round to large values below "0"
        if not ((digit < 10) | ~there).all():
            return None
        value += np.where(there, digit, 0).astype(np.int64) * power
        power *= 10
    return np.where(negative, -value, value) / 10.0**decimals
