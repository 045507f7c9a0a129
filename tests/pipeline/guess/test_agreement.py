"""What must agree before a guess is believed, and what is asked where several readings remain."""

import json
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.errors import UnreadableInput
from pipeline.guess.agreement import disagreements, unused_accelerometer
from pipeline.guess.files import guess_files
from pipeline.guess.session import SessionGuess, guess_session
from pipeline.guess.turns import turn_of
from pipeline.logs.clock import unwrapped_ticks
from pipeline.logs.formats.json_lines import tables
from tests.pipeline.guess.hand_log import HandLog, hand_log

DEG = np.pi / 180
NAMES = ("t", "ax", "ay", "az", "gx", "gy", "gz")


@pytest.fixture(scope="module")
def log() -> HandLog:
    return hand_log(rests=10, rate_hz=50.0)


def columns_text(names: tuple[str, ...], *columns: np.ndarray) -> str:
    rows = np.column_stack(columns)
    return "\n".join([",".join(names), *(",".join(f"{v:.6f}" for v in row) for row in rows)])


def guess(path: Path, names: tuple[str, ...], *columns: np.ndarray) -> SessionGuess:
    path.write_text(columns_text(names, *columns), encoding="utf-8")
    found, _ = guess_files([path], None)
    return guess_session(found)


@pytest.mark.parametrize(("turned", "axes"), [
    (np.eye(3), "+x, +y, +z"),
    (-np.eye(3), "-x, -y, -z"),
    (np.diag([1.0, 1.0, -1.0]), "+x, +y, -z"),
    (Rotation.from_euler("z", 90, degrees=True).as_matrix(), "-y, +x, +z"),
])
def test_turns_of_gravity_show_unit_order_sign_and_hand(
    log: HandLog, turned: np.ndarray, axes: str
) -> None:
    turn = turn_of(log.gyr @ turned.T / DEG, log.acc, np.zeros(len(log.acc), np.int64), 0.02)
    assert turn is not None
    assert turn.is_sure
    assert turn.is_exact
    assert turn.si_per_unit == pytest.approx(DEG, rel=0.01)
    assert turn.axes == axes


def test_columns_without_names_are_told_by_gravity_and_its_turns(
    tmp_path: Path, log: HandLog
) -> None:
    found = guess(tmp_path / "a.csv", tuple("abcdefg"), log.time_s, log.gyr / DEG, log.acc)
    assert found.gyroscope is not None
    assert found.accelerometer is not None
    assert (found.gyroscope.columns, found.gyroscope.unit) == (("b", "c", "d"), "°/s")
    assert (found.accelerometer.columns, found.accelerometer.unit) == (("e", "f", "g"), "m/s²")
    assert not [*disagreements(found)]


def test_a_unit_that_only_turns_in_another_file_show_is_that_unit(
    tmp_path: Path, log: HandLog
) -> None:
    for name, values in (("acc.csv", log.acc), ("gyr.csv", log.gyr / DEG)):
        (tmp_path / name).write_text(columns_text(("t", "x", "y", "z"), log.time_s, values),
                                     encoding="utf-8")
    found, _ = guess_files([tmp_path / "acc.csv", tmp_path / "gyr.csv"], None)
    gyroscope = guess_session(found).gyroscope
    assert gyroscope is not None
    assert gyroscope.unit == "°/s"


def test_a_unit_that_nothing_shows_is_asked(tmp_path: Path, log: HandLog) -> None:
    rest = log.rest == 0
    gyr = log.gyr[rest] / DEG * 0.2  # 0.01 °/s of noise, or 0.7 °/s of a sensor in rad/s
    found = guess(tmp_path / "a.csv", NAMES, log.time_s[rest], log.acc[rest], gyr)
    assert [choice.answer for choice in found.scales] == ["deg_s", "rad_s"]
    assert guess_session(found.tables, per_deg=1.0).scales == ()


