"""What sketches and tutorials print for an MPU-6050, line by line.

A dialect states what its line holds: a whole sample, or one part of a block of lines. Numbers of
at most nine digits, lines of bounded length: no pattern here can run away.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import AS_LABELLED, CLOCK_MODULUS, COUNTS, DeviceClock
from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, SKIP, TIME, our_name

N = r"([-+]?\d{1,9}(?:\.\d{0,9})?(?:[eE][-+]?\d{1,2})?)"
_XYZ = rf"X:\s*{N},?\s+Y:\s*{N},?\s+Z:\s*{N}"
_LIST = rf"{N},\s*{N},\s*{N},?"

ARDUINO_STAMP = re.compile(r"\d\d:\d\d:\d\d\.\d{3} -> ")
_GAP = r"[\s,]+"
RAW = re.compile(rf"a/g:\s*{_GAP.join([N] * 6)}[\s,]*")
PLOTTER = re.compile(
    rf"AccelX:{N},\s*AccelY:{N},\s*AccelZ:{N},\s*GyroX:{N},\s*GyroY:{N},\s*GyroZ:{N}"
)
PLX_DAQ = re.compile(r"DATA,", re.IGNORECASE)
SI, G_AND_DEG = "m/s², rad/s", "g, deg/s"


@dataclass(frozen=True)
class BlockLine:
    """One line of a block: what it starts with, what it holds, in which unit."""

    begins: str
    holds: str
    pattern: re.Pattern[str]
    unit: str


def _line(begins: str, holds: str, numbers: str, unit: str) -> BlockLine:
    return BlockLine(begins, holds, re.compile(rf"{re.escape(begins)}{numbers}"), unit)


BLOCK_LINES = (
    # Adafruit's basic_readings
    _line("Acceleration ", "accelerometer", rf"{_XYZ}\s*m/s\^2", SI),
    _line("Rotation ", "gyroscope", rf"{_XYZ}\s*rad/s", SI),
    _line("Temperature: ", "temperature", rf"{N}\s*degC", SI),
    # Arduino Playground
    _line("accel x,y,z", "accelerometer", rf"\s*:\s*{_LIST}", COUNTS),
    _line("gyro x,y,z", "gyroscope", rf"\s*:\s*{_LIST}", COUNTS),
    _line("temperature: ", "temperature", rf"{N}\s*degrees Celsius", COUNTS),
    # MPU6050_light's GetAllData
    _line("ACCELERO", "accelerometer", rf"\s+{_XYZ}", G_AND_DEG),
    _line("GYRO ", "gyroscope", rf"\s*{_XYZ}", G_AND_DEG),
    _line("TEMPERATURE: ", "temperature", N, G_AND_DEG),
    # a tutorial's "X,Y,Z= -1.84,2.93,-9.22"
    _line("X,Y,Z=", "accelerometer", rf"\s*{_LIST}", AS_LABELLED),
)

#: Lines of sketches that print no raw readings -> what to do about it.
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
    """What to do about a sketch that prints such a line; empty where nothing is wrong."""
    return next((advice for starts, advice in UNUSABLE.items() if line.startswith(starts)), "")


@dataclass(frozen=True)
class HeaderTable:
    """The columns of comma-separated rows, as their header names them."""

    names: tuple[str, ...]
    delimiter: str | None
    clock: DeviceClock | None
    unit: str


MILLIS = DeviceClock("board milliseconds", 1e-3, CLOCK_MODULUS)
MICROS = DeviceClock("board microseconds", 1e-6, CLOCK_MODULUS)
SECONDS = DeviceClock("board seconds, in microseconds", 1e-6, None)
ROWS = DeviceClock("row counter", None, None)
#: Column of times, or of a counter -> the clock it is, and how many of its ticks the number 1 is;
#: of several columns the first counts.
CLOCKS: Mapping[str, tuple[DeviceClock, float]] = {
    "time_us": (MICROS, 1.0), "time_ms": (MILLIS, 1.0), TIME: (SECONDS, 1e6), COUNTER: (ROWS, 1.0),
}

_STREAM_NAMES: Mapping[str, str] = {
    **dict.fromkeys(("t", "t_s", "sec", "time", "time (s)", "seconds"), TIME),
    **dict.fromkeys(("n", "count", "sample", "loopiteration"), COUNTER),
    **dict.fromkeys(("ms", "millis", "time_ms", "time (ms)", "t_ms"), "time_ms"),
    **dict.fromkeys(("us", "micros", "time_us", "time (us)", "t_us"), "time_us"),
    **dict.fromkeys(("temp", "temp_c", "temperature", "temperature (c)"), TEMPERATURE),
    **{f"{theirs}{axis}": f"{ours}_{axis}"
       for theirs, ours in (("gyroscope ", "gyr"), ("gyro_", "gyr"), ("gyro", "gyr"),
                            ("accelerometer ", "acc"), ("accel", "acc"), ("accel_", "acc"))
       for axis in "xyz"},
    **{f"{theirs}[{i}]": f"{ours}_{axis}"
       for theirs, ours in (("gyroadc", "gyr"), ("accsmooth", "acc"))
       for i, axis in enumerate("xyz")},
}
_UNIT_OF = re.compile(r"\s*\((g|deg/s|m/s\^?2|rad/s)\)$")


def stream_name(cell: str) -> tuple[str, str]:
    """Our name of a header's cell, and its unit where it states one in parentheses."""
    bare = cell.strip().strip('"').lower()
    unit = _UNIT_OF.search(bare)
    bare = _UNIT_OF.sub("", bare)
    return _STREAM_NAMES.get(bare, our_name(bare)[0]), unit[1] if unit else ""


def header_table(line: str) -> HeaderTable | None:
    """The table whose header this line is, or None."""
    delimiter = next((sign for sign in ("\t", ";", ",") if sign in line), None)
    if delimiter is None:
        return None
    cells = [stream_name(cell) for cell in line.lstrip("#/% ").split(delimiter)]
    names = [name for name, _ in cells]
    known = {*ACCELEROMETER, *GYROSCOPE}
    for triad in (ACCELEROMETER, GYROSCOPE):
        if sum(names.count(name) for name in triad) not in (0, 3):
            return None
    if not known & set(names):
        return None
    clock = next((clock for name, (clock, _) in CLOCKS.items() if name in names), None)
    units = {unit for name, unit in cells if name in known}
    unit = (G_AND_DEG if "g" in units or "deg/s" in units else
            SI if "rad/s" in units or "m/s^2" in units else COUNTS)
    repeated = {name for name in names if names.count(name) > 1}
    kept = tuple(SKIP if name in repeated else name for name in names)
    return HeaderTable(kept, delimiter, clock, unit)
