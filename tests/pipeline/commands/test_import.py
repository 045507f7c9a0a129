"""``pipeline import`` as it is typed: what it shows, what it writes, what it never replaces."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
import pytest

from pipeline.cli import main
from pipeline.commands.interaction.arguments import LATITUDE_DEG
from pipeline.config.load import load_config
from tests.paths import DATA
from tests.pipeline.guess.corpus import READ
from tests.pipeline.guess.hand_log import HandLog, hand_log

pytestmark = pytest.mark.usefixtures("bare_page")


@pytest.fixture(scope="module")
def log() -> HandLog:
    return hand_log(seed=1)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_log_becomes_a_configuration_that_runs(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    (path,) = READ["milli_g"](here, log).files
    before = path.read_bytes()
    assert main(["import", path.name]) == 0
    shown = capsys.readouterr().out
    assert "acc_x_mg, acc_y_mg, acc_z_mg" in shown
    assert "first rows:" in shown
    assert shown.splitlines()[-1] == "next: pipeline run log.yaml"
    config = load_config(here / "log.yaml")
    assert config.sensor.accelerometer is not None
    assert config.sensor.accelerometer.unit == "mg"
    assert path.read_bytes() == before
    assert main(["run", "log.yaml", "--quiet"]) == 0


def test_logs_at_rest_make_a_session_in_a_folder_that_is_new(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The gyroscope's bias of 44 °/s is that of every pose, and no plate turns."""
    logs = sorted(shutil.copytree(DATA / "example/accelerometer", here / "logs").iterdir())
    assert main(["import", *map(str, logs), "--output", "new/config.yaml"]) == 0
    assert f"{len(logs)} poses averaged" in capsys.readouterr().out


