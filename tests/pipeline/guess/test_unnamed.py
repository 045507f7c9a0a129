"""Columns and files whose names say nothing: the physics of the plate and of the hand tells them.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from pipeline.guess.checked import CheckedConfig, checked_config
from pipeline.guess.clocks import guess_clock
from pipeline.guess.config_text import Choices
from pipeline.guess.files import guess_files
from pipeline.guess.pool import pooled
from pipeline.guess.raw_tables import RawTable
from pipeline.guess.session import SessionGuess, guess_session
from pipeline.guess.turns import turn_of
from pipeline.guess.units import per_deg_of
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.pipeline.guess.evening import Evening
from tests.pipeline.guess.hand_log import HandLog, hand_log

ACCELEROMETER, TURN_RPM = ("2", "3", "4"), 100 / 3


def guessed(files: list[Path]) -> SessionGuess:
    return guess_session(guess_files(files, None)[0])


def without_header(path: Path, between: str) -> Path:
    """The rows of a pose, with other columns in the place of the temperature."""
    rows = [line.split(",") for line in path.read_text("utf-8").splitlines()[1:]]
    rng = np.random.default_rng(len(path.parent.name) * 100 + int(path.stem[1:]))
    wide = [[*row[:4], *map(str, _other(between, row, i, rng)), *row[5:]]
            for i, row in enumerate(rows)]
    path.write_text("\n".join(map(",".join, wide)), "utf-8")
    return path


def _other(between: str, row: list[str], i: int, rng: np.random.Generator) -> list[int]:
    if between == "temperature":
        return [-4000 + 5 * i + int(rng.normal(0, 20))]
    angle = 2 * np.pi * TURN_RPM / 60 * int(row[0]) / 1000  # a field that goes round, of one length
    return [int(300 * np.cos(angle)), int(300 * np.sin(angle)), 660 - 2 * (i % 2)]


@pytest.mark.parametrize(("between", "gyroscope"), [("temperature", ("6", "7", "8")),
                                                    ("magnetometer", ("8", "9", "10"))])
def test_a_gyroscope_that_no_name_tells_reads_along_gravity_on_the_plate(
    tmp_path: Path, between: str, gyroscope: tuple[str, ...]
) -> None:
    evening = Evening(seconds=3.0)
    files = [without_header(path, between) for name, rpm, seed in (
        ("rest", 0.0, 1), ("turning", TURN_RPM, 2))
        for path in evening.write(tmp_path, name, rpm, seed)]
    guess = guessed(files)
    assert guess.accelerometer is not None
    assert guess.gyroscope is not None
    assert (guess.accelerometer.columns, guess.gyroscope.columns) == (ACCELEROMETER, gyroscope)
    assert [(source.rate, len(source.tables)) for source in guess.sources] == [
        ("stopped", evening.poses), ("33.3rpm", evening.poses)]


def write_alone(path: Path, log: HandLog, readings: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack([log.time_s, readings]), "%.5f", ",", header="t,x,y,z",
               comments="")
    return path


@pytest.mark.parametrize("force", ["two.csv", "accel.csv"])
def test_of_two_files_of_the_same_times_that_is_the_gyroscope_which_turns_the_others_gravity(
    tmp_path: Path, force: str
) -> None:
    log = hand_log(rate_hz=50.0)
    guess = guessed([write_alone(tmp_path / "one.csv", log, np.degrees(log.gyr)),
                     write_alone(tmp_path / force, log, log.acc)])
    assert {table.path.name: (table.gyroscope and table.gyroscope.unit,
                              table.accelerometer and table.accelerometer.unit)
            for table in guess.tables} == {force: (None, "m/s²"), "one.csv": ("°/s", None)}


@pytest.mark.parametrize("push_m_s2", [0.0, 3.0])
def test_a_hand_that_pushes_while_it_turns_the_sensor_hides_no_gyroscope(
    tmp_path: Path, push_m_s2: float
) -> None:
    """From rest to rest the integral of the rate turns gravity, whatever a push is between."""
    log = hand_log(rate_hz=50.0, push_m_s2=push_m_s2)
    counts = np.rint(log.gyr * 32768 / np.radians(1000.0))
    turned = turn_of(counts, log.acc, np.zeros(len(counts), np.int64), 0.02)
    assert turned is not None
    assert turned.is_exact
    assert turned.axes == "+x, +y, +z"
    assert turned.si_per_unit == pytest.approx(np.radians(1000.0) / 32768, rel=0.02)
    path = tmp_path / "log.txt"
    np.savetxt(path, np.column_stack([1000 * log.time_s, log.acc, counts]), "%.4f", ",")
    triad = guessed([path]).gyroscope
    assert triad is not None
    assert triad.columns == ("5", "6", "7")
    assert "32.768" in triad.unit


def test_on_a_plate_in_a_log_of_many_poses_the_rate_is_along_gravity_and_not_along_a_field(
    tmp_path: Path
) -> None:
    """Neither the range of the accelerometer nor the strength of the field is known."""
    log = hand_log(rate_hz=50.0, rpm=45.0)
    triads = [1440.0 * log.field, np.degrees(log.gyr) * 64, 580.0 * log.acc]
    path = tmp_path / "log.txt"
    np.savetxt(path, np.rint(np.column_stack([1000 * log.time_s, *triads])), "%d", ",")
    guess = guessed([path])
    assert guess.accelerometer is not None
    assert guess.accelerometer.columns == ("8", "9", "10")
    assert guess.accelerometer.rival is None


def test_two_accelerometers_of_the_same_times_turn_nothing(tmp_path: Path) -> None:
    log = hand_log(rate_hz=50.0)
    guess = guessed([write_alone(tmp_path / "one.csv", log, log.acc),
                     write_alone(tmp_path / "two.csv", log, 1.01 * log.acc)])
    assert guess.gyroscope is None


def test_gravity_goes_round_at_each_of_two_speeds(tmp_path: Path) -> None:
    """Between them no plate turns, and half of the poses are on either side."""
    evening = Evening(seconds=3.0, poses=8, range_deg_s=1000.0)
    guess = guessed([path for name, rpm, seed in (
        ("rest", 0.0, 1), ("slow", TURN_RPM, 2), ("fast", 45.0, 3))
        for path in evening.write(tmp_path, name, rpm, seed)])
    seen = ["gravity goes round" in table.gyroscope.because for table in guess.tables
            if table.gyroscope]
    assert (seen.count(True), len(seen)) == (8, 24)  # in the files of one speed
    assert guess.gyroscope is not None
    assert "32.768" in guess.gyroscope.unit
    assert [source.rate for source in guess.sources] == ["stopped", "33.3rpm", "45rpm"]


def test_a_clock_that_begins_again_cuts_no_log() -> None:
    """The nanoseconds of ``sec`` and ``nanosec``; a unit of a gyroscope was found wrong by that."""
    columns = {"t_ns": np.arange(500) * 2e7 % 1e9, "ax": np.arange(500.0)}
    clock = guess_clock(columns, None, None)
    assert clock.column == "t_ns"
    assert not pooled([RawTable(Path("echo.csv"), columns)], [clock], "").table.any()


@pytest.mark.parametrize("rpm", [TURN_RPM, -TURN_RPM])
def test_a_long_log_on_the_plate_turns_as_its_samples_say(tmp_path: Path, rpm: float) -> None:
    """The medians of its axes over all attitudes have no direction in common."""
    evening = Evening(range_deg_s=2000.0)
    tables = [np.loadtxt(path, delimiter=",", skiprows=1)
              for path in evening.write(tmp_path, "turn", rpm, 2)]
    for i, table in enumerate(tables):
        table[:, 0] += 10_000 * i
    np.savetxt(tmp_path / "turn.csv", np.vstack(tables), "%d", ",", header=evening.header,
               comments="")
    (source,) = guessed([tmp_path / "turn.csv"]).sources
    assert np.sign(source.rate_rad_s) == np.sign(rpm)


def write_evening(path: Path, evening: Evening, rpms: Sequence[float]) -> np.ndarray:
    """All poses one after another in one log, at rest and at each of ``rpms``."""
    tables = [np.loadtxt(file, delimiter=",", skiprows=1) for i, rpm in enumerate(rpms)
              for file in evening.write(path.parent, f"part{i}", rpm, 1 + i)]
    for i, table in enumerate(tables):
        table[:, 0] += 20_000 * i
    np.savetxt(path, np.vstack(tables), "%d", ",", header=evening.header, comments="")
    return np.vstack(tables)


def checked(guess: SessionGuess, folder: Path) -> CheckedConfig:
    return checked_config(guess, folder / "c.yaml", Choices(),
                          lambda config: run_stages(config, RunContext()))


@pytest.mark.parametrize("rpms", [
    (0.0, TURN_RPM), (0.0, TURN_RPM, 45.0), (0.0, TURN_RPM, -TURN_RPM), (TURN_RPM, -TURN_RPM)])
def test_each_run_of_a_log_of_a_whole_evening_has_the_stops_at_its_own_speed(
    tmp_path: Path, rpms: tuple[float, ...]
) -> None:
    write_evening(tmp_path / "all.csv", Evening(range_deg_s=2000.0, poses=12), rpms)
    guess = guess_session(guess_files([tmp_path / "all.csv"], None)[0], (), per_deg_of(2000.0))
    assert "as a record player at 33.3 rpm;" in " ".join(guess.doubts)
    made = checked(guess, tmp_path)
    assert made.outcome is not None
    assert made.changes == ()
    assert not [note for note in made.outcome.warnings if "left out" in note]
    runs = made.outcome.config.gyroscope.runs  # type: ignore[union-attr]
    assert [len(made.outcome.recordings.of(run).means) for run in runs] == [12] * len(rpms)
    clocks = made.outcome.recordings.clocks.values()  # by gravity the plate is at its speed
    assert clocks
    assert all(abs(clock.difference) < 4 * clock.sd < 0.005 for clock in clocks)
    assert [guess.rate_rad_s for guess in guess.sources] == pytest.approx(
        [rpm * np.pi / 30 for rpm in rpms])


def test_the_files_of_both_sensors_of_a_whole_evening_have_the_same_runs(tmp_path: Path) -> None:
    evening = Evening(poses=12)
    table = write_evening(tmp_path / "all.csv", evening, (0.0, TURN_RPM))
    for name, columns, unit in (("acc", [0, 1, 2, 3], evening.range_g * 9.80665 / 32768),
                                ("gyr", [0, 5, 6, 7], 1 / evening.counts_per_rad_s)):
        np.savetxt(tmp_path / f"{name}.csv", table[:, columns] * [1e-3, unit, unit, unit],
                   "%.6f", ",", header="t,x,y,z", comments="")
    made = checked(guessed([tmp_path / "acc.csv", tmp_path / "gyr.csv"]), tmp_path)
    assert made.outcome is not None
    assert [len(result.calibration.fit.poses) for result in made.outcome.triads] == [12, 24]


@pytest.mark.parametrize("names", [
    "gx,gy,gz,ax,ay,az", "Gyroscope X,Gyroscope Y,Gyroscope Z,Accel X,Accel Y,Accel Z",
    "ivme X,ivme Y,ivme Z,jiro X,jiro Y,jiro Z"])
@pytest.mark.parametrize("of_poses", [False, True])
def test_gravity_and_its_turns_tell_the_sensors_whatever_the_names(
    tmp_path: Path, names: str, of_poses: bool
) -> None:
    """The names are swapped, or of a language that the program does not know."""
    log = hand_log(rate_hz=50.0)
    table = np.column_stack([log.time_s, log.acc, np.degrees(log.gyr)])
    parts = [table[log.rest == i] for i in range(18)] if of_poses else [table]
    for i, part in enumerate(parts):
        np.savetxt(tmp_path / f"p{i:02d}.csv", part, "%.5f", ",", header=f"t,{names}", comments="")
    guess = guessed(sorted(tmp_path.glob("*.csv")))
    assert guess.accelerometer is not None
    assert guess.gyroscope is not None
    every = names.split(",")
    assert [*guess.accelerometer.columns, *guess.gyroscope.columns] == every
    assert (guess.accelerometer.doubt != "") == ("yro" in every[0])


@pytest.mark.parametrize("poses", [7, 12])
@pytest.mark.parametrize("waits_s", [1.2, 0.0])
def test_the_zero_of_a_gyroscope_is_no_vector_of_a_turning_plate(
    tmp_path: Path, poses: int, waits_s: float
) -> None:
    """The sensor lies for a second before the plate starts and after it stops."""
    evening = Evening(range_deg_s=500.0, poses=poses, rate_hz=100.0)
    waits = round(evening.rate_hz * waits_s)
    rests, turns = ([np.loadtxt(file, delimiter=",", skiprows=1) for file in evening.write(
        tmp_path, name, rpm, seed)] for name, rpm, seed in (("a", 0.0, 1), ("b", TURN_RPM, 2)))
    parts = [part for rest, turn in zip(rests, turns, strict=True)
             for part in (rest[:waits], turn, rest[waits : 2 * waits])]
    whole = np.vstack(parts) / [1, 1, 1, 1, 1, *[evening.counts_per_rad_s] * 3]
    whole[:, 0] = 0.01 * np.arange(len(whole))
    np.savetxt(tmp_path / "plate.csv", whole, "%.5f", ",", comments="",
               header="t,ax,ay,az,temp,gx (rad/s),gy (rad/s),gz (rad/s)")
    rates = [source.rate for source in guessed([tmp_path / "plate.csv"]).sources]
    assert "33.3rpm" in rates
    assert {*rates} <= {"stopped", "33.3rpm"}


def nine_columns(path: Path, order: str, per_g: float, gauge: float = 460.0) -> SessionGuess:
    """Whole numbers without names: accelerometer, gyroscope and magnetometer in some order."""
    log = hand_log(rate_hz=50.0)
    noise = np.random.default_rng(1).normal(0, 2, log.field.shape)
    triads = {"a": log.acc / 9.80665 * per_g, "g": np.degrees(log.gyr) * 100,
              "m": gauge * log.field + noise}
    np.savetxt(path, np.column_stack([log.time_s * 1000, *(triads[one] for one in order)]), "%.0f",
               ",")
    return guessed([path])


@pytest.mark.parametrize(("order", "columns"), [
    ("amg", ("2", "3", "4")), ("mag", ("5", "6", "7")), ("gam", ("5", "6", "7")),
    ("am", ("2", "3", "4")), ("ma", ("5", "6", "7"))])
def test_gravity_in_a_known_unit_is_no_magnetic_field_in_a_range_it_is_near(
    tmp_path: Path, order: str, columns: tuple[str, ...]
) -> None:
    """A field of 46 µT in tenths reads 460, a tenth off the 512 counts of a range of 1 g."""
    guess = nine_columns(tmp_path / "nine.csv", order, 10_000.0)
    assert guess.accelerometer is not None
    assert guess.accelerometer.columns == columns
    assert guess.accelerometer.rival is None


@pytest.mark.parametrize(("per_g", "gauge"), [(12_000.0, 460.0), (8192.0, 512.0)])
@pytest.mark.parametrize("order", ["agm", "mag"])
def test_gravity_and_a_magnetic_field_that_nothing_tells_apart_are_not_guessed(
    tmp_path: Path, order: str, per_g: float, gauge: float
) -> None:
    """Both turn as the gyroscope says; neither is in a known unit, or both are."""
    made = checked(nine_columns(tmp_path / "nine.csv", order, per_g, gauge), tmp_path)
    assert made.outcome is None
    assert made.fault is not None
    assert "as gravity has and the magnetic field" in made.fault


def test_a_field_alone_is_told_as_one_that_may_be_no_gravity(tmp_path: Path) -> None:
    guess = nine_columns(tmp_path / "three.csv", "m", 1.0)
    assert "a magnetic field has one length too" in " ".join(guess.doubts)


def test_a_second_reading_of_gravity_is_no_rival(tmp_path: Path) -> None:
    log = hand_log(rate_hz=50.0)
    rows = np.column_stack([log.time_s, log.acc, 1.01 * log.acc, log.gyr])
    np.savetxt(tmp_path / "two.csv", rows, "%.4f", ",")
    guess = guessed([tmp_path / "two.csv"])
    assert guess.accelerometer is not None
    assert guess.accelerometer.rival is None
