"""Standard output and error of the commands.

Names, headers and units come from files, so the printed text may contain anything: control
characters are shown, never sent. The commands' own colours are not part of a text: they are given
separately (``write_between``). A reader that goes away (``| head``) never stops a command, and a
character that the terminal's encoding lacks is replaced. On a terminal, lines longer than its width
are cut between words; output for programs is never cut.
"""

import io
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from pipeline.text.plain import HIDDEN, escape
from pipeline.text.tables import terminal_columns

#: What is hidden or acts, but new line and tab.
ACTING = re.compile(rf"[\n\t]|({HIDDEN.pattern})")
#: A line to be copied whole: a command, after the word that announces it.
COMMAND = re.compile(r"\s*(?:.*: )?pipeline ")
#: The title of a line, and the blanks before its text: further lines begin under the text.
TITLE = re.compile(r"(?:\S+ )*\S+ {2,}")
FURTHER = 4  #: columns, of the further lines of an indented one
DEEPEST = 0.4  #: share of the width that the beginning of further lines may take


def visible(text: str) -> str:
    r"""``text`` with its control characters written out.

    >>> visible("a\x1b[2Jb")
    'a\\x1b[2Jb'
    """
    return ACTING.sub(lambda match: escape(match[1]) if match[1] else match[0], text)


def cut_between_words(line: str, columns: int) -> str:
    """``line`` in as many lines as ``columns`` need; commands and names of files stay whole.

    >>> print(cut_between_words("logs            36 poses averaged", 30))
    logs            36 poses
                averaged
    """
    if len(line) <= columns or COMMAND.match(line) or os.path.lexists(line):
        return line
    title = TITLE.match(line)
    start = title.end() if title else FURTHER * line.startswith(" ")
    indent = min(start, int(DEEPEST * columns))
    lines, length = [""], 0
    for blanks, word in re.findall(r"(\s*)(\S+)", line):
        size = len(word)
        if length and length + len(blanks) + size > columns:
            lines.append(" " * indent)
            blanks, length = "", indent
        lines[-1] += blanks + word
        length += len(blanks) + size
    return "\n".join(lines)


class ShownStream:
    """A text stream whose control characters are shown and whose reader may go away.

    ``raw`` is the stream behind it, which handles everything but writing; ``fault`` is the error
    that ended writing, unless the reader left.
    """

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw
        self.fault: OSError | None = None
        self._gone = False
        if isinstance(raw, io.TextIOWrapper):
            raw.reconfigure(errors="replace")

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)

    def write(self, text: str) -> int:
        """Write ``text``; nothing happens once the reader has gone."""
        self._send(self._shown(text))
        return len(text)

    def write_between(self, before: str, text: str, after: str) -> None:
        """Write ``text`` between two sequences of the commands' own, which are sent as they are."""
        self._send(before + self._shown(text) + after)

    def _shown(self, text: str) -> str:
        clean = visible(text)
        columns = terminal_columns(self.raw)
        if columns is None:
            return clean
        return "\n".join(cut_between_words(line, columns) for line in clean.split("\n"))

    def _send(self, text: str) -> None:
        self._attempt(lambda: self.raw.write(text))

    def _attempt(self, act: Callable[[], object]) -> None:
        if not self._gone:
            try:
                act()
            except OSError as error:
                self._give_up(error)

    def write_bytes(self, data: bytes) -> None:
        """Write UTF-8 text as bytes, no line cut; as text on a terminal."""
        raw = getattr(self.raw, "buffer", None)
        if raw is None or self.raw.isatty():
            self._send(visible(data.decode(errors="replace")))
            return
        self.flush()
        self._attempt(lambda: raw.write(data))

    def flush(self) -> None:
        """Flush the buffer."""
        self._attempt(self.raw.flush)

    def _give_up(self, error: OSError) -> None:
        self._gone = True
        if not isinstance(error, BrokenPipeError):
            self.fault = error
        try:  # the rest of the buffer is discarded, also at the interpreter's end
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.raw.fileno())
            os.close(nowhere)
        except (OSError, io.UnsupportedOperation):
            pass


@contextmanager
def shown_streams() -> Iterator[ShownStream]:
    """Standard output and error through :class:`ShownStream`; gives the wrapped output."""
    out, err = sys.stdout, sys.stderr
    stream = ShownStream(out)
    sys.stdout, sys.stderr = cast(TextIO, stream), cast(TextIO, ShownStream(err))
    try:
        yield stream
    finally:
        try:
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            sys.stdout, sys.stderr = out, err


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """SIGTERM ends a command as Ctrl-C does: files are finished, the cursor is restored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