def test_a_log_without_times_is_corrected_at_the_rate_of_its_session(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also under our own names; and a temperature that stays the same is in the range of itself."""
    table = np.column_stack([log.acc, log.gyr, np.full(len(log.acc), 27.1)])
    np.savetxt("log.csv", table, "%.5f", ",", comments="", header=(
        "acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,temperature_c"))
    assert main(["import", "log.csv", "--rate-hz", "100", "--gyroscope-unit", "rad_s"]) == 0
    assert main(["run", "log.yaml", "--quiet"]) == 0
    assert main(["apply", "log.run", "log.csv", "--output", "corrected.csv"]) == 0
    assert "temperature_c runs from" not in capsys.readouterr().err


def test_of_two_files_with_the_same_columns_the_name_tells_the_sensor(
    here: Path, log: HandLog
) -> None:
    for name, readings in (("Acceleration", log.acc), ("AngularVelocity", log.gyr)):
        np.savetxt(f"{name}.csv", np.column_stack([log.time_s, readings]), "%.5f", ",",
                   header="Timestamp,X,Y,Z", comments="")
    assert main(["import", "Acceleration.csv", "AngularVelocity.csv", "--output", "c.yaml"]) == 0
    assert main(["run", "c.yaml", "--quiet"]) == 0
    for name, column in (("Acceleration", "acc_x_m_s2"), ("AngularVelocity", "gyr_x_rad_s")):
        assert main(["apply", "c.run", f"{name}.csv", "--output", "out.csv", "--force"]) == 0
        assert column in Path("out.csv").read_text("utf-8").splitlines()[0]


def test_it_runs_is_said_only_of_a_model_that_explains_the_poses(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    bent = log.acc + 2e-3 * log.acc**2 * [1, 0, 0]
    for name, acc, runs in (("sound", log.acc, True), ("bent", bent, False)):
        table = np.column_stack([log.time_s, acc, log.gyr])
        rows = [",".join(f"{value:.5f}" for value in row) for row in table]
        rows[:0] = ["time_s,ax,ay,az,gx,gy,gz", "0,EVENT,button,,,,"]
        (here / f"{name}.csv").write_text("\n".join(rows)[:-20])
        assert main(["import", f"{name}.csv"]) == 0
        shown = capsys.readouterr()
        assert ("was written, and it runs." in shown.out) is runs
        assert ("the lines on the accelerometer above say what is missing" in shown.out) is not runs
        assert ("\naccelerometer: " in shown.out) is not runs
        assert "rows that lack a reading and are left out: 2 of" in shown.err


def test_a_configuration_is_replaced_with_force_only(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    READ["milli_g"](here, log)
    (here / "log.yaml").write_text("mine")
    assert main(["import", "log.csv"]) == 2
    assert "exists and is left as it is" in capsys.readouterr().err
    assert (here / "log.yaml").read_text() == "mine"
    assert main(["import", "log.csv", "--force"]) == 0
    assert main(["import", "log.csv", "--output", "log.csv", "--force"]) == 2
    assert "is one of the logs" in capsys.readouterr().err


def test_a_log_that_has_the_name_of_its_configuration_is_read_beside_it(
    here: Path, log: HandLog
) -> None:
    READ["milli_g"](here, log)
    (here / "log.csv").rename(here / "log.yaml")
    assert main(["import", str(here / "log.yaml")]) == 0
    assert "log: log.yaml" in (here / "config.yaml").read_text()


def test_what_is_not_sure_is_said_and_stands_in_the_file(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    READ["no_header_no_time"](here, log)
    assert main(["import", "imu.log", "--latitude", "59.9", "--height", "20"]) == 0
    shown = capsys.readouterr().out
    assert "the file holds no times" in shown.partition("not sure:")[2]
    text = (here / "imu.yaml").read_text()
    assert "# Not sure: imu.log: the file holds no times" in text
    assert "site: {latitude_deg: 59.9, height_m: 20}" in text


@pytest.mark.parametrize(("typed", "degrees"), [
    ("59.91", 59.91), ("59,91", 59.91), (" 59.91N", 59.91), ("59.91 S", -59.91),
    ("s 59,91°", -59.91), ("-33.87", -33.87), ("45° n", 45.0)])
def test_a_latitude_is_read_as_people_write_it(typed: str, degrees: float) -> None:
    assert LATITUDE_DEG.convert(typed, None, None) == degrees


@pytest.mark.parametrize("typed", ["north", "10.75 E", "59.91, 10.75", "-33 S", "N 59 S", "nan"])
def test_what_is_no_latitude_is_refused_with_an_example(typed: str) -> None:
    with pytest.raises(click.BadParameter, match=r"Type 59\.91 or 59\.91 N"):
        LATITUDE_DEG.convert(typed, None, None)


def test_programs_get_the_guess_as_json(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [path.name for path in READ["one_file_per_pose"](here, log).files]
    assert main(["import", *files, "--json"]) == 0
    guess = json.loads(capsys.readouterr().out)
    assert guess["runs"] is True
    assert len(guess["tables"]) == 18
    assert guess["tables"][0]["accelerometer"] == {"unit": "g"}


def shaken(log: HandLog) -> np.ndarray:
    return log.acc + np.random.default_rng(0).normal(0, 2, log.acc.shape)


def two_attitudes(log: HandLog) -> np.ndarray:
    return log.acc[(log.rest == 0) | (log.rest == 1)]


@pytest.mark.parametrize(("readings", "says"), [
    (shaken, "no configuration was written.*never rests.*import all logs again"),
    (two_attitudes, "2 poses give 2 equations"),
])
def test_a_log_that_makes_no_calibration_says_why(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str],
    readings: Callable[[HandLog], np.ndarray], says: str,
) -> None:
    np.savetxt(here / "bad.txt", readings(log), "%.5f", header="ax ay az", comments="")
    assert main(["import", "bad.txt", "--rate-hz", "100"]) == 4
    with pytest.raises(AssertionError, match=f"(?s){says}"):
        raise AssertionError(capsys.readouterr().err)
    assert not (here / "bad.yaml").exists()


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_file_of_few_rows_is_too_short_to_tell_a_sensor_by(
    here: Path, rows: int, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "short.csv").write_text("t,ax,ay,az\n" + "0.1,0.1,0.2,9.8\n" * rows, "utf-8")
    assert main(["import", "short.csv"]) == 3
    assert "too few to tell a sensor by" in capsys.readouterr().err


def test_a_table_of_something_else_is_no_log(
    here: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(here / "compass.csv", 300 * log.acc, delimiter=",", header="mag_x,mag_y,mag_z",
               comments="")
    assert main(["import", "compass.csv"]) == 3
    assert "no accelerometer and no gyroscope are among its columns" in capsys.readouterr().err
    assert not (here / "compass.yaml").exists()


def test_hostile_names_stay_data(here: Path, log: HandLog) -> None:
    head = ['ax"}: [', "ay\x1b[2J", "az #", "evil"]
    rows = "\n".join(",".join(f"{v:.5f}" for v in (*row, 0)) for row in log.acc)
    name = "a'b\n\"c.csv"
    (here / name).write_text(",".join(head) + "\n" + rows)
    main(["import", name, "--rate-hz", "100", "--output", "safe.yaml"])
    assert not (here / "safe.yaml").exists() or load_config(here / "safe.yaml")
