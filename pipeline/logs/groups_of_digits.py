"""Tables in which points or commas may separate thousands, which are refused."""

import re
from collections.abc import Sequence

#: "16,384" is sixteen or sixteen thousand; a log with only such commas is refused.
MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+")
FEWEST_POINTED = 20
"""Least number of cells with a point, all followed by three digits, in a column that also has cells
without. A judgement: among so many decimals other numbers of digits would occur."""


def of_commas(cells: Sequence[str]) -> str:
    """The fault of a table in which every comma may separate thousands; empty for none."""
    with_comma = [cell for cell in cells if "," in cell]
    if not with_comma or not all(map(MAYBE_THOUSANDS.fullmatch, with_comma)):
        return ""
    return (f"every comma in its numbers stands before three digits, as in '{with_comma[0]}': it "
            f"may be a decimal comma or separate thousands. Write the file with decimal points.")


def of_points(rows: Sequence[Sequence[str]]) -> str:
    """The fault of rows with a column in which points separate thousands: ``16.384`` and ``512``;
    empty for none."""
    for cells in zip(*rows, strict=True):
        pointed = [cell for cell in cells if "." in cell]
        if (FEWEST_POINTED <= len(pointed) < len(cells) and all(map(THOUSANDS.fullmatch, pointed))
                and any(cell.strip("+-0").isdigit() for cell in cells)):
            return (f"points separate the thousands of its numbers, as in '{pointed[0]}' beside "
                    f"whole numbers without any. Write the numbers without separators.")
    return ""
