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

COUNTS, SI = "counts", "m/s², rad/s"


def parse(text: str | bytes, parser: Mpu6050TextParser | None = None) -> list[Sample]:
    parser = parser or begun(Mpu6050TextParser())
    data = text.encode("latin-1") if isinstance(text, str) else text
    return parser.feed(data if data.endswith(b"\n") else data + b"\n")


@pytest.mark.parametrize(("name", "count", "unit", "first", "last"), [
    ("adafruit_six_positions_se85054", 6, SI, (-0.06, 0.0, 8.44), (0.04, -9.93, -0.05)),
    ("arduino_ide_timestamped", 3, "unit not stated", (-1.84, 2.93, -9.22), (-2.98, 1.32, -10.18)),
    ("i2cdev_raw_offsets_printed_spaces", 8, COUNTS, (56, 48, 16384), (-96, -20, 16504)),
    ("i2cdev_raw_uncalibrated", 8, COUNTS, (1552, 48, 15776), (1524, -20, 15832)),
    ("pibits_demo_raw_printf", 6, COUNTS, (16804, 24, -3420), (16776, 28, -3528)),
    ("playground_krodal", 5, COUNTS, (260, 120, 15572), (212, 100, 15440)),
])
def test_every_excerpt_is_read(
    name: str, count: int, unit: str, first: tuple[float, ...], last: tuple[float, ...]
) -> None:
    parser = begun(Mpu6050TextParser())
    excerpt = captured("mpu6050_text_excerpts", f"{name}.txt").read_bytes()
    samples = parse(excerpt, parser)
    if len(samples) < count:  # the last is a block, which is complete where the next begins
        samples += parse(excerpt, parser)[:1]
    assert len(samples) == count
    assert (parser.bad, parser.unit, parser.advice) == (0, unit, "")
    assert (samples[0].accelerometer, samples[-1].accelerometer) == (first, last)


def test_excerpts_that_hold_no_readings_yield_none() -> None:
    parser = begun(Mpu6050TextParser())
    assert parse(captured("mpu6050_text_excerpts", "imu_zero_done_line.txt").read_bytes(),
                 parser) == []
    assert "IMU_Zero" in parser.advice
    head = captured("mpu6050_text_excerpts", "xsens_mt_manager_2022_head.txt").read_bytes()
    assert parse(head) == []


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


def test_temperature_and_gyro_of_a_block_belong_to_it() -> None:
    (sample,) = parse("Acceleration X: 0.10, Y: 0.05, Z: 9.76 m/s^2\n"
                      "Rotation X: 0.15, Y: -0.05, Z: 0.02 rad/s\nTemperature: 25.00 degC\n\n"
                      "Acceleration X: 0.11, Y: 0.05, Z: 9.76 m/s^2\n")
    assert sample == Sample((0.10, 0.05, 9.76), (0.15, -0.05, 0.02), None,
                            (("temperature_c", 25.0),))


def test_a_block_that_lost_a_line_is_no_sample() -> None:
    block = ("Acceleration X: 1, Y: 2, Z: 3 m/s^2\nRotation X: 4, Y: 5, Z: 6 rad/s\n"
             "Temperature: 7 degC\n\n")
    without = block.replace("Rotation X: 4, Y: 5, Z: 6 rad/s\n", "")
    parser = begun(Mpu6050TextParser())
    samples = parse(block + without + 2 * block, parser)
    assert [sample.gyroscope for sample in samples] == [(4, 5, 6)] * 2
    assert parser.bad == 1


def test_offsets_that_a_sketch_prints_first_are_no_sample() -> None:
    text = "Updating internal sensor offsets...\n"
    text += "\t1520\t-2407\t1582\t0\t0\t0\na/g:\t1\t2\t3\t4\t5\t6\n"
    assert [s.accelerometer for s in parse(text)] == [(1, 2, 3)]


@pytest.mark.parametrize("text", [
    "1,2,3,4,5,6\n", "Data,1,2,3,4,5,6\n", "AcX,AcY,AcZ,GyX,GyY,GyZ\n1,2,3,4,5,6\n",
    "n,ax,ay,az,gx,gy,gz\n0,1,2,3,4,5,6\n", "1; 2; 3; 4; 5; 6\n",
    "AccelX:1,AccelY:2,AccelZ:3, GyroX:4,GyroY:5,GyroZ:6\n",
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


def test_orientation_from_the_chip_is_refused_in_words() -> None:
    parser = begun(Mpu6050TextParser())
    assert parse("quat\t1.00\t0.00\t0.00\t0.00\n", parser) == []
    assert "not raw readings" in parser.advice


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
