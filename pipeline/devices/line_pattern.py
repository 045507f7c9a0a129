"""Any line format, described by a pattern: ``{time_ms},{acc_x},{acc_y},{acc_z},{skip}``.

Names in braces stand for numbers, everything else for itself; a blank stands for any blanks, or
none, but between two numbers for one blank at least. ``{skip}`` is anything up to the next comma,
semicolon or blank. Times are ``{time_s}``, ``{time_ms}`` or ``{time_us}``, ``{counter}`` counts
samples; further names become columns.
"""

import re
from dataclasses import dataclass

from pipeline.devices.sample import AS_LABELLED, CLOCKS, DeviceClock, Sample, clock_among, sample_of
from pipeline.devices.text_lines import LineReader
from pipeline.logs.columns import SKIP, missing_columns

PLACE = re.compile(r"\{([^{}]*)\}")
NUMBER = r"([-+]?\d{1,12}(?:\.\d{0,12})?(?:[eE][-+]?\d{1,2})?)"
ANYTHING = r"([^,;\s]{0,60})"


@dataclass(frozen=True)
class LinePattern:
    """A pattern of a line, and what it means; ``head`` is the text before its first number."""

    text: str
    names: tuple[str, ...]
    head: re.Pattern[str]
    whole: re.Pattern[str]

    @classmethod
    def of(cls, text: str) -> "LinePattern":
        """Read a pattern."""
        first, *pieces = PLACE.split(text)
        numbers = [ANYTHING if name == SKIP else NUMBER for name in pieces[::2]]
        between = [r"\s+" if piece.isspace() and i < len(numbers) - 1 else _literal(piece)
                   for i, piece in enumerate(pieces[1::2])]
        rest = "".join(number + after for number, after in zip(numbers, between, strict=True))
        return cls(text, tuple(pieces[::2]), re.compile(rf"\s*{_literal(first)}"),
                   re.compile(rf"\s*{_literal(first)}{rest}\s*"))

    @classmethod
    def stated(cls, text: str) -> "LinePattern":
        """Read a pattern that has to describe a whole sample.

        Raises
        ------
        ValueError
            It names no whole triad, a name twice, or two numbers with nothing between them.
        """
        names = tuple(PLACE.findall(text))
        example = "as in '{time_ms},{acc_x},{acc_y},{acc_z},{gyr_x},{gyr_y},{gyr_z}'"
        if wrong := [name for name in names if not re.fullmatch(r"[A-Za-z_]\w*", name)]:
            raise ValueError(f"'{{{wrong[0]}}}' is no name of a column; write names in braces, "
                             f"{example}")
        if "}{" in text:
            raise ValueError(f"nothing separates two of its numbers; write what stands between "
                             f"them, {example}")
        if lacks := missing_columns(names):
            raise ValueError(f"{lacks}; write every number of the line in braces, {example}")
        if sum(name in CLOCKS for name in names) > 1:
            raise ValueError("it names more than one time or counter; keep the finer one and "
                             "write {skip} for the other")
        return cls.of(text)

    def values(self, line: str) -> dict[str, float] | None:
        """The numbers in a line by their names; None where it does not fit."""
        match = self.whole.fullmatch(line)
        return None if match is None else {
            name: float(text) for name, text in zip(self.names, match.groups(), strict=True)
            if name != SKIP}


def _literal(text: str) -> str:
    return "".join(r"\s*" if part.isspace() else re.escape(part)
                   for part in re.split(r"(\s+)", text) if part)


class LinePatternParser:
    """Samples from lines of one pattern; see :class:`pipeline.devices.sample.Parser`."""

    unit = AS_LABELLED

    def __init__(self, pattern: LinePattern) -> None:
        stamp = clock_among(pattern.names)
        self.clock: DeviceClock | None = CLOCKS[stamp][0] if stamp else None
        self._pattern = pattern
        self._lines = LineReader()
        self._damaged = 0
        self._read = 0
        self._last = ""

    @property
    def bad(self) -> int:
        """Lines so far that do not fit the pattern."""
        return self._lines.bad + self._damaged

    @property
    def advice(self) -> str:
        """What to do where no line fits."""
        if self._read or not self._last:
            return ""
        return (f"lines come, but none fits `pattern`; the last is '{self._last[:80]}', the "
                f"pattern '{self._pattern.text}'")

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        return self._samples(self._lines.feed(data))

    def finish(self) -> list[Sample]:
        """The samples that the end of the stream completes."""
        return self._samples(self._lines.finish())

    def _samples(self, lines: list[str]) -> list[Sample]:
        samples = []
        for line in lines:
            values = self._pattern.values(line)
            if values is None:
                self._damaged += bool(line.strip())
                self._last = line
                continue
            self._read += 1
            samples.append(sample_of(values))
        return samples
