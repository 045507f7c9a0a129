"""Lines of text: every excerpt of what real sketches print, and what must not be a sample."""

import gzip

import numpy as np
import pytest

from pipeline.devices.line_pattern import (
    LONGEST_LINE,
    LinePattern,
    LinePatternParser,
    crc8,
    sketch_line,
)
from pipeline.devices.mpu6050_text import Mpu6050TextParser
from pipeline.devices.sample import Sample
from tests.pipeline.devices.real_streams import begun, captured

COUNTS = "counts"


def parse(text: str | bytes, parser: Mpu6050TextParser | None = None) -> list[Sample]:
    parser = parser or begun(Mpu6050TextParser())
    data = text.encode("latin-1") if isinstance(text, str) else text
    return parser.feed(data if data.endswith(b"\n") else data + b"\n")


@pytest.mark.parametrize(("name", "count", "first", "last"), [
    ("i2cdev_raw_offsets_printed_spaces", 8, (56, 48, 16384), (-96, -20, 16504)),
    ("i2cdev_raw_uncalibrated", 8, (1552, 48, 15776), (1524, -20, 15832)),
    ("pibits_demo_raw_printf", 6, (16804, 24, -3420), (16776, 28, -3528)),
])
def test_excerpts_of_raw_readings_are_read(
    name: str, count: int, first: tuple[float, ...], last: tuple[float, ...]
) -> None:
    parser = begun(Mpu6050TextParser())
    excerpt = captured("mpu6050_text_excerpts", f"{name}.txt").read_bytes()
    samples = parse(excerpt, parser)
    assert len(samples) == count
    assert (parser.bad, parser.unit, parser.advice) == (0, COUNTS, "")
    assert (samples[0].accelerometer, samples[-1].accelerometer) == (first, last)


@pytest.mark.parametrize("name", ["imu_zero_done_line", "xsens_mt_manager_2022_head"])
def test_excerpts_that_hold_no_readings_yield_none(name: str) -> None:
    assert parse(captured("mpu6050_text_excerpts", f"{name}.txt").read_bytes()) == []


def test_a_line_of_another_sketch_is_described_by_a_pattern() -> None:
    pattern = LinePattern.stated("{skip} -> X,Y,Z= {acc_x},{acc_y},{acc_z}")
    parser = begun(LinePatternParser(pattern))
    samples = parser.feed(captured(
        "mpu6050_text_excerpts", "arduino_ide_timestamped.txt").read_bytes() + b"\n")
    assert [sample.accelerometer for sample in samples] == [
        (-1.84, 2.93, -9.22), (-2.3, 2.0, -9.91), (-2.98, 1.32, -10.18)]


def test_columns_are_found_by_their_header() -> None:
    (sample,) = parse(
        captured("mpu6050_text_excerpts", "betaflight_blackbox_decode_head.csv").read_bytes())
    assert sample.gyroscope == (0, 3, 3)
    assert sample.accelerometer == (60, 8, 2232)
    assert sample.ticks == 55158008
    path = captured("xio_fusion_example", "sensor_data.head3000.csv.gz")
    parser = begun(Mpu6050TextParser())
    samples = parse(gzip.decompress(path.read_bytes()), parser)
    assert len(samples) >= 2999
    assert parser.unit == "g, deg/s"
    force = np.linalg.norm([sample.accelerometer for sample in samples], axis=1)
    assert np.median(force) == pytest.approx(1, abs=0.05)


def test_offsets_that_a_sketch_prints_first_are_no_sample() -> None:
    text = "Updating internal sensor offsets...\n"
    text += "\t1520\t-2407\t1582\t0\t0\t0\na/g:\t1\t2\t3\t4\t5\t6\n"
    assert [s.accelerometer for s in parse(text)] == [(1, 2, 3)]


@pytest.mark.parametrize("text", [
    "1,2,3,4,5,6\n", "AcX,AcY,AcZ,GyX,GyY,GyZ\n1,2,3,4,5,6\n",
    "n,ax,ay,az,gx,gy,gz\n0,1,2,3,4,5,6\n", "1; 2; 3; 4; 5; 6\n",
    "09:15:01.002 -> a/g:\t1\t2\t3\t4\t5\t6\n", "a/g:\t1\t2\t3\t4\t5\t6\r\n",
    "time_ms,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,temp\n17,1,2,3,4,5,6,25.1\n",
])
def test_usual_rows_are_read(text: str) -> None:
    (sample,) = parse(text)
    assert (sample.accelerometer, sample.gyroscope) == ((1, 2, 3), (4, 5, 6))


def test_numbers_that_nothing_explains_are_asked_about_not_guessed() -> None:
    parser = begun(Mpu6050TextParser())
    assert parse("1,2,3,4,5,6,7\n", parser) == []
    assert "`pattern`" in parser.advice


