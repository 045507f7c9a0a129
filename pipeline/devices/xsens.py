"""Readings of an Xsens MTi: MTData (0x32) of the legacy protocol, and MTData2 (0x36).

Both come in frames ``FA FF MID LEN DATA CS``, big endian. The bytes after the preamble FA, checksum
included, add up to 0 modulo 256. A LEN of FF says that the next two bytes hold the length. (Xsens,
MTi and MTx User Manual, MT0100P, p. 26.)

The data are ten 16-bit words: accelerometer, gyroscope and magnetometer x, y, z unsigned, then the
temperature as two's complement in 1/256 °C; an eleventh is the sample counter, if it is on.
(MT0100P, p. 24 and 30; the driver that reads the temperature unsigned is wrong below 0 °C.)

Raw readings (0xA010) are the ten words of the legacy raw mode. Calibrated ones (0x4020, 0x8020)
come as float, fixed point 12.20, fixed point 16.32 or double, told by the low bits of the DataID.
(MTi 10/100-series User Manual, MT0605P, section 5.8.)
"""

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import CLOCK_MODULUS, COUNTS, NOT_SENT, DeviceClock, Sample, Triple

PREAMBLE, BUS = 0xFA, 0xFF  #: fact: the first two bytes of every message of a single device
START = bytes([PREAMBLE, BUS])
EXTENDED = 0xFF  #: the LEN that is followed by a length of two bytes
LONGEST_DATA = 2048  #: a longer length is taken for damage: no message of these devices has it

#: Facts of the protocol: message identifiers. An answer has that of its request and one more.
GO_TO_CONFIG, GO_TO_MEASUREMENT, RESET = 0x30, 0x10, 0x40
WAKE_UP, WAKE_UP_ACK, ERROR = 0x3E, 0x3F, 0x42  # reports of a reset and of a fault
REQUEST_CONFIGURATION, SET_PERIOD = 0x0C, 0x04  # answered with 118 bytes; in ticks of 1/115200 s
SET_OUTPUT_MODE, SET_OUTPUT_SETTINGS, SET_SKIP_FACTOR = 0xD0, 0xD2, 0xD4  # of the legacy series
SET_OUTPUT_CONFIGURATION = 0xC0  # of the newer series
WRONG_PERIOD = 0x03  # a code of ERROR
TICKS_PER_S = 115200  #: fact: in which the sampling period is stated
DATA_LENGTH_AT = 102  #: fact: of the length of its data in the answer to a request of configuration


@dataclass(frozen=True, slots=True)
class Message:
    """One message: its identifier and its data."""

    mid: int
    data: bytes


def frame(mid: int, data: bytes = b"") -> bytes:
    """The bytes of a message.

    >>> frame(0xD0, bytes([0x40, 0x00])).hex(" ")
    'fa ff d0 02 40 00 ef'
    """
    length = len(data)
    size = bytes([length]) if length < EXTENDED else bytes([EXTENDED, *length.to_bytes(2, "big")])
    body = bytes([BUS, mid]) + size + data
    return bytes([PREAMBLE]) + body + bytes([-sum(body) % 256])


class XbusReader:
    """Finds messages in a stream incrementally.

    After damage every following byte is tried as a start, so that no whole message is lost.

    Attributes
    ----------
    bad : int
        Stretches of bytes that belong to no message.
    """

    def __init__(self) -> None:
        self.bad = 0
        self._buffer = bytearray()
        self._in_damage = False

    def feed(self, data: bytes) -> list[Message]:
        """The messages that ``data`` completes."""
        self._buffer += data
        buffer, at, messages = self._buffer, 0, []
        while True:
            start = buffer.find(START, at)
            if start < 0:
                # The last byte may be the first half of a start.
                start = len(buffer) - buffer[at:].endswith(START[:1])
                self._skip(start - at)
                at = start
                break
            self._skip(start - at)
            at = start
            size = _frame_size(buffer, start)
            if size is None or (size and start + size > len(buffer)):
                break
            if size and sum(buffer[start + 1 : start + size]) % 256 == 0:
                head = 6 if buffer[start + 3] == EXTENDED else 4
                data = bytes(buffer[start + head : start + size - 1])
                messages.append(Message(buffer[start + 2], data))
                at = start + size
                self._in_damage = False
            else:
                self._skip(1)
                at = start + 1
        del buffer[:at]
        return messages

    def _skip(self, count: int) -> None:
        if count > 0:
            self.bad += not self._in_damage
            self._in_damage = True


def _frame_size(buffer: bytearray, start: int) -> int | None:
    """Size of the whole frame at ``start``; 0 where it cannot be one, None where not yet known."""
    head = buffer[start : start + 6]
    if len(head) < 4:
        return None
    if head[3] != EXTENDED:
        return head[3] + 5
    if len(head) < 6:
        return None
    length = int.from_bytes(head[4:6], "big")
    return length + 7 if length <= LONGEST_DATA else 0


