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
from operator import mul

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import (
    CLOCK_MODULUS,
    COUNTS,
    NOT_SENT,
    DeviceClock,
    Parser,
    Sample,
    Triple,
)

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


#: Facts: the layouts of a real number, by the low bits of its DataID, and the units of its parts.
#: In fixed point 16.32 the 32 bits of the fraction come first.
REALS = ((">f", (1.0,)), (">i", (2.0**-20,)), (">Ih", (2.0**-32, 1.0)), (">d", (1.0,)))


def reals(data_id: int, data: bytes) -> tuple[float, ...]:
    """The numbers of a packet in the format of its DataID; none where the size is wrong."""
    layout, units = REALS[data_id & 0x3]
    if len(data) % struct.calcsize(layout):
        return ()
    return tuple(sum(map(mul, parts, units)) for parts in struct.iter_unpack(layout, data))


class XsensParser(Parser):
    """Samples of MTData in raw mode, and of MTData2."""

    def __init__(self) -> None:
        super().__init__(XbusReader(), COUNTS)

    def _sample(self, message: Message) -> Sample | None:
        read = {MTDATA: self._legacy, MTDATA2: self._packets}.get(message.mid)
        return read(message.data) if read else None

    def _legacy(self, data: bytes) -> Sample | None:
        """The sample of MTData, None where it is not in raw mode."""
        if len(data) == RAW.size:
            return raw_sample(RAW.unpack(data), None)
        if len(data) == RAW_COUNTED.size:
            words = RAW_COUNTED.unpack(data)
            self.clock = COUNTER
            return raw_sample(words, words[10])
        self.advice = (
            f"the MTi sends MTData of {len(data)} bytes, which is no raw output (20 or 22 bytes); "
            f"set output mode 0x4000, or let `pipeline record` set it"
        )
        return None

    def _packets(self, data: bytes) -> Sample | None:
        """The sample of MTData2, None where it holds no triad."""
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