@pytest.mark.parametrize("line", [
    "a/g:\t1\t2\t3\t4\t5", "a/g:\t1\t2\t3\t4\t5\t70000", "a/g:\t1\t2\t3\t4\t5\t6\t7",
    "a/g:\t1\t2\t3\t4\t5\t6.5", "a/g:\t1\t2\t3\xff\t4\t5\t6", "a" * 3 * LONGEST_LINE,
])
def test_damaged_lines_are_counted_and_give_no_sample(line: str) -> None:
    parser = begun(Mpu6050TextParser())
    good = "a/g:\t1\t2\t3\t4\t5\t6\n"
    assert len(parse(good + line + "\n" + good, parser)) == 2
    assert parser.bad == 1


def test_the_half_line_at_the_beginning_is_left_out() -> None:
    parser = Mpu6050TextParser()
    assert [s.accelerometer for s in parse("384\t4\t5\t6\na/g:\t1\t2\t3\t4\t5\t6\n", parser)] == [
        (1, 2, 3)]
    assert parser.bad == 0


def test_orientation_from_the_chip_is_no_reading() -> None:
    assert parse("quat\t1.00\t0.00\t0.00\t0.00\n") == []


def test_crc8_is_the_catalogued_one() -> None:
    assert crc8(b"123456789") == 0xF4


def test_every_changed_character_of_a_sketch_line_is_noticed() -> None:
    line = sketch_line(7, 70123, (1, -2, 16384, 4, -5, 6, -3920))
    (sample,) = parse(line + "\n")
    assert (sample.accelerometer, sample.gyroscope, sample.ticks) == ((1, -2, 16384), (4, -5, 6),
                                                                      70123)
    assert dict(sample.columns)["temperature_c"] == pytest.approx(25.0, abs=0.01)
    parser = begun(Mpu6050TextParser())
    changed = [line[:i] + chr(ord(line[i]) ^ 1) + line[i + 1 :] for i in range(2, len(line) - 3)]
    assert parse("\n".join(changed) + "\n", parser) == []
    assert parser.bad == len(changed)


def test_the_sketch_is_preferred_to_everything_else_on_the_line() -> None:
    parser = begun(Mpu6050TextParser())
    line = sketch_line(0, 1, (1, 2, 3, 4, 5, 6, 0))
    samples = parse(f"#turntable v1 mpu6050 fs_a=2 fs_g=250 odr=100\n{line}\n9,9,9,9,9,9\n{line}\n",
                    parser)
    assert [s.accelerometer for s in samples] == [(1, 2, 3)] * 2
    assert parser.settings == {"fs_a": 2, "fs_g": 250, "odr": 100}


def test_any_line_can_be_described_by_a_pattern() -> None:
    pattern = LinePattern.stated("t={time_ms} A {acc_x}/{acc_y}/{acc_z} {skip} T{temperature_c}")
    parser = begun(LinePatternParser(pattern))
    (sample,) = parser.feed(b"t=12  A 1/-2/3.5 ok  T21.5\r\nnonsense\n")
    assert sample.accelerometer == (1, -2, 3.5)
    assert np.isnan(sample.gyroscope).all()
    assert (sample.ticks, sample.columns) == (12, (("temperature_c", 21.5),))
    assert parser.clock is not None
    assert parser.clock.tick_s == 1e-3
    assert parser.bad == 1


@pytest.mark.parametrize(("pattern", "says"), [
    ("{acc_x},{acc_y}", "acc_z missing"), ("{a b},{acc_x}", "no name of a column"),
    ("{acc_x}{acc_y},{acc_z}", "nothing separates"), ("hello", "neither acc_x"),
    ("{time_s},{time_ms},{acc_x},{acc_y},{acc_z}", "more than one time"),
])
def test_a_pattern_that_makes_no_log_is_refused(pattern: str, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        LinePattern.stated(pattern)


def test_a_pattern_no_line_fits_is_answered_with_the_line() -> None:
    parser = begun(LinePatternParser(LinePattern.stated("{acc_x},{acc_y},{acc_z}")))
    parser.feed(b"hello\n")
    assert "'hello'" in parser.advice


def test_a_number_is_never_cut_in_two_to_fit_a_pattern() -> None:
    """A blank between two numbers is a blank: a line of five numbers is none of six."""
    pattern = LinePattern.stated("{acc_x} {acc_y} {acc_z} {gyr_x} {gyr_y} {gyr_z}")
    parser = begun(LinePatternParser(pattern))
    assert parser.feed(b"1000 2 3 4 5\n") == []
    assert parser.bad == 1
