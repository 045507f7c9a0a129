"""The width of the terminal, and text wrapped at it. Imported by the help: nothing slow here."""

import os
import sys

TYPE_CHECKING = False  # `typing` alone takes a tenth of the time of `pipeline --help`
if TYPE_CHECKING:
    from typing import TextIO

WIDEST = 100  #: columns that help and paragraphs use at most
NARROWEST = 40  #: columns that they use at least


def terminal_columns(stream: "TextIO | None" = None) -> int | None:
    """Columns of the terminal behind ``stream`` (default: standard output); None without one.

    ``COLUMNS`` in the environment counts before what the terminal says of itself. A terminal that
    says nothing has no width.
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

    ``indent`` stands before every line but the first. The standard library's ``textwrap`` imports
    ``re``, which takes as long as everything else that ``pipeline --help`` does.

    >>> wrapped("one two three", 7)
    ['one two', 'three']
    """
    lines: list[str] = []
    for word in text.split():
        if lines and len(lines[-1]) + 1 + len(word) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(f"{indent if lines else ''}{word}")
    return lines