MTDATA = 0x32  #: fact: its message identifier
RAW = struct.Struct(">9Hh")
RAW_COUNTED = struct.Struct(">9HhH")
COUNTER_MODULUS = 1 << 16  #: fact: sample and packet counters of an MTi have 16 bits
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
                    f"(20 or 22 bytes); set output mode 0x4000, or let `pipeline record` set it"
                )
        return samples


#: Facts of the protocol: the message identifier, and DataIDs.
MTDATA2 = 0x36
PACKET_COUNTER, SAMPLE_TIME_FINE = 0x1020, 0x1060  # 16 bits; ticks of 100 µs
RAW_ALL, TEMPERATURE_ID = 0xA010, 0x0810  # readings of the converters; °C
ACCELERATION, RATE_OF_TURN = 0x4020, 0x8020  # m/s² and rad/s
KIND = 0xFFF0  #: mask of a DataID; the low four bits are number format and frame

PACKETS = DeviceClock("packet counter", None, COUNTER_MODULUS)
FINE = DeviceClock("sample time fine", 1e-4, CLOCK_MODULUS)
SI = "m/s², rad/s"


def packets(data: bytes) -> Iterator[tuple[int, bytes]]:
    """``(DataID, bytes)`` of every whole packet of a message."""
    at = 0
    while at + 3 <= len(data):
        size = data[at + 2]
        if at + 3 + size > len(data):
            return
        yield int.from_bytes(data[at : at + 2], "big"), data[at + 3 : at + 3 + size]
        at += 3 + size


def reals(data_id: int, data: bytes) -> tuple[float, ...]:
    """The numbers of a packet in the format of its DataID; none where the size is wrong."""
    form = data_id & 0x3
    if form == 0:
        return tuple(x for (x,) in struct.iter_unpack(">f", data)) if len(data) % 4 == 0 else ()
    if form == 1:
        if len(data) % 4:
            return ()
        return tuple(x / 2**20 for (x,) in struct.iter_unpack(">i", data))
    if form == 2:  # the 32 bits of the fraction come before the 16 of the whole part
        if len(data) % 6:
            return ()
        return tuple(whole + part / 2**32 for part, whole in struct.iter_unpack(">Ih", data))
    return tuple(x for (x,) in struct.iter_unpack(">d", data)) if len(data) % 8 == 0 else ()


class MtData2Parser:
    """Samples of MTData2; see :class:`pipeline.devices.sample.Parser`."""

    def __init__(self) -> None:
        self.clock: DeviceClock | None = None
        self.unit = COUNTS
        self.advice = ""
        self._frames = XbusReader()
        self._damaged = 0

    @property
    def bad(self) -> int:
        """Damaged stretches of the stream, and messages whose packets do not fill them."""
        return self._frames.bad + self._damaged

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        samples = (self._sample(message.data) for message in self._frames.feed(data)
                   if message.mid == MTDATA2)
        return [sample for sample in samples if sample is not None]

    def _sample(self, data: bytes) -> Sample | None:
        """The sample of one message, None where it holds no triad."""
        triads: dict[int, Triple] = {}
        columns: list[tuple[str, float]] = []
        raw: tuple[int, ...] | None = None
        counter: int | None = None
        fine: int | None = None
        for data_id, part in packets(data):
            kind = data_id & KIND
            if data_id == RAW_ALL and len(part) == RAW.size:
                raw = RAW.unpack(part)
            elif data_id == PACKET_COUNTER and len(part) == 2:
                counter = int.from_bytes(part, "big")
            elif data_id == SAMPLE_TIME_FINE and len(part) == 4:
                fine = int.from_bytes(part, "big")
            elif kind in (ACCELERATION, RATE_OF_TURN, TEMPERATURE_ID):
                values = reals(data_id, part)
                usable = bool(values) and all(map(math.isfinite, values))
                if usable and kind == TEMPERATURE_ID and len(values) == 1:
                    columns.append((TEMPERATURE, values[0]))
                elif usable and len(values) == 3:
                    triads[kind] = (values[0], values[1], values[2])
                else:
                    self._damaged += 1
        self.clock = FINE if fine is not None else PACKETS if counter is not None else self.clock
        ticks = counter if fine is None else fine
        if raw is not None:
            self.unit = COUNTS
            return raw_sample(raw, ticks)
        if not triads:
            self.advice = (
                "the MTi sends neither raw readings (0xA010) nor acceleration and rate of turn "
                "(0x4020, 0x8020); switch one of them on in MT Manager, or let `pipeline record` "
                "do it"
            )
            return None
        self.unit, self.advice = SI, ""
        return Sample(triads.get(ACCELERATION, NOT_SENT), triads.get(RATE_OF_TURN, NOT_SENT),
                      ticks, tuple(columns))
