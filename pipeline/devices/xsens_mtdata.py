"""Readings of an Xsens MTi in the raw mode of the legacy protocol: MTData (0x32).

The data are ten 16-bit words: accelerometer, gyroscope and magnetometer x, y, z unsigned, then the
temperature as two's complement in 1/256 °C; an eleventh is the sample counter, if it is on.
(MT0100P, p. 24 and 30; the driver that reads the temperature unsigned is wrong below 0 °C.)
"""

import struct

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import COUNTS, DeviceClock, Sample
from pipeline.devices.xbus import XbusReader

MTDATA = 0x32  #: fact: its message identifier
RAW = struct.Struct(">9Hh")
RAW_COUNTED = struct.Struct(">9HhH")
COUNTER_MODULUS = 1 << 16  #: fact: the sample counter of an MTi has 16 bits
COUNTER = DeviceClock("sample counter", None, COUNTER_MODULUS)
TEMPERATURE_STEP_C = 1 / 256  #: fact, of the raw temperature word


def raw_sample(words: tuple[int, ...], ticks: int | None) -> Sample:
    """The sample in the ten words of the raw mode."""
    a, b, c, d, e, f = words[:6]
    temperature = ((TEMPERATURE, words[9] * TEMPERATURE_STEP_C),)
    return Sample((a, b, c), (d, e, f), ticks, temperature)


class MtDataParser:
    """Samples of a legacy MTi in raw mode; see :class:`pipeline.devices.sample.Parser`."""

    unit = COUNTS

    def __init__(self) -> None:
        self.clock: DeviceClock | None = None
        self.advice = ""
        self._frames = XbusReader()

    @property
    def bad(self) -> int:
        """Damaged stretches of the stream so far."""
        return self._frames.bad

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        samples = []
        for message in self._frames.feed(data):
            if message.mid != MTDATA:
                continue
            if len(message.data) == RAW_COUNTED.size:
                words = RAW_COUNTED.unpack(message.data)
                self.clock = COUNTER
                samples.append(raw_sample(words, words[10]))
            elif len(message.data) == RAW.size:
                samples.append(raw_sample(RAW.unpack(message.data), None))
            else:
                self.advice = (
                    f"the MTi sends MTData of {len(message.data)} bytes, which is no raw output "
                    f"(20 or 22 bytes); set output mode 0x4000 (raw) in MT Manager"
                )
        return samples