@pytest.mark.parametrize(("per_deg", "unit"), [
    (1.0, "°/s"), (10.0, "0.1 °/s"), (100.0, "0.01 °/s"), (3600.0, "°/h"),
    (114.286, "counts, 114.286 per °/s, twos-complement"),
    (131.072, "counts, 131.072 per °/s, twos-complement"),
])
def test_whole_numbers_of_a_gyroscope_are_in_the_unit_that_turns_gravity(
    tmp_path: Path, log: HandLog, per_deg: float, unit: str
) -> None:
    found = guess(tmp_path / "a.csv", NAMES, log.time_s, np.rint(log.acc / 9.80665 * 2048),
                  np.rint(log.gyr / DEG * per_deg))
    assert found.gyroscope is not None
    assert found.gyroscope.unit == unit


def test_a_range_that_no_sensor_has_is_refused_and_a_stated_one_believed(
    tmp_path: Path, log: HandLog
) -> None:
    found = guess(tmp_path / "a.csv", NAMES, log.time_s, np.rint(log.acc / 9.80665 * 2048),
                  np.rint(log.gyr / DEG * 42.0))
    fault, = disagreements(found)
    assert "--gyroscope-range" in fault
    assert [*disagreements(guess_session(found.tables, per_deg=42.0))] == []


def test_what_reads_alike_in_every_rest_is_the_gyroscope(tmp_path: Path, log: HandLog) -> None:
    field = np.rint(log.acc @ Rotation.from_euler("x", 70, degrees=True).as_matrix() * 20)
    for pose in range(10):
        rows = np.column_stack([np.rint(log.acc / 9.80665 * 4096), field,
                                np.rint(log.gyr / DEG * 32.8)])[log.rest == pose]
        np.savetxt(tmp_path / f"{pose}.csv", rows, fmt="%.0f", delimiter=",")
    found = guess_session(guess_files(sorted(tmp_path.glob("*.csv")), None)[0])
    assert found.gyroscope is not None
    assert found.gyroscope.columns == ("7", "8", "9")


def test_a_clock_that_ticks_in_bursts_gives_the_rate_and_noise_called_t_does_not(
    tmp_path: Path, log: HandLog
) -> None:
    bursts = guess(tmp_path / "a.csv", ("t_s", *NAMES[1:]), log.time_s // 0.1 / 10, log.acc,
                   log.gyr)
    assert bursts.tables[0].clock.rate_hz == pytest.approx(50.0, rel=0.01)
    noise = np.random.default_rng(1).normal(25, 0.1, len(log.acc))
    warm = guess(tmp_path / "b.csv", (*NAMES[1:], "T"), log.acc, log.gyr / DEG, noise)
    assert warm.tables[0].clock.rate_hz == pytest.approx(50.0, rel=0.05)


def test_a_clock_in_another_unit_than_its_name_states_is_refused(
    tmp_path: Path, log: HandLog
) -> None:
    names = ("time_s", "acc_x", "acc_y", "acc_z", "gx (rad/s)", "gy (rad/s)", "gz (rad/s)")
    found = guess(tmp_path / "a.csv", names, log.time_s / 5, log.acc, log.gyr)
    fault, = disagreements(found)
    assert "its clock or its unit" in fault


def test_a_log_that_ends_before_poses_can_be_laid_is_refused(tmp_path: Path, log: HandLog) -> None:
    found = guess(tmp_path / "a.csv", NAMES[:4], log.time_s / 20, log.acc)
    fault, = disagreements(found)
    assert "nobody lays 6 poses" in fault


def test_an_accelerometer_without_gravity_is_no_session_of_a_gyroscope(
    tmp_path: Path, log: HandLog
) -> None:
    up = log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    names = ("t", *(f"userAccel{axis}" for axis in "XYZ"), *(f"gravity{axis}" for axis in "XYZ"),
             *(f"rotationRate{axis}" for axis in "XYZ"))
    found = guess(tmp_path / "a.csv", names, log.time_s, log.acc / 9.80665 - up, up, log.gyr)
    assert "Write gravityX + userAccelX, gravityY + userAccelY" in unused_accelerometer(found)


