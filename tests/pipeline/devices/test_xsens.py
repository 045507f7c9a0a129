"""The Xsens protocol against worked frames, captured streams and damaged ones."""

import json

import pytest

from pipeline.devices.xbus import Message, XbusReader
from pipeline.devices.xsens_mtdata import MtDataParser
from tests.pipeline.devices.real_streams import captured
from tests.pipeline.devices.xbus_frame import frame

RAW_SAMPLE = bytes.fromhex("FA FF 32 16 8154 8231 8E4D 8012 7EAD 7EF3 8000 8000 8000 1910 0001 7E")


@pytest.mark.parametrize("length", [0, 22, 253, 254])
def test_a_message_of_any_length_reads_back(length: int) -> None:
    data = bytes(i % 256 for i in range(length))
    reader = XbusReader()
    assert reader.feed(frame(0x36, data)) == [Message(0x36, data)]
    assert reader.bad == 0


def test_raw_readings_are_the_ten_words() -> None:
    parser = MtDataParser()
    (sample,) = parser.feed(RAW_SAMPLE)
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
    (sample,) = MtDataParser().feed(frame(0x32, bytes(data)))
    assert dict(sample.columns)["temperature_c"] == celsius


@pytest.mark.parametrize("piece", [1, 7, 1000, 10**6])
def test_the_damaged_stream_yields_exactly_its_valid_frames(piece: int) -> None:
    data = captured("xsens_mtdata_raw_from_imu_tk", "dirty.bin").read_bytes()
    clean = captured("xsens_mtdata_raw_from_imu_tk", "clean.bin").read_bytes()
    events = json.loads(captured("xsens_mtdata_raw_from_imu_tk", "dirty.events.json").read_text())
    whole, parser = MtDataParser(), MtDataParser()
    samples = [s for i in range(0, len(data), piece) for s in parser.feed(data[i : i + piece])]
    assert len(samples) == events["valid_frames_expected"] == 2963
    assert {*samples} <= {*whole.feed(clean)}
    visible = [what for _, what in events["events"] if what != "dropped"]
    assert parser.bad == len(visible) + 1  # and the frame in which the stream begins
    assert whole.bad == 0


@pytest.mark.parametrize("session", range(1, 6))
def test_all_checksums_of_a_captured_stream_hold(session: int) -> None:
    """MTData2 of a newer MTi: the same messages with data that are not read."""
    data = captured("xsens_mtdata2_einride", f"{session}_output.bin").read_bytes()
    reader = XbusReader()
    assert (len(reader.feed(data)), reader.bad) == (100, 0)
    assert MtDataParser().feed(data) == []


def test_output_without_raw_readings_is_answered_with_what_to_do() -> None:
    parser = MtDataParser()
    assert parser.feed(frame(0x32, bytes(36))) == []
    assert "output mode 0x4000" in parser.advice


def test_a_false_start_hides_no_message() -> None:
    false = bytes.fromhex("FA FF 36 FF 07 FF")  # announces bytes that are those of messages
    reader = XbusReader()
    assert len(reader.feed(false + RAW_SAMPLE * 100)) == 100
    assert reader.bad == 1
