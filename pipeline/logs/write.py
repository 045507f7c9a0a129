"""Conversion of columns of numbers to rows of text."""

from collections.abc import Iterator, Sequence

import numpy as np

from calib.poses.imu_log import FloatArray

LARGEST = 2.0**63  #: limit of a number in units of its last decimal
BLOCK_ROWS = 20_000  #: number of rows that are formatted at once, a few megabytes of text


def csv_rows(columns: Sequence[FloatArray], decimals: Sequence[int]) -> Iterator[bytes]:
    """The rows of ``columns``, each (t,), as lines of comma-separated numbers, block by block.

    Parameters
    ----------
    columns : sequence of array, shape (t,)
        NaN becomes an empty cell.
    decimals : sequence of int
        Digits after the point of each column.

    Raises
    ------
    ValueError
        A number is infinite, or :data:`LARGEST` or more in its last decimal.
    """
    line = ",".join(f"%.{digits}f" for digits in decimals) + "\n"
    for start in range(0, len(columns[0]), BLOCK_ROWS):
        block = np.column_stack([values[start : start + BLOCK_ROWS] for values in columns])
        largest = float(np.nanmax(np.abs(block) * 10.0 ** np.array(decimals), initial=0.0))
        if not largest < LARGEST:
            raise ValueError(f"{largest:g}, in the last decimal, is too large to be written out")
        # A number that rounds to zero has no sign.
        block[np.abs(block) * 10.0 ** np.array(decimals) <= 0.5] = 0.0
        text = line * len(block) % tuple(block.ravel().tolist())
        yield text.replace("nan", "").encode()
