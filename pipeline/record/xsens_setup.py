"""Setup of an Xsens MTi to send raw readings: the conversation before the stream.

Every request is answered by a message whose identifier is one higher, or by an error. A device that
streams may overlook GoToConfig; a reset, answered with WakeUpAck, then brings it to configuration.
(Xsens, MT0100P, p. 30-34; MT0605P, section 5.)
"""

import time
from collections.abc import Callable
from typing import NamedTuple

from pipeline.devices import xsens
from pipeline.devices.xsens import Message, XbusReader, frame
from pipeline.errors import DeviceError
from pipeline.record.serial_port import Port

RAW_MODE, SAMPLE_COUNTER_ON = 0x4000, 0x00000001  #: facts: bits of output mode and settings
SHORTEST_PERIOD, LONGEST_PERIOD = 225, 1152  #: 512 Hz and 100 Hz
EVERY_SAMPLE = 0xFFFF  #: fact: the rate that means "with every packet"

ANSWER_S = 0.6  #: at 115200 baud an answer takes milliseconds, a reset half a second
TRIES = 3  #: a device that streams may overlook a request; chosen
ERRORS = {
    xsens.WRONG_PERIOD: "the sampling period is not one it can do",
    0x04: "it does not know this message; is it the other kind of MTi (record.device)?",
    0x1E: "its timer overflowed; lower the sample rate",
    0x20: "it does not do this baud rate",
    0x21: "a value is not one it can do; lower the sample rate",
    0x29: "the baud rate is too low for this sample rate; raise record.baud on the device first, "
          "or lower record.sample_rate_hz",
    0x2A: "its buffer is full; raise the baud rate, or lower the sample rate",
}


class XsensError(DeviceError):
    """The device answered with an error; carries its ``code``."""

    def __init__(self, mid: int, code: int) -> None:
        message = ERRORS.get(code, "see the manual's list of errors")
        super().__init__(f"the MTi answers message 0x{mid:02X} with error 0x{code:02X}: {message}.")
        self.code = code


class XsensStream(NamedTuple):
    """A streaming device: samples per second, and the first bytes of its stream."""

    rate_hz: float
    first_bytes: bytes


class Conversation:
    """Requests and their answers on a port.

    Parameters
    ----------
    port : Port
    keep : callable
        Told of all bytes that come, and when: the raw file begins with the device's headers.

    Attributes
    ----------
    last : bytes
        What came together with the last answer: the stream may begin in it.
    """

    def __init__(self, port: Port, keep: Callable[[bytes, float], None]) -> None:
        self._port, self._keep = port, keep
        self._reader = XbusReader()
        self.last = b""

    def ask(self, mid: int, data: bytes = b"") -> bytes:
        """Send a request and return the data of its answer.

        Raises
        ------
        XsensError
            The device refuses.
        DeviceError
            No answer came.
        """
        for _ in range(TRIES):
            self._port.write(frame(mid, data))
            answer = self._wait_for(mid + 1, mid)
            if answer is not None:
                return answer.data
        raise DeviceError(
            f"the MTi does not answer message 0x{mid:02X} within {ANSWER_S * TRIES:.0f} s. Check "
            f"record.port and record.baud (an MTi leaves the factory with 115200), its power, and "
            f"that no other program talks to it."
        )

    def _wait_for(self, mid: int, request: int) -> Message | None:
        until = time.monotonic() + ANSWER_S
        while time.monotonic() < until:
            data, heard_s = self._port.read()
            self._keep(data, heard_s)
            self.last = data
            for message in self._reader.feed(data):
                if message.mid == xsens.WAKE_UP:
                    self._port.write(frame(xsens.WAKE_UP_ACK))
                if message.mid == xsens.ERROR and message.data:
                    raise XsensError(request, message.data[0])
                if message.mid == mid:
                    return message
        return None

    def go_to_config(self) -> None:
        """Stop the stream; by a reset where the device overlooks the request."""
        try:
            self.ask(xsens.GO_TO_CONFIG)
        except XsensError:
            raise
        except DeviceError:
            self._port.write(frame(xsens.RESET))
            self._wait_for(xsens.WAKE_UP, xsens.RESET)
            self.ask(xsens.GO_TO_CONFIG)


def start_mtdata(port: Port, rate_hz: float, keep: Callable[[bytes, float], None]) -> XsensStream:
    """Start raw output with the sample counter on a legacy MTi."""
    talk = Conversation(port, keep)
    talk.go_to_config()
    period = min(max(round(xsens.TICKS_PER_S / rate_hz), SHORTEST_PERIOD), LONGEST_PERIOD)
    skip = max(round(xsens.TICKS_PER_S / period / rate_hz) - 1, 0)
    talk.ask(xsens.SET_OUTPUT_MODE, RAW_MODE.to_bytes(2, "big"))
    talk.ask(xsens.SET_OUTPUT_SETTINGS, SAMPLE_COUNTER_ON.to_bytes(4, "big"))
    talk.ask(xsens.SET_PERIOD, period.to_bytes(2, "big"))
    talk.ask(xsens.SET_SKIP_FACTOR, skip.to_bytes(2, "big"))
    stated = talk.ask(xsens.REQUEST_CONFIGURATION)[xsens.DATA_LENGTH_AT : xsens.DATA_LENGTH_AT + 2]
    size = int.from_bytes(stated, "big")
    if size != xsens.RAW_COUNTED.size:
        raise DeviceError(
            f"the MTi took the raw output mode, but says that it will send {size} bytes a sample; "
            f"{xsens.RAW_COUNTED.size} are expected. Switch it off and on, and try again."
        )
    talk.ask(xsens.GO_TO_MEASUREMENT)
    return XsensStream(xsens.TICKS_PER_S / period / (skip + 1), talk.last)


def start_mtdata2(port: Port, rate_hz: float, keep: Callable[[bytes, float], None]) -> XsensStream:
    """Start raw output on a newer MTi.

    Counter and time stamp are requested too; firmware that does not combine them with raw readings
    refuses, and the readings are requested alone.
    """
    talk = Conversation(port, keep)
    talk.go_to_config()
    raw = (xsens.RAW_ALL, round(rate_hz))
    try:
        stated = talk.ask(xsens.SET_OUTPUT_CONFIGURATION, _outputs(
            (xsens.PACKET_COUNTER, EVERY_SAMPLE), (xsens.SAMPLE_TIME_FINE, EVERY_SAMPLE), raw))
    except XsensError:
        stated = talk.ask(xsens.SET_OUTPUT_CONFIGURATION, _outputs(raw))
    talk.ask(xsens.GO_TO_MEASUREMENT)
    words = [int.from_bytes(stated[i : i + 2], "big") for i in range(0, len(stated), 2)]
    rates = dict(zip(words[::2], words[1::2], strict=False))
    return XsensStream(float(rates.get(xsens.RAW_ALL) or round(rate_hz)), talk.last)


def _outputs(*wanted: tuple[int, int]) -> bytes:
    return b"".join(value.to_bytes(2, "big") for pair in wanted for value in pair)
