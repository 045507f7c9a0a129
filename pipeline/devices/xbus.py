"""Frames of the Xsens protocol: ``FA FF MID LEN DATA CS``, big endian.

The bytes after the preamble FA, checksum included, add up to 0 modulo 256. (Xsens, MTi and MTx User
Manual, MT0100P, p. 26; its messages of more than 254 bytes, told by a LEN of FF, hold no readings.)
"""

from dataclasses import dataclass

PREAMBLE, BUS = 0xFA, 0xFF  #: fact: the first two bytes of every message of a single device
START = bytes([PREAMBLE, BUS])
HEAD, AROUND = 4, 5  #: fact: bytes of a message before its data, and around them


@dataclass(frozen=True, slots=True)
class Message:
    """One message: its identifier and its data."""

    mid: int
    data: bytes


class XbusReader:
    """Finds messages in a stream, incrementally.

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
            size = AROUND + buffer[start + 3] if start + HEAD <= len(buffer) else len(buffer) + 1
            if start + size > len(buffer):
                break
            if sum(buffer[start + 1 : start + size]) % 256 == 0:
                data = bytes(buffer[start + HEAD : start + size - 1])
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
