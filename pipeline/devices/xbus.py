"""Frames of the Xsens protocol: ``FA FF MID LEN DATA CS``, big endian.

The bytes after the preamble FA, checksum included, add up to 0 modulo 256. A LEN of FF says that
the next two bytes hold the length. (Xsens, MTi and MTx User Manual, MT0100P, p. 26.)
"""

from dataclasses import dataclass

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
