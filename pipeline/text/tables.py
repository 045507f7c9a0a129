"""Tables in columns that line up, in the width that a terminal has."""

from collections.abc import Iterator, Sequence

from pipeline.text.wrapping import terminal_columns, wrapped

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
    """A row whose last cell continues under itself."""
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