def test_rows_of_json_that_hold_several_samples_are_unrolled(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("".join(json.dumps(
        {"t": 40 * i, "acc": [{"x": 4 * i + k, "y": 0.5, "z": 1} for k in range(4)],
         "gyr": [[1.5, 2.5, 3.5]] * 4}) + "\n" for i in range(3)), encoding="utf-8")
    table, = tables(path)
    np.testing.assert_array_equal(table.columns["t"], 10.0 * np.arange(12))
    np.testing.assert_array_equal(table.columns["acc.x"], np.arange(12))
    assert {"acc.y", "gyr[2]"} <= table.columns.keys()


@pytest.mark.parametrize("text", [
    '{"at": [0, 1], "acc": {"x": [1, 2], "y": [3, 4], "z": [5, 6]}, "by": "me"}',
    "{'at': 0, 'acc.x': 1, 'acc.y': 3, 'acc.z': 5}\n{'at': 1, 'acc.x': 2, 'acc.y': 4, 'acc.z': 6}",
])
def test_columns_in_objects_and_dictionaries_of_python_are_samples(
    tmp_path: Path, text: str
) -> None:
    path = tmp_path / "a.json"
    path.write_text(text, encoding="utf-8")
    table, = tables(path)
    np.testing.assert_array_equal([table.columns[f"acc.{axis}"] for axis in "xyz"],
                                  [[1, 2], [3, 4], [5, 6]])


def test_lists_of_objects_in_one_object_are_a_table_each(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    rows = [{"t": i, "v": "1.5,2.5,-3"} for i in range(3)]
    path.write_text(json.dumps({"accelerometer": rows, "gyroscope": rows[:2]}), encoding="utf-8")
    force, rate = tables(path)
    assert (force.name, rate.name) == ("accelerometer", "gyroscope")
    np.testing.assert_array_equal(force.columns["v[2]"], [-3, -3, -3])


def test_poses_in_one_archive_are_no_copies_of_one_recording(tmp_path: Path, log: HandLog) -> None:
    with ZipFile(tmp_path / "poses.zip", "w") as archive:
        for rest in range(8):
            at = log.rest == rest
            archive.writestr(f"pose_{rest}.csv", columns_text(
                NAMES[:4], log.time_s[at] - log.time_s[at][0], log.acc[at]))
    found, _ = guess_files([tmp_path / "poses.zip"], None)
    assert len(guess_session(found).tables) == 8


def test_a_number_that_names_the_sensor_of_a_row_is_no_reading(
    tmp_path: Path, log: HandLog
) -> None:
    events = [f"{1000 * t:.0f},{kind},{','.join(f'{v:.4f}' for v in row)}"
              for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)
              for kind, row in ((1, a), (4, w))]
    (tmp_path / "a.csv").write_text("\n".join(["ts,type,x,y,z", *events]), encoding="utf-8")
    guess = guess_session(guess_files([tmp_path / "a.csv"], None)[0])
    assert [(table.path.name, table.gyroscope is None) for table in guess.tables] == [
        ("1", True), ("4", False)]


def test_kinds_of_objects_and_values_for_a_plotter_are_samples(
    tmp_path: Path, log: HandLog
) -> None:
    (tmp_path / "a.jsonl").write_text("\n".join(
        json.dumps({"type": kind, "ts": round(1000 * t), "v": list(row)})
        for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)
        for kind, row in (("acc", a), ("gyr", w))), encoding="utf-8")
    (tmp_path / "plot.txt").write_text("\n".join(
        f">{name}:{1000 * t:.0f}:{value:.4f}"
        for t, a, w in zip(log.time_s, log.acc, log.gyr / DEG, strict=True)
        for name, value in zip(("ax", "ay", "az", "gx", "gy", "gz"), (*a, *w), strict=True)),
        encoding="utf-8")
    for path, unit in ((tmp_path / "a.jsonl", "rad/s"), (tmp_path / "plot.txt", "°/s")):
        found = guess_session(guess_files([path], None)[0])
        assert found.accelerometer is not None
        assert found.gyroscope is not None
        assert (found.accelerometer.unit, found.gyroscope.unit) == ("m/s²", unit)


