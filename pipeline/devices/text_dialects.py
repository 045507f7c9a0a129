"""Output of sketches and tutorials for an MPU-6050: patterns of their lines, and of their headers.

Numbers of at most twelve digits, lines of bounded length: no pattern here can run away.
"""

import re
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.line_pattern import LinePattern
from pipeline.devices.sample import AS_LABELLED, CLOCKS, COUNTS, DeviceClock, clock_among
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


def advice_on(line: str) -> str:
    """Advice on a sketch that prints such a line; empty where nothing is wrong."""
    return next((advice for starts, advice in UNUSABLE.items() if line.startswith(starts)), "")


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
