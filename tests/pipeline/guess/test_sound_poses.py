"""Poses and axes without a reading: each is named and left out, and the others are calibrated."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.pipeline.guess.evening import Evening
from tests.sessions import pipeline, results_in, run_without_page

pytestmark = pytest.mark.usefixtures("bare_page")

RPM = 100 / 3


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def files(here: Path) -> list[Path]:
    """Poses at rest and on the plate, whose names are the same in both folders."""
    evening = Evening()
    return [path.relative_to(here) for name, rpm, seed in (("rest", 0.0, 1), ("turn", RPM, 2))
            for path in evening.write(here, name, rpm, seed)]


def hold(path: Path, column: int, number: str = "") -> None:
    """Write one number, by default its first, into a column of every row."""
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").split()]
    for row in rows[1:]:
        row[column] = number or rows[1][column]
    path.write_text("\n".join(map(",".join, rows)), encoding="utf-8")


@pytest.mark.parametrize(("column", "says"), [
    (-1, "gyroscope is left out: gyroscope z is dead: 'GyZ' reads 17 in every row"),
    (2, "AcY reads 17 in every row, which no sensor does that answers: it is dead"),
])
def test_a_dead_axis_is_named_and_not_what_follows_from_it(
    files: list[Path], column: int, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files:
        hold(path, column, "17")
    pipeline("import", *files)
    assert says in (words := " ".join(capsys.readouterr().err.split()))
    assert "no speed of a record player" not in words


@pytest.mark.parametrize("axis", [-3, -1])
def test_what_turned_about_a_dead_axis_is_not_said_to_rest(
    files: list[Path], axis: int, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files:
        hold(path, axis, "17")
    assert pipeline("import", *files) == 0
    said = capsys.readouterr()
    assert "tables, at rest or turned about the dead axis: each is one pose" in said.out
    assert "turning at" not in said.out
    assert "What turned about it looks as if it were at rest" in said.err
    assert "# gyroscope: left out" in Path("config.yaml").read_text(encoding="utf-8")


def test_of_a_dead_accelerometer_at_rest_no_configuration_is_written(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files[:18]:
        hold(path, 1, "17")
    assert pipeline("import", *files[:18]) == 4
    said = capsys.readouterr().err
    assert "no configuration was written: rest/p01.csv: AcX reads 17 in every row," in said
    assert "Then import all logs again." in said
    assert not Path("config.yaml").exists()


def test_beside_a_dead_accelerometer_a_gyroscope_on_the_plate_is_calibrated(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files:
        hold(path, 1, "17")
    assert pipeline("import", *files, "--gyroscope-range", "500") == 0
    assert "the accelerometer is left out: rest/p01.csv: AcX reads 17" in capsys.readouterr().err
    assert [*run_without_page(Path("config.yaml"))["gyroscope"]["parameters"]]


def test_an_axis_that_is_dead_in_a_stated_unit_is_no_file_in_another_unit(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evening = Evening(range_g=32.768, header="millis,ax_mg,ay_mg,az_mg,Tmp,GyX,GyY,GyZ")
    files = [path for name, rpm in (("rest", 0.0), ("turn", RPM))
             for path in evening.write(here, name, rpm, 1)]
    for path in files:
        hold(path, 1, "17")
    pipeline("import", *files, "--gyroscope-range", "500")
    said = capsys.readouterr().err
    assert "the accelerometer is left out: accelerometer x is dead: 'ax_mg' reads 17" in said
    assert "the unit of the other files" not in said


def test_a_gyroscope_at_rest_is_told_not_to_be_tested_for_what_needs_turning(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    untested = ("no pose turned, so that scale and misalignment were neither determined nor tested")
    assert pipeline("import", *files[:18], "--gyroscope-range", "500") == 0
    assert f"gyroscope: {untested}." in capsys.readouterr().out
    assert pipeline("run", "config.yaml") == 0
    assert f"But {untested}.\nnext: record the same poses on the turning plate" in (
        capsys.readouterr().out)
    gyroscope = results_in(Path("config.run"))["gyroscope"]
    assert untested in gyroscope["diagnosis"]["says"]


def test_a_pose_that_is_to_be_recorded_again_costs_no_triad(
    here: Path, files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A plate faster than the range cuts off the poses in which an axis points along it."""
    for path, column in ((files[20], -1), (files[25], -2)):
        hold(path, column)
    assert pipeline("import", *files) == 0
    words = " ".join(capsys.readouterr().err.split())
    for path in (files[20], files[25]):
        assert f"{path}: left out. {path}: stands still" in words
    results = run_without_page(here / "config.yaml")
    assert (results["accelerometer"]["n_poses"], results["gyroscope"]["n_poses"]) == (18, 34)


def test_a_setting_whose_poses_mostly_fail_is_no_setting(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files[20:30]:
        hold(path, -1)
    assert pipeline("import", *files) == 0
    assert "the gyroscope is left out: " in " ".join(capsys.readouterr().err.split())


def change(path: Path, axes: slice, readings: Callable[[np.ndarray], np.ndarray]) -> None:
    """Write ``readings`` of all columns in the place of some of them."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    table[:, axes] = np.rint(readings(table))
    np.savetxt(path, table, "%d", ",", header=Evening.header, comments="")


def test_files_of_two_sensors_together_cannot_be_right(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files[:18:2]:
        change(path, slice(1, 4), lambda table: 1.3 * table[:, 1:4])
    assert pipeline("import", *files[:18]) == 4
    said = capsys.readouterr().err
    assert "it cannot be right: the accelerometer's poses differ from gravity by 1" in said
    assert "files of two sensors or ranges together" in said


def test_a_field_under_the_names_of_a_gyroscope_is_no_bias(
    files: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A magnetometer reads another number in every attitude, a hundred times its noise and more."""
    rng = np.random.default_rng(0)
    for path in files[:18]:
        change(path, slice(5, 8), lambda table: rng.normal(
            np.roll(table[:, 1:4], 1, axis=1).mean(axis=0) / 27, 1.5, (len(table), 3)))
    assert pipeline("import", *files[:18], "--gyroscope-range", "250") == 4
    assert "Its columns are another sensor's, or it moved" in capsys.readouterr().err


@pytest.mark.parametrize("axes", [slice(2, 3), slice(1, 4)])
def test_axes_that_read_one_number_are_told_whatever_their_number(
    files: list[Path], axes: slice, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in files[:18]:
        change(path, axes, lambda table: 0 * table[:, axes])
    assert pipeline("import", *files[:18]) in (3, 4)
    assert "reads 0 in every row, which no sensor does that answers" in capsys.readouterr().err
