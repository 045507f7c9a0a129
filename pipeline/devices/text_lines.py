"""Lines of text out of a byte stream that may hold anything."""

LONGEST_LINE = 1000  #: bytes; longer than the header of any logger met, and no line has no end


class LineReader:
    """Splits a stream into lines; what stands before the first line end is half a line.

    Attributes
    ----------
    bad : int
        Lines that were no text, or too long.
    """

    def __init__(self) -> None:
        self.bad = 0
        self._rest = bytearray()
        self._discard = True

    def feed(self, data: bytes) -> list[str]:
        """The whole lines that ``data`` completes, without their ends."""
        *ended, rest = (bytes(self._rest) + data).split(b"\n")
        lines = [line for piece in ended if (line := self._line(piece)) is not None]
        if len(rest) > LONGEST_LINE:
            self.bad += not self._discard
            self._discard, rest = True, b""
        self._rest = bytearray(rest)
        return lines

    def finish(self) -> list[str]:
        """The last line, where it has no end."""
        rest, self._rest = bytes(self._rest), bytearray()
        line = self._line(rest) if rest else None
        return [] if line is None else [line]

    def _line(self, piece: bytes) -> str | None:
        if self._discard:  # the end of a line whose beginning is not there
            self._discard = False
            return None
        text = piece.decode("latin-1").rstrip("\r\0")
        if len(piece) > LONGEST_LINE or not (text.isascii() and _printable(text)):
            self.bad += 1
            return None
        return text


def _printable(text: str) -> bool:
    return text.replace("\t", " ").isprintable()
