"""MPU-6050 on an Arduino: whatever its sketch prints as text.

The project's own sketch is preferred: once one of its lines has come with a right checksum, nothing
else on the line counts.
"""

import math
import re
from collections.abc import Sequence

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import COUNTS, NOT_SENT, DeviceClock, Sample, Triple
from pipeline.devices.sketch_lines import (
    HEADER,
    header_settings,
    is_sketch_line,
    parse_sketch_line,
)
from pipeline.devices.text_dialects import (
    ARDUINO_STAMP,
    BLOCK_LINES,
    CLOCKS,
    MICROS,
    PLOTTER,
    PLX_DAQ,
    RAW,
    SI,
    BlockLine,
    HeaderTable,
    advice_on,
    header_table,
)
from pipeline.devices.text_lines import LineReader
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, SKIP

WORD = (-(2**15), 2**15 - 1)  #: what a 16-bit converter can give
BARE_LINES = 4
"""Rows of six numbers between blanks count as samples from this many in a row on: sketches print
one or two rows of six offsets before their first sample."""


class Mpu6050TextParser:
    """Samples from lines of text; see :class:`pipeline.devices.sample.Parser`.

    Parameters
    ----------
    from_start : bool
        The bytes begin with a whole line, as a file does; a serial line seldom does.

    Attributes
    ----------
    settings : dict
        What the header of the project's own sketch states, for example ``fs_a`` in g.
    """

    def __init__(self, from_start: bool = False) -> None:
        self.clock: DeviceClock | None = None
        self.unit = COUNTS
        self.advice = ""
        self.settings: dict[str, float] = {}
        self._lines = LineReader(from_start)
        self._damaged = 0
        self._own = False
        self._table: HeaderTable | None = None
        self._block: dict[str, tuple[float, ...]] = {}
        self._whole: set[str] = set()
        self._bare = 0

    @property
    def bad(self) -> int:
        """Damaged lines so far."""
        return self._lines.bad + self._damaged

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        samples = (self._sample(line) for line in self._lines.feed(data))
        return [sample for sample in samples if sample is not None]

    def finish(self) -> list[Sample]:
        """The samples that the end of the stream completes."""
        samples = [self._sample(line) for line in self._lines.finish()]
        samples.append(self._end_block())
        return [sample for sample in samples if sample is not None]

    def _sample(self, line: str) -> Sample | None:
        stamped = ARDUINO_STAMP.match(line)
        line = (line[stamped.end() :].lstrip() if stamped else line).rstrip()
        if line.startswith(HEADER):
            self.settings = header_settings(line)
            return None
        if is_sketch_line(line):
            sample = parse_sketch_line(line)
            if sample is None:
                self._damaged += 1
            else:
                self._own, self.clock, self.unit, self.advice = True, MICROS, COUNTS, ""
            return sample
        if self._own or not line.strip():
            return None
        if line.startswith("a/g:"):
            return self._six(RAW.fullmatch(line), COUNTS)
        if line.startswith("AccelX:"):
            return self._six(PLOTTER.fullmatch(line), SI)
        for kind in BLOCK_LINES:
            if line.startswith(kind.begins):
                return self._block_line(kind, line)
        return self._row(PLX_DAQ.sub("", line, count=1))

    def _six(self, match: re.Match[str] | None, unit: str) -> Sample | None:
        numbers = _numbers(match)
        if numbers is None or (unit == COUNTS and not _are_words(numbers)):
            self._damaged += 1
            return None
        self.unit, self.advice = unit, ""
        a, b, c, d, e, f = numbers
        return Sample((a, b, c), (d, e, f))

    def _block_line(self, kind: BlockLine, line: str) -> Sample | None:
        """One line of a block; the sample of the block before where this line begins a new one."""
        numbers = _numbers(kind.pattern.fullmatch(line.rstrip()))
        if numbers is None:
            self._damaged += 1
            return None
        self.unit, self.advice = kind.unit, ""
        done = self._end_block() if kind.holds in self._block else None
        if kind.holds == "accelerometer" or self._block:  # a block begins with the accelerometer
            self._block[kind.holds] = numbers
        return done

    def _end_block(self) -> Sample | None:
        """The sample of the block so far, None where lines of it were lost."""
        block, self._block = self._block, {}
        if not block:
            return None
        if block.keys() < self._whole or "accelerometer" not in block:
            self._damaged += 1
            return None
        self._whole = set(block)
        columns = ((TEMPERATURE, block["temperature"][0]),) if "temperature" in block else ()
        return Sample(_triple(block["accelerometer"]), _triple(block.get("gyroscope", NOT_SENT)),
                      None, columns)

    def _row(self, line: str) -> Sample | None:
        """A row of numbers under a header, or six numbers without one; else words."""
        if self._table is None and (table := header_table(line)) is not None:
            self._table, self.clock, self.unit = table, table.clock, table.unit
            return None
        if self._table is not None:
            return self._table_row(self._table, line)
        separated = "," in line or ";" in line
        cells = line.replace(";", ",").split(",") if separated else line.split()
        numbers = [_number(cell) for cell in cells]
        if None in numbers:
            self._bare = 0
            self.advice = self.advice or advice_on(line)
            return None
        values = [number for number in numbers if number is not None]
        self._bare += 1
        if len(values) != 6:
            self.advice = (
                f"lines hold {len(values)} numbers and no header names them; describe "
                f"the line by `pattern` with `device: lines`, or upload the sketch in data/arduino"
            )
            return None
        if not separated and self._bare < BARE_LINES:
            return None
        self.advice = ""
        a, b, c, d, e, f = values
        return Sample((a, b, c), (d, e, f))

    def _table_row(self, table: HeaderTable, line: str) -> Sample | None:
        cells = line.split(table.delimiter)
        values = {name: _number(cell) for name, cell in zip(table.names, cells, strict=False)
                  if name != SKIP}
        triads = [[values.get(name) for name in triad] if triad[0] in table.names else NOT_SENT
                  for triad in (ACCELEROMETER, GYROSCOPE)]
        if len(cells) != len(table.names) or any(None in triad for triad in triads):
            self._damaged += header_table(line) is None  # the header again is no damage
            return None
        stamp = next((name for name in CLOCKS if name in values), None)
        ticks = values.get(stamp) if stamp else None
        columns = tuple((name, value) for name, value in values.items() if value is not None
                        and name not in CLOCKS and name not in ACCELEROMETER + GYROSCOPE)
        return Sample(_triple(triads[0]), _triple(triads[1]),
                      None if ticks is None or stamp is None else
                      round(ticks * CLOCKS[stamp][1]), columns)


def _number(cell: str) -> float | None:
    """The finite number in a cell, or None."""
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in cell else None


def _numbers(match: re.Match[str] | None) -> tuple[float, ...] | None:
    return None if match is None else tuple(float(group) for group in match.groups())


def _are_words(numbers: tuple[float, ...]) -> bool:
    return all(WORD[0] <= number <= WORD[1] and number == int(number) for number in numbers)


def _triple(values: Sequence[float | None]) -> Triple:
    """Three numbers, none of which is missing."""
    x, y, z = (math.nan if value is None else value for value in values)
    return (x, y, z)
