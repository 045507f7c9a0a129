"""Many numbers as text, fast: a million rows of CSV in about a second.

Python's own formatting takes most of a microsecond a number. Here every number becomes an integer
of its last decimal, and all of them are turned into digits at once, four at a time, by a table of
the 10 000 possible groups. Numbers stand in fields of equal width; blanks come out at the end.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from calib.imu_log import FloatArray

GROUP = 4  #: digits that one look-up gives
LARGEST = 10 ** (4 * GROUP) - 1  #: of the integers: sixteen digits, what a float holds
BLOCK_ROWS = 50_000  #: few enough to stay in the processor's cache

_GROUPS = np.array(
    [list(b"%04d" % n) for n in range(10**GROUP)], dtype=np.uint8
).reshape(-1, GROUP)


def csv_rows(columns: Sequence[FloatArray], decimals: Sequence[int]) -> Iterator[bytes]:
    """The rows of ``columns`` (t,) each, as lines of comma-separated numbers, block by block.

    Parameters
    ----------
    columns : sequence of array, shape (t,)
        NaN becomes an empty cell.
    decimals : sequence of int
        Digits after the point of each column.

    Raises
    ------
    ValueError
        A number needs more than sixteen digits.
    """
    for start in range(0, len(columns[0]), BLOCK_ROWS):
        part = slice(start, start + BLOCK_ROWS)
        fields = [_field(values[part], d) for values, d in zip(columns, decimals, strict=True)]
        for field in fields[:-1]:
            field[:, -1] = ord(",")
        fields[-1][:, -1] = ord("\n")
        yield np.concatenate(fields, axis=1).tobytes().replace(b" ", b"")


def _field(values: FloatArray, decimals: int) -> NDArray[np.uint8]:
    """Each number right-aligned in blanks, with a place for the separator behind, (t, width)."""
    absent = np.isnan(values)
    scaled = np.rint(np.where(absent, 0.0, values) * 10.0**decimals)
    largest = float(np.abs(scaled).max(initial=0.0))
    if not largest <= LARGEST:
        raise ValueError(f"{largest:g} needs more than {4 * GROUP} digits")
    whole = np.abs(scaled).astype(np.int64)
    digits = _digits(whole, max(len(str(int(largest))), decimals + 1))
    places = digits.shape[1]
    # How many digits stand for the number: one before the point at least.
    needed = np.full(len(values), decimals + 1)
    for k in range(decimals + 1, places):
        needed += whole >= 10**k
    digits[np.arange(places) < places - needed[:, None]] = ord(" ")
    sign = np.where(scaled < 0, ord("-"), ord(" ")).astype(np.uint8)[:, None]
    point = np.full((len(values), 1 if decimals else 0), ord("."), np.uint8)
    end = np.full((len(values), 1), ord(" "), np.uint8)
    cut = places - decimals
    field = np.concatenate([sign, digits[:, :cut], point, digits[:, cut:], end], axis=1)
    field[absent] = ord(" ")
    return field


def _digits(whole: NDArray[np.int64], count: int) -> NDArray[np.uint8]:
    """The last ``count`` or more decimal digits of each integer, shape (t, a multiple of 4)."""
    groups = []
    for _ in range(-(-count // GROUP)):
        whole, last = np.divmod(whole, 10**GROUP)
        groups.append(_GROUPS[last])
    return np.concatenate(groups[::-1], axis=1)
