"""Parser for an MPU-6050 on an Arduino: the text that its sketch prints.

The project's own sketch has priority: after one of its lines with a right checksum, all other lines
are ignored. Outputs of other sketches and tutorials are patterns of their lines and headers; with
numbers of at most twelve digits and lines of bounded length no pattern can run away.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.line_pattern import (
    HEADER,
    LinePattern,
    LineReader,
    header_settings,
    parse_sketch_line,
)
from pipeline.devices.sample import (
    AS_LABELLED,
    CLOCKS,
    COUNTS,
    MICROS,
    DeviceClock,
    Parser,
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
from pipeline.logs.dialect import delimiter_of, is_number, split_cells
from pipeline.logs.header import our_names
from pipeline.logs.header_words import read_name

ARDUINO_STAMP = re.compile(r"\d\d:\d\d:\d\d\.\d{3} -> ")
PLX_DAQ = re.compile(r"DATA,", re.IGNORECASE)
SI, G_AND_DEG = "m/s², rad/s", "g, deg/s"


@dataclass(frozen=True)
class SketchDialect:
    """Output of a sketch for a sample, one line or a few, and the unit of its readings."""

    unit: str
    lines: tuple[LinePattern, ...]


def _dialect(unit: str, *lines: str) -> SketchDialect:
    return SketchDialect(unit, tuple(map(LinePattern.of, lines)))


_A, _G = (" ".join(f"{{{name}}}" for name in triad) for triad in (ACCELEROMETER, GYROSCOPE))
_A_XYZ, _G_XYZ = (" ".join(f"{axis}: {{{name}}}" for axis, name in zip("XYZ", triad, strict=True))
                  for triad in (ACCELEROMETER, GYROSCOPE))
_T = f"{{{TEMPERATURE}}}"
#: Commas of a line count as blanks.
DIALECTS = (
    _dialect(COUNTS, f"a/g: {_A} {_G}"),  # i2cdevlib's MPU6050_raw
    _dialect(SI, "AccelX:{acc_x} AccelY:{acc_y} AccelZ:{acc_z} "  # for the serial plotter
                 "GyroX:{gyr_x} GyroY:{gyr_y} GyroZ:{gyr_z}"),
    # Adafruit's basic_readings
    _dialect(SI, f"Acceleration {_A_XYZ} m/s^2", f"Rotation {_G_XYZ} rad/s",
             f"Temperature: {_T} degC"),
    # Arduino Playground
    _dialect(COUNTS, f"accel x y z : {_A}", f"gyro x y z : {_G}",
             f"temperature: {_T} degrees Celsius"),
    # MPU6050_light's GetAllData
    _dialect(G_AND_DEG, f"ACCELERO {_A_XYZ}", f"GYRO {_G_XYZ}", f"TEMPERATURE: {_T}"),
    _dialect(AS_LABELLED, f"X Y Z= {_A}"),  # of a tutorial
)
#: Beginnings of lines of sketches that print no raw readings -> advice.
UNUSABLE = {
    ("quat\t", "euler\t", "ypr\t", "areal\t", "aworld\t", "ggWorld\t"): (
        "the sketch prints orientation from the chip's motion processor, not raw readings; upload "
        "i2cdevlib's MPU6050_raw or the sketch in data/arduino"
    ),
    ("PID tuning Each Dot", "-------------- done"): (
        "the sketch is IMU_Zero, which prints offsets, not readings; upload i2cdevlib's "
        "MPU6050_raw or the sketch in data/arduino"
    ),
}


@dataclass(frozen=True)
class HeaderTable:
    """The columns of separated rows, as their header names them."""

    names: tuple[str, ...]
    delimiter: str
    clock: DeviceClock | None
    unit: str


#: Names of boards' clocks, by the seconds that their number 1 is.
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
    units = {said.unit for name, said in zip(names, words, strict=True)
             if name in (*ACCELEROMETER, *GYROSCOPE)}
    unit = (G_AND_DEG if units & {"g", "deg_s"} else SI if units & {"m_s2", "rad_s"} else COUNTS)
    return HeaderTable(tuple(names), delimiter, CLOCKS[clock][0] if clock else None, unit)


READINGS = (*ACCELEROMETER, *GYROSCOPE)

WORD = (-(2**15), 2**15 - 1)  #: range of a 16-bit converter
BARE_LINES = 4
"""Number of successive rows of six numbers between blanks from which they count as samples:
sketches print one or two rows of six offsets before their first sample."""


class Mpu6050TextParser(Parser):
    """Samples from the lines of a sketch.

    Attributes
    ----------
    settings : dict
        What the header of the project's own sketch states, for example ``fs_a`` in g.
    """

    def __init__(self) -> None:
        super().__init__(LineReader(), COUNTS)
        self.settings: dict[str, float] = {}
        self._own = False
        self._table: HeaderTable | None = None
        self._dialect: SketchDialect | None = None
        self._block: dict[str, float] = {}
        self._seen: set[int] = set()
        self._whole: set[int] = set()
        self._bare = 0

    def _sample(self, line: str) -> Sample | None:
        stamped = ARDUINO_STAMP.match(line)
        line = (line[stamped.end() :].lstrip() if stamped else line).rstrip()
        if line.startswith(HEADER):
            self.settings = header_settings(line)
            return None
        if line.startswith("S,"):  # a sample of our sketch, intact or damaged
            sample = parse_sketch_line(line)
            if sample is None:
                self._damaged += 1
            else:
                self._own, self.clock, self.unit, self.advice = True, MICROS, COUNTS, ""
            return sample
        if self._own or not line.strip():
            return None
        plain = line.replace(",", " ")
        begun = [(dialect, i) for dialect in DIALECTS for i, pattern in enumerate(dialect.lines)
                 if pattern.head.match(plain)]
        for dialect, i in begun:
            values = dialect.lines[i].values(plain)
            if values is not None and (dialect.unit != COUNTS or _are_words(values)):
                return self._dialect_line(dialect, i, values)
        if begun:
            self._damaged += 1
            return None
        return self._row(PLX_DAQ.sub("", line, count=1))

    def _dialect_line(
        self, dialect: SketchDialect, i: int, values: Mapping[str, float]
    ) -> Sample | None:
        """A line of a dialect's block; gives the sample of the block before at a new one."""
        if dialect is not self._dialect:
            self._dialect, self._block, self._seen, self._whole = dialect, {}, set(), set()
        self.unit, self.advice = dialect.unit, ""
        done = self._end_block() if i in self._seen else None
        if i == 0 or self._seen:  # a block begins with the accelerometer
            self._block.update(values)
            self._seen.add(i)
        return self._end_block() if len(dialect.lines) == 1 else done

    def _end_block(self) -> Sample | None:
        """The sample of the block so far, None where lines of it were lost."""
        block, seen = self._block, self._seen
        self._block, self._seen = {}, set()
        if not seen:
            return None
        if seen < self._whole:
            self._damaged += 1
            return None
        self._whole = seen
        return sample_of(block)

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
            else:
                self.advice = self.advice or next((advice for starts, advice in UNUSABLE.items()
                                                   if line.startswith(starts)), "")
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
            self._damaged += header_table(line) is None  # a repeated header is no damage
            return None
        return sample_of(values)


def _number(cell: str) -> float | None:
    """The finite number in a cell, or None."""
    value = float(cell) if is_number(cell) else math.nan
    return value if math.isfinite(value) else None


def _are_words(values: Mapping[str, float]) -> bool:
    return all(WORD[0] <= value <= WORD[1] and value == int(value)
               for name, value in values.items() if name in READINGS)
