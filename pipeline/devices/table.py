"""The devices that ``record.device`` can name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipeline.devices.line_pattern import LinePattern, LinePatternParser
from pipeline.devices.mpu6050_text import Mpu6050TextParser
from pipeline.devices.sample import Parser
from pipeline.devices.xsens_mtdata import MtDataParser


@dataclass(frozen=True)
class Device:
    """A kind of device.

    Parameters
    ----------
    what : str
        In words.
    bauds : tuple of int
        Usual speeds of its serial line, the usual one first.
    make : callable
        Gives a new parser, by the ``pattern`` of the configuration.
    """

    what: str
    bauds: tuple[int, ...]
    make: Callable[[str], Parser]


ARDUINO_BAUDS = (115200, 38400, 9600, 57600, 250000, 230400, 19200)
"""Speeds that sketches open their port with; 115200 is that of this project's, 38400 that of
i2cdevlib's MPU6050_raw, 9600 that of Arduino's own examples."""

DEVICES: Mapping[str, Device] = {
    "xsens-mti": Device("Xsens MTi, legacy protocol, raw readings", (115200, 460800, 230400),
                        lambda _: MtDataParser()),
    "mpu-6050": Device("MPU-6050 on an Arduino, lines of text", ARDUINO_BAUDS,
                       lambda _: Mpu6050TextParser()),
    "lines": Device("any lines of text, described by `pattern`", ARDUINO_BAUDS,
                    lambda pattern: LinePatternParser(LinePattern.stated(pattern))),
}
