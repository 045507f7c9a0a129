"""MPU-6050 on an Arduino: lines of text with its readings.

The project's own sketch is preferred: once one of its lines has come with a right checksum, nothing
else on the line counts. Of other sketches the parser reads i2cdevlib's MPU6050_raw, tables whose
header names their columns, and rows of six numbers.
"""

import math
import re
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.line_pattern import (
    HEADER,
    LinePattern,
    LineReader,
    header_settings,
    is_sketch_line,
    parse_sketch_line,
)
from pipeline.devices.sample import (
    CLOCKS,
    COUNTS,
    G_AND_DEG,
    MICROS,
    SI,
    DeviceClock,
    Sample,
    clock_among,
    sample_of,
)
from pipeline.logs.columns import (
    ACCELEROMETER,
    COUNTER,
    GYROSCOPE,
    SECONDS_PER,
    SKIP,
    TIME,
    missing_columns,
)
from pipeline.logs.dialect import delimiter_of, split_cells
from pipeline.logs.header import our_names
from pipeline.logs.header_words import read_name

READINGS = (*ACCELEROMETER, *GYROSCOPE)
ARDUINO_STAMP = re.compile(r"\d\d:\d\d:\d\d\.\d{3} -> ")  #: stamp of the Arduino IDE
MPU6050_RAW = LinePattern.of("a/g: " + " ".join(f"{{{name}}}" for name in READINGS))  #: i2cdevlib's

WORD = (-(2**15), 2**15 - 1)  #: what a 16-bit converter can give
BARE_LINES = 4
"""Rows of six numbers between blanks count as samples from this many in a row on: sketches print
one or two rows of six offsets before their first sample."""


@dataclass(frozen=True)
class HeaderTable:
    """The columns of separated rows, as their header names them."""

    names: tuple[str, ...]
    delimiter: str
    clock: DeviceClock | None
    unit: str


#: What clocks of boards are called, by the seconds that their number 1 is.
_CLOCK_NAMES = {SECONDS_PER["us"]: "time_us", SECONDS_PER["ms"]: "time_ms", 1.0: TIME}


def header_table(line: str) -> HeaderTable | None:
    """The table whose header this line is, or None."""
    text = line.lstrip("#/% ")
    delimiter = delimiter_of(text)
    if delimiter is None:
        return None
    cells = split_cells(text, delimiter)
    words = [read_name(cell) for cell in cells]
    names = []
    for (name, factor), said in zip(our_names(cells), words, strict=True):
        name = _CLOCK_NAMES.get(factor, SKIP) if name == TIME else name
        name = COUNTER if said.quantity in ("counter", "samples") else name
        name = TEMPERATURE if said.quantity == "temperature" else name
        names.append(SKIP if name in names else name)
    if missing_columns(names) is not None:
        return None
    clock = clock_among(names)
    units = {said.unit for name, said in zip(names, words, strict=True) if name in READINGS}
    unit = (G_AND_DEG if units & {"g", "deg_s"} else SI if units & {"m_s2", "rad_s"} else COUNTS)
    return HeaderTable(tuple(names), delimiter, CLOCKS[clock][0] if clock else None, unit)


class Mpu6050TextParser:
    """Samples from lines of text; see :class:`pipeline.devices.sample.Parser`.

    Attributes
    ----------
    settings : dict
        What the header of the project's own sketch states, for example ``fs_a`` in g.
    """

    def __init__(self) -> None:
        self.clock: DeviceClock | None = None
        self.unit = COUNTS
        self.advice = ""
        self.settings: dict[str, float] = {}
        self._lines = LineReader()
        self._damaged = 0
        self._own = False
        self._table: HeaderTable | None = None
        self._bare = 0

    @property
    def bad(self) -> int:
        """Damaged lines so far."""
        return self._lines.bad + self._damaged

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        samples = (self._sample(line) for line in self._lines.feed(data))
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
        if MPU6050_RAW.head.match(line):
            values = MPU6050_RAW.values(line)
            if values is None or not all(map(_is_word, values.values())):
                self._damaged += 1
                return None
            self.unit, self.advice = COUNTS, ""
            return sample_of(values)
        return self._row(line)

    def _row(self, line: str) -> Sample | None:
        """A row of numbers under a header, or six numbers without one; else words."""
        if self._table is not None:
            return self._table_row(self._table, line)
        separated = "," in line or ";" in line
        cells = line.replace(";", ",").split(",") if separated else line.split()
        numbers = [_number(cell) for cell in cells]
        if None in numbers:
            self._bare = 0
            self._table = header_table(line)
            if self._table is not None:
                self.clock, self.unit = self._table.clock, self._table.unit
            return None
        values = [number for number in numbers if number is not None]
        self._bare += 1
        if len(values) != len(READINGS):
            self.advice = (
                f"lines hold {len(values)} numbers and no header names them; describe "
                f"the line by `pattern` with `device: lines`, or upload the sketch in data/arduino"
            )
            return None
        if not separated and self._bare < BARE_LINES:
            return None
        self.advice = ""
        return sample_of(dict(zip(READINGS, values, strict=True)))

    def _table_row(self, table: HeaderTable, line: str) -> Sample | None:
        cells = line.split(table.delimiter)
        values = {name: number for name, cell in zip(table.names, cells, strict=False)
                  if name != SKIP and (number := _number(cell)) is not None}
        if len(cells) != len(table.names) or any(
                name in READINGS and name not in values for name in table.names):
            self._damaged += header_table(line) is None  # the header again is no damage
            return None
        self.advice = ""
        return sample_of(values)


def _number(cell: str) -> float | None:
    """The finite number in a cell, or None."""
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in cell else None


def _is_word(value: float) -> bool:
    return WORD[0] <= value <= WORD[1] and value == int(value)
