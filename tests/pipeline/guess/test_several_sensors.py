"""Rows of several sensors in turn in one text, as an app for phones writes them; files of two."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.console.import_text import guess_lines
from pipeline.guess.files import guess_files
from pipeline.guess.session import SessionGuess, guess_session
from tests.pipeline.guess.hand_log import hand_log
from tests.sessions import pipeline, run_without_page

LOST = 37  #: every so many lines one is lost
RATE_HZ = 25.0


def write_phone(path: Path) -> Path:
    """Kind, time of the phone, time of the sensor, readings, accuracy; no header."""
    log, lines = hand_log(rate_hz=RATE_HZ), []
    sensors = (("ACCE", log.acc, 1), ("GYRO", log.gyr, 1), ("MAGN", 40 * log.field, 2),
               ("AHRS", 180 * log.field, 3))
    for i, time_s in enumerate(log.time_s):
        lines += [f"{kind};{time_s + 7:.4f};{time_s:.4f};{x:.5f};{y:.5f};{z:.5f};3"
                  for kind, (x, y, z), each in ((kind, values[i], each)
                                                for kind, values, each in sensors) if i % each == 0]
    path.write_text("\n".join(line for i, line in enumerate(lines) if i % LOST), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def phone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_phone(tmp_path_factory.mktemp("phone") / "phone.txt")


@pytest.fixture(scope="module")
def guess(phone: Path) -> SessionGuess:
    tables, passed_over = guess_files([phone], None)
    assert not [note for note in passed_over if "MAGN" in note or "AHRS" in note]
    return guess_session(tables)


def test_the_time_of_the_sensor_beside_that_of_the_phone_is_no_axis(guess: SessionGuess) -> None:
    assert {table.path.name: [triad and triad.columns for triad in (
        table.accelerometer, table.gyroscope)] for table in guess.tables} == {
            "ACCE": [("4", "5", "6"), None], "GYRO": [None, ("4", "5", "6")]}


def test_nothing_is_doubted_of_sensors_that_are_not_used(guess: SessionGuess) -> None:
    assert guess.doubts == ()


def test_the_rate_is_that_of_the_sensor_whatever_rows_are_lost(guess: SessionGuess) -> None:
    assert sum(f" {RATE_HZ:g} Hz" in line for line in guess_lines(guess)) == len(guess.tables)


def test_a_log_of_all_sensors_is_corrected_by_the_tables_of_its_session(
    phone: Path, tmp_path: Path
) -> None:
    config = tmp_path / "c.yaml"
    assert pipeline("import", phone, "--output", config, "--latitude", "45") == 0
    run_without_page(config)
    again, out = write_phone(tmp_path / "again.txt"), tmp_path / "out.csv"
    assert pipeline("apply", tmp_path / "c.run", again, "--output", out) == 0
    assert out.read_text(encoding="utf-8").startswith("time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,gyr")
    forces = np.loadtxt(out, delimiter=",", skiprows=1, usecols=(1, 2, 3))
    assert np.median(np.linalg.norm(forces, axis=1)) == pytest.approx(9.8067, abs=0.01)
    alone = tmp_path / "alone.csv"
    assert pipeline("apply", tmp_path / "c.run", again / "GYRO", "--output", alone) == 0
    assert alone.read_text(encoding="utf-8").startswith("time_s,gyr_x")


def test_rows_of_a_magnetometer_between_those_of_the_sensor_are_no_samples(tmp_path: Path) -> None:
    """One table with blanks; readings interpolated at the times of the others were taken for some.
    """
    log = hand_log(rate_hz=RATE_HZ)
    rows = []
    for i, time_s in enumerate(log.time_s):
        rows.append([time_s, *log.acc[i], *log.gyr[i], "", "", ""])
        rows += [[time_s + 0.0101, *[""] * 6, *(40 * log.field[i])]] if i % 3 == 0 else []
    names = ["time", *(f"{kind}_{axis}" for kind in ("acc", "gyr", "mag") for axis in "xyz")]
    (tmp_path / "log.csv").write_text(
        "\n".join(",".join(map(str, row)) for row in (names, *rows)), encoding="utf-8")
    (table,) = guess_session(guess_files([tmp_path / "log.csv"], None)[0]).tables
    np.testing.assert_allclose(table.clock.time_s, log.time_s)
    assert table.accelerometer is not None
    np.testing.assert_allclose(table.si(table.accelerometer), log.acc)


def test_the_unit_of_a_clock_is_told_where_its_name_is_a_known_program_s(tmp_path: Path) -> None:
    log = hand_log(rate_hz=RATE_HZ)
    np.savetxt(tmp_path / "log.csv", np.column_stack([1000 * log.time_s, log.acc]), "%.4f", ",",
               header="time_ms,acc_x,acc_y,acc_z", comments="")
    (time,) = (line.split() for line in guess_lines(
        guess_session(guess_files([tmp_path / "log.csv"], None)[0])) if " time " in line)
    assert time[1:3] == ["time_ms", "ms"]


def test_two_recordings_since_the_start_are_no_two_sensors_of_one(tmp_path: Path) -> None:
    """Both count from the start of the board, and their sensors have a file each."""
    for seed, name in enumerate(("first", "second")):
        log = hand_log(seed, rests=8, rate_hz=50.0)
        for sensor, values in (("accel", log.acc), ("gyro", log.gyr)):
            np.savetxt(tmp_path / f"{name}_{sensor}.csv", np.column_stack(
                [log.time_s + 5, values]), "%.5f", ",", header="t,x,y,z", comments="")
    np.savetxt(tmp_path / "second_accel_spare.csv", np.column_stack(
        [log.time_s + 5, -1.01 * log.acc]), "%.5f", ",", header="t,x,y,z", comments="")
    guess = guess_session(guess_files(sorted(tmp_path.glob("*.csv")), None)[0])
    (source,) = guess.sources
    assert [table.path.name for table in source.tables] == [
        "first_accel.csv", "first_gyro.csv", "second_accel.csv", "second_gyro.csv"]


@pytest.mark.parametrize(("gain", "offset_m_s2", "code"), [(1.015, 0.35, 4), (1.0, 0.02, 0)])
def test_files_of_two_sensors_are_not_calibrated_as_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], gain: float, offset_m_s2: float, code: int
) -> None:
    """A bias that moves between two logs of one sensor is a finding, and no fault."""
    names, files = "time_s,ax_m_s2,ay_m_s2,az_m_s2", []
    for seed, (scale, bias) in enumerate(((1.0, 0.0), (gain, offset_m_s2))):
        log = hand_log(seed, rate_hz=RATE_HZ)
        files.append(tmp_path / f"{seed}.csv")
        np.savetxt(files[-1], np.column_stack([log.time_s + 100 * seed, scale * log.acc + bias]),
                   "%.5f", ",", header=names, comments="")
    assert pipeline("import", *files, "--output", tmp_path / "c.yaml", "--latitude", "45") == code
    assert ("files of two sensors" in capsys.readouterr().err) == (code == 4)
