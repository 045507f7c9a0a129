"""Setting an Xsens up: the conversation, its misunderstandings, and what errors mean."""

import time
from collections.abc import Callable

import pytest

from pipeline.devices.xsens import XbusReader, frame
from pipeline.errors import DeviceError
from pipeline.record import xsens_setup as begin_xsens
from pipeline.record.xsens_setup import start_mtdata, start_mtdata2

Answer = Callable[[int, bytes], bytes]


class PaperDevice:
    """A line with a device that answers by a function; remembers what it was told."""

    def __init__(self, answer: Answer) -> None:
        self.told: list[tuple[int, bytes]] = []
        self._answer, self._reader = answer, XbusReader()
        self._out = b""

    def read(self) -> tuple[bytes, float]:
        data, self._out = self._out[:7], self._out[7:]  # in pieces, as a line gives them
        if not data:
            time.sleep(0.005)
        return data, time.monotonic()

    def write(self, data: bytes) -> None:
        for message in self._reader.feed(data):
            self.told.append((message.mid, message.data))
            self._out += self._answer(message.mid, message.data)

    def set_baud(self, baud: int) -> None:
        raise AssertionError

    def close(self) -> None:
        pass


def willing(mid: int, data: bytes) -> bytes:
    if mid == 0x0C:
        return frame(0x0D, bytes(102) + (22).to_bytes(2, "big") + bytes(14))
    return frame(mid + 1, data if mid == 0xC0 else b"")


def ignore(_data: bytes, _heard_s: float) -> None:
    pass


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(begin_xsens, "ANSWER_S", 0.05)


@pytest.mark.parametrize(("wanted", "period", "skip", "rate"), [
    (100, 1152, 0, 100), (512, 225, 0, 512), (50, 1152, 1, 50), (200, 576, 0, 200),
    (1000, 225, 0, 512),
])
def test_a_legacy_mti_is_set_to_raw_output_with_counter(
    wanted: float, period: int, skip: int, rate: float
) -> None:
    device = PaperDevice(willing)
    begun = start_mtdata(device, wanted, ignore)
    assert begun.rate_hz == pytest.approx(rate)
    told = dict(device.told)
    assert told[0xD0] == bytes.fromhex("4000")
    assert told[0xD2] == bytes.fromhex("00000001")
    assert told[0x04] == period.to_bytes(2, "big")
    assert told[0xD4] == skip.to_bytes(2, "big")
    order = [mid for mid, _ in device.told]
    assert (order[0], order[-1]) == (0x30, 0x10)


def test_a_newer_mti_sends_counter_time_and_raw_readings() -> None:
    device = PaperDevice(willing)
    assert start_mtdata2(device, 100, ignore).rate_hz == 100
    assert dict(device.told)[0xC0] == bytes.fromhex("1020FFFF 1060FFFF A0100064")


def test_firmware_that_does_not_combine_them_sends_raw_readings_alone() -> None:
    def answer(mid: int, data: bytes) -> bytes:
        if mid == 0xC0 and len(data) > 4:
            return frame(0x42, b"\x21")
        return willing(mid, data)

    device = PaperDevice(answer)
    assert start_mtdata2(device, 100, ignore).rate_hz == 100
    assert [data for mid, data in device.told if mid == 0xC0][-1] == bytes.fromhex("A0100064")


def test_a_streaming_mti_that_overlooks_the_request_is_reset() -> None:
    state = {"reset": False}

    def answer(mid: int, data: bytes) -> bytes:
        if mid == 0x40:
            state["reset"] = True
            return frame(0x3E)
        if not state["reset"]:
            return frame(0x32, bytes(22))  # it goes on streaming
        return b"" if mid == 0x3F else willing(mid, data)

    device = PaperDevice(answer)
    start_mtdata(device, 100, ignore)
    assert (0x3F, b"") in device.told  # WakeUp is acknowledged, or it would measure again


@pytest.mark.parametrize(("code", "message"), [
    (0x03, "sampling period"), (0x04, "the other kind of MTi"), (0x29, "baud rate is too low"),
    (0x77, "manual's list"),
])
def test_errors_of_the_device_are_put_in_words(code: int, message: str) -> None:
    def answer(mid: int, data: bytes) -> bytes:
        return frame(0x42, bytes([code])) if mid == 0x04 else willing(mid, data)

    with pytest.raises(DeviceError, match=message):
        start_mtdata(PaperDevice(answer), 100, ignore)


def test_a_device_that_would_send_something_else_is_refused() -> None:
    def answer(mid: int, data: bytes) -> bytes:
        return frame(0x0D, bytes(118)) if mid == 0x0C else willing(mid, data)

    with pytest.raises(DeviceError, match="it will send 0 bytes a sample; 22 are expected"):
        start_mtdata(PaperDevice(answer), 100, ignore)


def test_silence_is_told() -> None:
    with pytest.raises(DeviceError, match="does not answer message 0x30"):
        start_mtdata(PaperDevice(lambda mid, data: b""), 100, ignore)
