"""Text in the width of the terminal: wrapped, and as tables with aligned columns."""

import os
import sys
import textwrap
from collections.abc import Iterator, Sequence

TYPE_CHECKING = False  # `typing` alone takes a tenth of the time of `pipeline --help`
if TYPE_CHECKING:
    from typing import TextIO

WIDEST = 100  #: columns that help and paragraphs use at most
NARROWEST = 40  #: columns that they use at least


def terminal_columns(stream: "TextIO | None" = None) -> int | None:
    """Columns of the terminal behind ``stream`` (default: standard output); None without one.

    ``COLUMNS`` in the environment overrules the terminal's own width. A terminal that reports none
    has no width.
    """
    stream = sys.stdout if stream is None else stream
    try:
        if not stream.isatty():
            return None
        stated = os.environ.get("COLUMNS", "")
        columns = int(stated) if stated.isdecimal() else 0
        columns = columns or os.get_terminal_size(stream.fileno()).columns
    except (OSError, ValueError):  # no terminal; a test's replacement has no file number
        return None
    return max(NARROWEST, columns) if columns else None


def prose_width() -> int | None:
    """Columns that a paragraph on standard output uses; None without a terminal."""
    columns = terminal_columns()
    return None if columns is None else min(columns, WIDEST)


def wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """``text`` in lines of at most ``width`` columns, cut between words only.

    ``indent`` precedes every line but the first.

    >>> wrapped("one two three", 7)
    ['one two', 'three']
    """
    return textwrap.wrap(text, width, subsequent_indent=indent, break_long_words=False,
                         break_on_hyphens=False)


LEAST_TEXT = 24  #: columns in which the wrapped end of a row is still read as text

Rows = Sequence[Sequence[str]]


def table_lines(rows: Rows, indent: str = "  ") -> list[str]:
    """The rows aligned, not wider than the terminal where the output is one."""
    return aligned(rows, indent, terminal_columns())


def aligned(rows: Rows, indent: str = "  ", width: int | None = None) -> list[str]:
    """The rows with every column but the last padded to its width; the first column to the left.

    Where a table is wider than ``width``, the text of its last column is wrapped; if that leaves
    too little, its columns stand in blocks, one under the other, each behind the first column.
    """
    widths = [max(len(row[j]) for row in rows if j < len(row)) for j in range(max(map(len, rows)))]
    if width is None or len(indent) + sum(widths) + 2 * (len(widths) - 1) <= width:
        return [_row(row, widths, indent) for row in rows]
    start = len(indent) + sum(widths[:-1]) + 2 * (len(widths) - 1)
    if width - start >= LEAST_TEXT:
        return [line for row in rows
                for line in _wrapped_row(row, widths, indent, width - start)]
    return [_row([row[j] for j in (0, *block) if j < len(row)], [widths[j] for j in (0, *block)],
                 indent)
            for block in _blocks(widths, width - len(indent))
            for row in rows if any(row[block[0] : block[-1] + 1])]


def _row(row: Sequence[str], widths: Sequence[int], indent: str) -> str:
    padded = (cell.ljust(width) for cell, width in zip(row, widths, strict=False))
    return (indent + "  ".join(padded)).rstrip()


def _wrapped_row(
    row: Sequence[str], widths: Sequence[int], indent: str, room: int
) -> Iterator[str]:
    """A row whose last cell continues below itself."""
    *cells, last = row
    first, *more = wrapped(last, room) if len(row) == len(widths) else [last]
    yield _row([*cells, first], widths, indent)
    yield from (_row([""] * len(cells) + [text], widths, indent) for text in more)


def _blocks(widths: Sequence[int], room: int) -> list[list[int]]:
    """The columns after the first, in groups that fit beside it, at least one in each."""
    blocks: list[list[int]] = []
    length = 0
    for j, width in enumerate(widths[1:], 1):
        if not blocks or length + 2 + width > room:
            blocks.append([])
            length = widths[0]
        blocks[-1].append(j)
        length += 2 + width
    return blocks
