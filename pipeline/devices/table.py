"""The devices that ``record.device`` can name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from pipeline.devices.line_pattern import LinePattern, LinePatternParser
from pipeline.devices.mpu6050_text import Mpu6050TextParser
from pipeline.devices.sample import Parser
from pipeline.devices.xsens import XsensParser


@dataclass(frozen=True)
class Device:
    """A kind of device.

    Parameters
    ----------
    what : str
        In words.
    bauds : tuple of int
        Usual speeds of its serial line, the usual one first.
    begin : str or None
        How it is set up, None for a device that streams by itself.
    make : callable
        Gives a new parser, by the ``pattern`` of the configuration.
    """

    what: str
    bauds: tuple[int, ...]
    begin: Literal["mtdata", "mtdata2"] | None
    make: Callable[[str], Parser]


ARDUINO_BAUDS = (115200, 38400, 9600, 57600, 250000, 230400, 19200)
"""Speeds that sketches open their port with; 115200 is that of this project's, 38400 that of
i2cdevlib's MPU6050_raw, 9600 that of Arduino's own examples."""

DEVICES: Mapping[str, Device] = {
    "xsens-mti": Device("Xsens MTi, legacy protocol, raw readings", (115200, 460800, 230400),
                        "mtdata", lambda _: XsensParser()),
    "xsens-mti-mtdata2": Device("Xsens MTi 1, 10, 100, 600 series, raw readings",
                                (115200, 460800, 230400, 921600), "mtdata2",
                                lambda _: XsensParser()),
    "mpu-6050": Device("MPU-6050 on an Arduino, lines of text", ARDUINO_BAUDS, None,
                       lambda _: Mpu6050TextParser()),
    "lines": Device("any lines of text, described by `pattern`", ARDUINO_BAUDS, None,
                    lambda pattern: LinePatternParser(LinePattern.stated(pattern))),
}
