"""Any line format, described by a pattern: ``{time_ms},{acc_x},{acc_y},{acc_z},{skip}``.

Names in braces stand for numbers, everything else for itself; a blank stands for any blanks, or
none. ``{skip}`` is anything up to the next comma, semicolon or blank. Times are ``{time_s}``,
``{time_ms}`` or ``{time_us}``, ``{counter}`` counts samples; further names become columns.
"""

import re
from dataclasses import dataclass

from pipeline.devices.sample import AS_LABELLED, NOT_SENT, DeviceClock, Sample
from pipeline.devices.text_dialects import CLOCKS
from pipeline.devices.text_lines import LineReader
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, SKIP, missing_columns

PLACE = re.compile(r"\{([^{}]*)\}")
NUMBER = r"([-+]?\d{1,12}(?:\.\d{0,12})?(?:[eE][-+]?\d{1,2})?)"
ANYTHING = r"([^,;\s]{0,60})"


@dataclass(frozen=True)
class LinePattern:
    """A pattern as the configuration states it, and what it means."""

    text: str
    names: tuple[str, ...]
    expression: re.Pattern[str]

    @classmethod
    def of(cls, text: str) -> "LinePattern":
        """Read a pattern.

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
        pieces = PLACE.split(text)
        expression = "".join(
            (ANYTHING if piece == SKIP else NUMBER) if i % 2 else _literal(piece)
            for i, piece in enumerate(pieces)
        )
        return cls(text, names, re.compile(rf"\s*{expression}\s*"))


def _literal(text: str) -> str:
    return "".join(r"\s*" if part.isspace() else re.escape(part)
                   for part in re.split(r"(\s+)", text) if part)


class LinePatternParser:
    """Samples from lines of one pattern; see :class:`pipeline.devices.sample.Parser`."""

    unit = AS_LABELLED

    def __init__(self, pattern: LinePattern, from_start: bool = False) -> None:
        self.clock: DeviceClock | None = None
        self._factor = 1.0
        for name in pattern.names:
            if name in CLOCKS:
                self.clock, self._factor = CLOCKS[name]
        self._pattern = pattern
        self._lines = LineReader(from_start)
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
            match = self._pattern.expression.fullmatch(line)
            if match is None:
                self._damaged += bool(line.strip())
                self._last = line
                continue
            self._read += 1
            values = {name: float(text) for name, text in
                      zip(self._pattern.names, match.groups(), strict=True) if name != SKIP}
            stamp = next((name for name in CLOCKS if name in values), None)
            ticks = None if stamp is None else round(values.pop(stamp) * self._factor)
            triads = [tuple(values.pop(name) for name in triad) if triad[0] in values else NOT_SENT
                      for triad in (ACCELEROMETER, GYROSCOPE)]
            (ax, ay, az), (gx, gy, gz) = triads
            samples.append(Sample((ax, ay, az), (gx, gy, gz), ticks, tuple(values.items())))
        return samples
