"""Xsens protocols against worked frames, captured streams and damaged ones."""

import json
import math
import re

import numpy as np
import pytest

from pipeline.devices.xsens import (
    LONGEST_DATA,
    PACKET_COUNTER,
    Message,
    XbusReader,
    XsensParser,
    frame,
    packets,
)
from tests.pipeline.devices.real_streams import captured

RAW_SAMPLE = bytes.fromhex("FA FF 32 16 8154 8231 8E4D 8012 7EAD 7EF3 8000 8000 8000 1910 0001 7E")
SAME_IN_MTDATA2 = bytes.fromhex("FA FF 36 1C 1020 02 0001 A010 14 8154 8231 8E4D 8012 7EAD 7EF3"
                                "8000 8000 8000 1910 7E")


@pytest.mark.parametrize(("mid", "data", "expected"), [
    (0x30, "", "FA FF 30 00 D1"), (0x10, "", "FA FF 10 00 F1"), (0x40, "", "FA FF 40 00 C1"),
    (0xD0, "4000", "FA FF D0 02 40 00 EF"), (0xD2, "00000001", "FA FF D2 04 00 00 00 01 2A"),
    (0x04, "0480", "FA FF 04 02 04 80 77"), (0xC0, "A0100064", "FA FF C0 04 A0 10 00 64 29"),
    (0xC0, "20100064", "FA FF C0 04 20 10 00 64 A9"), (0x22, "0006", "FA FF 22 02 00 06 D7"),
])
def test_frames_are_those_of_the_manual(mid: int, data: str, expected: str) -> None:
    assert frame(mid, bytes.fromhex(data)) == bytes.fromhex(expected)


@pytest.mark.parametrize("length", [0, 253, 254, 255, 256, LONGEST_DATA])
def test_a_frame_of_any_length_reads_back(length: int) -> None:
    data = bytes(i % 256 for i in range(length))
    reader = XbusReader()
    assert reader.feed(frame(0x36, data)) == [Message(0x36, data)]
    assert reader.bad == 0


@pytest.mark.parametrize("bytes_", [RAW_SAMPLE, SAME_IN_MTDATA2])
def test_raw_readings_are_the_ten_words(bytes_: bytes) -> None:
    parser = XsensParser()
    (sample,) = parser.feed(bytes_)
    assert sample.accelerometer == (33108, 33329, 36429)
    assert sample.gyroscope == (32786, 32429, 32499)
    assert sample.ticks == 1
    assert dict(sample.columns) == {"temperature_c": 25.0625}
    assert parser.clock is not None
    assert parser.clock.modulus == 65536


@pytest.mark.parametrize(("word", "celsius"), [
    ("1910", 25.0625), ("E6F0", -25.0625), ("0080", 0.5), ("FF80", -0.5)])
def test_temperature_is_two_s_complement(word: str, celsius: float) -> None:
    data = bytearray(RAW_SAMPLE[4:-1])
    data[18:20] = bytes.fromhex(word)
    (sample,) = XsensParser().feed(frame(0x32, bytes(data)))
    assert dict(sample.columns)["temperature_c"] == celsius


@pytest.mark.parametrize("piece", [1, 7, 1000, 10**6])
def test_the_damaged_stream_yields_exactly_its_valid_frames(piece: int) -> None:
    data = captured("xsens_mtdata_raw_from_imu_tk", "dirty.bin").read_bytes()
    clean = captured("xsens_mtdata_raw_from_imu_tk", "clean.bin").read_bytes()
    events = json.loads(captured("xsens_mtdata_raw_from_imu_tk", "dirty.events.json").read_text())
    whole, parser = XsensParser(), XsensParser()
    samples = [s for i in range(0, len(data), piece) for s in parser.feed(data[i : i + piece])]
    assert len(samples) == events["valid_frames_expected"] == 2963
    assert {*samples} <= {*whole.feed(clean)}
    visible = [what for _, what in events["events"] if what != "dropped"]
    assert parser.bad == len(visible) + 1  # and the frame in which the stream begins
    assert whole.bad == 0


@pytest.mark.parametrize("session", range(1, 6))
def test_all_checksums_of_the_captured_mtdata2_hold(session: int) -> None:
    data = captured("xsens_mtdata2_einride", f"{session}_output.bin").read_bytes()
    reader = XbusReader()
    messages = reader.feed(data)
    assert (len(messages), reader.bad) == (100, 0)
    counters = [int.from_bytes(data, "big") for message in messages
                for data_id, data in packets(message.data) if data_id == PACKET_COUNTER]
    first = 43398 + 100 * (session - 1)
    assert counters == list(range(first, first + 100))


@pytest.mark.parametrize("session", range(1, 5))
def test_calibrated_readings_are_those_another_decoder_found(session: int) -> None:
    parser = XsensParser()
    samples = parser.feed(captured("xsens_mtdata2_einride", f"{session}_output.bin").read_bytes())
    text = captured("xsens_mtdata2_einride", f"{session}_output.golden.head.txt").read_text()
    three = r"\n  X:(\S+)\n  Y:(\S+)\n  Z:(\S+)\n"
    for field, name in (("Acceleration", "accelerometer"), ("RateOfTurn", "gyroscope")):
        golden = np.array(re.findall(rf"(?m)^{field}\(.*\):{three}", text), dtype=float)
        assert len(golden) >= 5
        found = np.array([getattr(sample, name) for sample in samples])[: len(golden)]
        np.testing.assert_allclose(found, golden, rtol=1e-12, atol=1e-15)
    assert parser.unit == "m/s², rad/s"
    assert np.median(np.diff([sample.ticks or 0 for sample in samples])) == 100


def test_output_without_readings_is_answered_with_what_to_do() -> None:
    parser = XsensParser()
    parser.feed(captured("xsens_mtdata2_einride", "5_output.bin").read_bytes())
    assert "0xA010" in parser.advice
    legacy = XsensParser()
    legacy.feed(frame(0x32, bytes(36)))
    assert "output mode 0x4000" in legacy.advice


def test_a_false_start_hides_no_message() -> None:
    # FA FF 36 FF 07 FF announces 2047 bytes that never come.
    false = bytes.fromhex("FA FF 36 FF 07 FF")
    reader = XbusReader()
    found = reader.feed(false + RAW_SAMPLE * 100)
    assert len(found) == 100
    assert reader.bad == 1


def test_readings_that_are_no_numbers_are_damage() -> None:
    parser = XsensParser()
    nan = np.array([math.nan, 0, 0], ">f4").tobytes()
    assert parser.feed(frame(0x36, bytes.fromhex("4020 0C") + nan)) == []
    assert parser.bad == 1
