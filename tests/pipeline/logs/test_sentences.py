"""Lines of any length are sorted by their manner in a time that grows with their length only."""

import time

import pytest

from pipeline.logs.row_kinds import lines_by_kind
from pipeline.logs.sentence_names import names_of_sample
from pipeline.logs.sentences import rows_of_lines

LONG = 5000


@pytest.mark.parametrize("line", [
    "ab cd ", "1.25 -3.5 ", "1 2 | ", "1", " ", "a ", "a: ", "12:", "1,", "A", ".", "(", "1.25e",
])
def test_twice_the_length_takes_about_twice_the_time(line: str) -> None:
    """Where a pattern is tried at every start with every length, it takes four or eight times."""
    took = []
    for length in (LONG, 2 * LONG):
        lines = [(line * length)[:length] + end for end in ("", "|", " x", ")")]
        begun = time.process_time()
        assert len(rows_of_lines(lines)) == len(lines)
        took.append(time.process_time() - begun)
    assert took[1] < 3.3 * took[0] + 0.05


def test_a_tag_in_the_cell_of_a_quiet_axis_takes_no_number_with_it() -> None:
    """i2cdevlib's `a/g: ` before tabs, or commas; the first axis has three values."""
    for sign in "\t,":
        rows = rows_of_lines(["", *(
            sign.join([f"a/g: {100 + i % 3}", *map(str, range(i, i + 5))]) for i in range(400))])
        assert rows[1] == "100,0,1,2,3,4"


def test_rows_of_the_kinds_of_sensors_are_read_under_the_names_of_their_message() -> None:
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
             "FMT, 163, 58, IMU, QBfff, TimeUS,I,GyrX,GyrY,GyrZ", "PARM, 1, RATE, 400",
             *["IMU, 10, 0, 0.1, 0.2, 0.3", "IMU, 20, 0, 0.1, 0.2, 0.3", "ATT, 20, 1.5"] * 30]
    tables = lines_by_kind(lines)
    assert [*tables] == ["IMU"]
    assert tables["IMU"][1:6] == ["FMT,TimeUS,I,GyrX,GyrY,GyrZ", "", lines[3], lines[4], ""]


def test_two_sensors_that_take_turns_are_apart_though_every_number_has_its_name() -> None:
    lines = [f"09:00:{i // 2:02d}: IMU {{TimeUS : {i // 2}, I : {i % 2}, GyrX : {i % 2}.{i:02d}, "
             f"AccX : {0.1 * i:.1f}, AccZ : {9.8 - 3 * (i % 2):.2f}}}" for i in range(60)]
    tables = lines_by_kind(lines)
    assert {kind: sum(map(bool, table)) for kind, table in tables.items()} == {
        "I : 0": 30, "I : 1": 30}


def test_numbers_of_a_fixed_width_in_brackets_are_cells() -> None:
    rows = rows_of_lines(["", *(f"{t:.2f} [{v: .3f} {-v: .3f} {v: .3f}]"
                             for t, v in enumerate([0.5, -0.25] * 20))])
    assert rows[2] == "1.00,-0.250,0.250,-0.250"


def test_numbers_behind_one_letter_and_a_colon_are_cells() -> None:
    assert rows_of_lines(["", *["A:-12,34,998;G:120,-30,5"] * 40])[1] == "-12,34,998,120,-30,5"


def test_a_constant_in_brackets_in_a_cell_leaves_a_table_as_it_is() -> None:
    table = ["t,x,y,z,covariance", *(f'{i},{i}.1,0.2,9.8,"(0.1, 0.0, 0.1)"' for i in range(50))]
    assert rows_of_lines(table) == table


def test_a_time_of_the_day_before_numbers_that_have_names_is_the_clock() -> None:
    rows = rows_of_lines(["", *(f"14:05:{i:02d}.5  Raw: acc: x={i}.1 g, y=0.2 g, z=0.3 g"
                             for i in range(50))])
    assert rows[8] == "14:05:07.5,7.1,0.2,0.3"


def test_a_stamp_before_an_empty_line_belongs_to_the_sample_above_it() -> None:
    """The sketch's greeting ends with an empty line, too, and its stamp is no sample's."""
    lines = ["19:23:20.250 -> MPU6050 Found!", "19:23:20.250 -> "]
    for i in range(20):
        stamp = f"19:23:20.{300 + 10 * i} -> "
        lines += [f"{stamp}Acceleration X: {i}.5, Y: 0.1, Z: 9.8 m/s^2",
                  f"{stamp}Rotation X: 0.0, Y: 0.0, Z: 0.1 rad/s", stamp]
    rows = [line for line in rows_of_lines(lines) if line[:2] == "19"]
    assert [row.split(",")[:2] for row in rows] == [
        [f"19:23:20.{300 + 10 * i}", f"{i}.5"] for i in range(20)]


def test_the_signs_of_nested_keys_and_the_tags_of_a_line_are_no_part_of_a_name() -> None:
    rows = rows_of_lines(["", *(f'imu: {{"acc_g": {{"x": 0.{i}, "y": 0.1, "z": 1}}, '
                                f'"gyro": {{"x": {i}.5, "y": 2, "z": 3}}}}' for i in range(40))])
    assert rows[0] == "imu acc_g x,imu acc_g y,imu acc_g z,gyro x,gyro y,gyro z"
    rows = rows_of_lines(["", *(f"<inf> imu: accel x:0.{i} ms/2 y:0.1 ms/2 z:1 ms/2"
                                for i in range(40))])
    assert (rows[0], rows[2]) == ("inf imu accel x,ms/2 y,ms/2 z", "0.1,0.1,1")
    rows = rows_of_lines(["", *(f"t={8 * i}ms raw acc=(-679, {i}, 7764)" for i in range(40))])
    assert rows[0] == "t (ms),raw acc x,raw acc y,raw acc z"
    rows = rows_of_lines(["", *(f"imu,board=esp32 ax=0.{i},ay=0.1,az=1 17672256000{i:02d}0000000"
                                for i in range(40))])
    assert rows[0] == "ax,ay,az,t"  # the stamp behind the readings is the time


@pytest.mark.parametrize(("line", "names"), [
    ("raw ax: 12 raw ay: 13 raw az: 14", ["raw ax", "raw ay", "raw az"]),
    ("t 0.01 s raw ax 1 raw ay 2 raw az 4", ["t (s)", "raw ax", "raw ay", "raw az"]),
    ("12:00:01.3 raw ax 12 raw ay 3 raw az 5", ["", "raw ax", "raw ay", "raw az"]),
    ("t: 12 ms dt: 10 ms ax: 3 g ay: 4 g az: 5 g gx: 4 dps",
     ["t (ms)", "dt (ms)", "ax (g)", "ay (g)", "az (g)", "gx (dps)"])])
def test_the_word_of_a_unit_before_each_axis_is_a_part_of_its_name(
    line: str, names: list[str]
) -> None:
    assert names_of_sample([line]) == names
