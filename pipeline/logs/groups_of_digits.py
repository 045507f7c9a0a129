"""Refusal of tables in which points or commas may separate thousands."""

import re
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import UnreadableInput

#: "16,384" is sixteen or sixteen thousand; a log with only such commas is refused.
MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+")
FEWEST_POINTED = 20
"""Least number of cells with a point, all followed by three digits, in a column that also has cells
without. A judgement: among so many decimals other numbers of digits would occur."""


def require_decimal_commas(path: Path, cells: Sequence[str]) -> None:
    """Refuse a table in which every comma may separate thousands.

    Raises
    ------
    UnreadableInput
    """
    with_comma = [cell for cell in cells if "," in cell]
    if with_comma and all(map(MAYBE_THOUSANDS.fullmatch, with_comma)):
        raise UnreadableInput(
            f"{path}: every comma in its numbers stands before three digits, as in "
            f"'{with_comma[0]}': it may be a decimal comma or separate thousands. Write the file "
            "with decimal points."
        )


def require_no_thousands(path: Path, rows: Sequence[Sequence[str]]) -> None:
    """Refuse rows with a column in which points separate thousands: ``16.384`` and ``512``.

    Raises
    ------
    UnreadableInput
    """
    for cells in zip(*rows, strict=True):
        pointed = [cell for cell in cells if "." in cell]
        if (FEWEST_POINTED <= len(pointed) < len(cells) and all(map(THOUSANDS.fullmatch, pointed))
                and any(cell.strip("+-0").isdigit() for cell in cells)):
            raise UnreadableInput(
                f"{path}: points separate the thousands of its numbers, as in '{pointed[0]}' "
                "beside whole numbers without any. Write the numbers without separators.")
