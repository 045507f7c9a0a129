"""Many numbers as text, fast: a million rows of CSV in well under a second.

Python's own formatting takes most of a microsecond a number. Here the digits of all numbers are
looked up at once, four at a time, in a table of the 10 000 possible groups. Numbers stand in
fields of equal width, padded with blanks; the blanks come out at the end.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from calib.poses.imu_log import FloatArray

DIGITS = 4  #: digits that one look-up gives
GROUP = 10**DIGITS  #: derived
MOST_DECIMALS = 2 * DIGITS  #: derived: of two look-ups
LARGEST = 2.0**63  #: size of a number counted in its last decimal
BLOCK_ROWS = 20_000  #: few enough to stay in the processor's cache

Bytes = NDArray[np.uint8]
Integers = NDArray[np.uint64]


def _table(pattern: bytes) -> NDArray[np.uint32]:
    """Four characters for each of the 10 000 groups, as one integer each."""
    return np.frombuffer(b"".join(pattern % n for n in range(GROUP)), dtype=np.uint32)


_ZEROS = _table(b"%04d")  #: 7 -> "0007", behind other digits
_BLANKS = _table(b"%4d")  #: 7 -> "   7", where a number begins


def csv_rows(columns: Sequence[FloatArray], decimals: Sequence[int]) -> Iterator[bytes]:
    """The rows of ``columns`` (t,) each, as lines of comma-separated numbers, block by block.

    Parameters
    ----------
    columns : sequence of array, shape (t,)
        NaN becomes an empty cell.
    decimals : sequence of int
        Digits after the point of each column, at most eight.

    Raises
    ------
    ValueError
        A number is infinite, or :data:`LARGEST` or more in its last decimal.
    """
    for start in range(0, len(columns[0]), BLOCK_ROWS):
        fields: list[Bytes] = []
        for values, d in zip(columns, decimals, strict=True):
            fields += [*_field(values[start : start + BLOCK_ROWS], d), COMMA]
        fields[-1] = LINE_END
        n = len(fields[0])
        table = np.concatenate([np.broadcast_to(f, (n, f.shape[1])) for f in fields], axis=1)
        yield table.tobytes().translate(None, b" ")


COMMA, LINE_END, POINT = (np.array([[ord(sign)]], np.uint8) for sign in ",\n.")


def _field(values: FloatArray, decimals: int) -> list[Bytes]:
    """Sign, digits, point and digits of every number, each (t, width)."""
    assert 0 <= decimals <= MOST_DECIMALS
    absent = np.isnan(values)
    scaled = np.rint(np.where(absent, 0.0, values) * 10.0**decimals)
    largest = float(np.abs(scaled).max(initial=0.0))
    if not largest < LARGEST:
        raise ValueError(f"{largest:g}, in the last decimal, is too large to be written out")
    counted = np.abs(scaled).astype(np.uint64)
    whole = counted // np.uint64(10**decimals)
    sign = np.where(scaled < 0, ord("-"), ord(" ")).astype(np.uint8)[:, None]
    parts = [sign, _whole_digits(whole)]
    if decimals:
        rest = counted - whole * np.uint64(10**decimals)
        parts += [POINT, _decimals(rest, decimals)]
    if not absent.any():
        return parts
    parts = [np.array(np.broadcast_to(part, (len(values), part.shape[1]))) for part in parts]
    for part in parts:
        part[absent] = ord(" ")
    return parts


def _characters(groups: list[NDArray[np.uint32]]) -> Bytes:
    return np.stack(groups, axis=1).view(np.uint8)


def _whole_digits(whole: Integers) -> Bytes:
    """Digits before the point, right-aligned in blanks; zero is ``0``."""
    groups: list[NDArray[np.uint32]] = []
    while True:
        higher = whole // np.uint64(GROUP)
        last = (whole - higher * np.uint64(GROUP)).astype(np.intp)
        first = higher == 0
        digits = np.where(first, _BLANKS[last], _ZEROS[last])
        if groups:  # no digit at all where the number ended in the group behind
            digits = np.where(first & (last == 0), np.uint32(0x20202020), digits)
        groups.append(digits)
        if first.all():
            return _characters(groups[::-1])
        whole = higher


def _decimals(rest: Integers, decimals: int) -> Bytes:
    """Exactly ``decimals`` digits behind the point."""
    count = -(-decimals // DIGITS)
    rest = rest * np.uint64(10 ** (count * DIGITS - decimals))
    groups = []
    for _ in range(count):
        higher = rest // np.uint64(GROUP)
        groups.append(_ZEROS[(rest - higher * np.uint64(GROUP)).astype(np.intp)])
        rest = higher
    return _characters(groups[::-1])[:, :decimals]