def test_an_acceleration_without_gravity_is_in_no_other_unit(tmp_path: Path, log: HandLog) -> None:
    up = log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    names = ("t", "X (m/s^2)", "Y (m/s^2)", "Z (m/s^2)")
    with pytest.raises(UnreadableInput, match="gravity is removed"):
        guess(tmp_path / "a.csv", names, log.time_s, log.acc - 9.8 * up)


def test_a_cell_with_the_samples_of_a_row_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    cell = "|".join(map(str, range(25)))
    path.write_text("t,x,y,z\n" + f"1,{cell},{cell},{cell}\n" * 9, encoding="utf-8")
    with pytest.raises(UnreadableInput, match="3 cells of each row hold 25 numbers each"):
        guess_files([path], None)


def test_a_clock_that_shows_hours_and_minutes_is_in_seconds_of_the_day() -> None:
    np.testing.assert_allclose(unwrapped_ticks(np.array([100059.0, 100059.5, 100100.0, 100100.5])),
                               36059 + np.array([0.0, 0.5, 1.0, 1.5]))
    counter = np.arange(100058.0, 100104.0)  # goes on behind 59
    np.testing.assert_array_equal(unwrapped_ticks(counter), counter)


def test_the_code_page_is_that_in_which_units_are_units(tmp_path: Path, log: HandLog) -> None:
    names = ("Zaman (s)", *(f"İvme {axis} (m/s²)" for axis in "XYZ"),
             *(f"Açısal Hız {axis} (°/s)" for axis in "XYZ"))
    path = tmp_path / "a.csv"
    path.write_bytes(columns_text(names, log.time_s, log.acc, log.gyr / DEG).encode("cp1254"))
    found, _ = guess_files([path], None)
    gyroscope = guess_session(found).gyroscope
    assert gyroscope is not None
    assert gyroscope.because == "their names, which state the unit"


def test_increments_from_sample_to_sample_have_their_exact_unit(
    tmp_path: Path, log: HandLog
) -> None:
    found = guess(tmp_path / "a.csv", ("time", "dvx", "dvy", "dvz", "dax", "day", "daz"),
                  log.time_s, log.acc / 50, log.gyr / 50)
    assert found.gyroscope is not None
    assert found.accelerometer is not None
    assert found.gyroscope.si_per_unit == pytest.approx(50)
    assert found.accelerometer.si_per_unit == pytest.approx(50)
    assert not [*disagreements(found)]


@pytest.mark.parametrize(("columns", "says"), [
    ([0, 0, 2, 3, 4, 5], "'ax' and 'ay'"), ([0, 1, 2, 2, 4, 5], "'az' and 'gx'")])
def test_one_axis_that_is_written_twice_is_refused(
    tmp_path: Path, log: HandLog, columns: list[int], says: str
) -> None:
    both = np.hstack([log.acc, log.gyr])[:, columns]
    found = guess(tmp_path / "a.csv", NAMES, log.time_s, both[:, :3], both[:, 3:])
    assert f"{says} hold the same numbers" in next(disagreements(found))


def test_a_gyroscope_of_zeros_is_none(tmp_path: Path, log: HandLog) -> None:
    found = guess(tmp_path / "a.csv", NAMES, log.time_s, log.acc, 0 * log.gyr)
    assert found.gyroscope is None
    assert "left are gx, gy, gz" in found.doubts[0]


def test_noise_is_no_counter_that_begins_again() -> None:
    for noise in (np.rint(np.random.default_rng(4).normal(0, 20, 400)),
                  np.array([56, -16, -76, 68, -28, -60, -76, -96.0])):
        assert (np.diff(unwrapped_ticks(noise)) < 0).any()
    counter = np.arange(2000.0) % 256
    np.testing.assert_array_equal(unwrapped_ticks(counter), np.arange(2000.0))
