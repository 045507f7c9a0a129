"""All files of an evening at once: ranges, rates, directions and clips, and at most two questions.
"""

import math
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.config.load import Config, load_config
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.files import guess_files
from pipeline.guess.session import guess_session
from tests.paths import DATA
from tests.pipeline.guess.evening import BIAS_GYR, DEG, SCALE_ACC, SCALE_GYR, Evening, G
from tests.pipeline.guess.hand_log import hand_log
from tests.sessions import pipeline, run_without_page

pytestmark = pytest.mark.usefixtures("bare_page")

FULL_TURN = 100 / 3  #: rpm
CLIP = DATA / "hidden_effect" / "video" / "33rpm.mp4"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder: Path, evening: Evening, *rpms: float) -> list[str]:
    """The files as a shell's pattern gives them."""
    files = evening.write(folder, "rest", 0.0, 1)
    for i, rpm in enumerate(rpms):
        files += evening.write(folder, f"turn{i}", rpm, 2 + i)
    return [str(path.relative_to(folder)) for path in files]


def config_of(folder: Path) -> Config:
    return load_config(folder / "config.yaml")


def require_true_scales(folder: Path, evening: Evening, relative: float) -> None:
    """Run the configuration, and compare gains and bias with those of the simulated sensor."""
    results = run_without_page(folder / "config.yaml")
    acc, gyr = (np.array(results[triad]["parameters"]["scale_counts_per_unit"])
                for triad in ("accelerometer", "gyroscope"))
    np.testing.assert_allclose(acc, SCALE_ACC * 32768 / (evening.range_g * G), rtol=2e-3)
    np.testing.assert_allclose(gyr, SCALE_GYR * evening.counts_per_rad_s, rtol=relative)
    bias = np.array(results["gyroscope"]["parameters"]["bias_counts"])
    np.testing.assert_allclose(bias / evening.counts_per_rad_s, BIAS_GYR, atol=0.05 * DEG)


@pytest.mark.parametrize("range_deg_s", [500.0, 2000.0])
def test_the_rate_by_gravity_decides_the_range_of_the_gyroscope(
    here: Path, range_deg_s: float, capsys: pytest.CaptureFixture[str]
) -> None:
    evening = Evening(range_deg_s=range_deg_s)
    assert pipeline("import", *write(here, evening, FULL_TURN)) == 0
    said = capsys.readouterr()
    assert said.out.count("gravity goes round at 33") == 1  # and not under the files at rest
    assert "their names; as in the other files" in said.out
    assert "By the register map of an MPU-6050 they are 32.1 °C" in said.out
    assert "seconds" not in said.err  # nor is the clock accused of the range
    sheet = config_of(here).sensor.gyroscope
    assert sheet is not None
    assert sheet.counts_per_deg_s == pytest.approx(32768 / range_deg_s, rel=1e-3)
    require_true_scales(here, evening, 4e-3)


def test_a_clip_decides_where_the_plate_is_level(here: Path) -> None:
    evening = Evening(lean_deg=0.0)
    files = write(here, evening, FULL_TURN)
    assert pipeline("import", *files, CLIP, "--latitude", "52") == 0
    config = config_of(here)
    assert [rate.video for rate in config.rate.values()] == [(CLIP.resolve(),)]  # type: ignore[union-attr]
    assert config.site is not None
    assert config.site.latitude_deg == 52
    require_true_scales(here, evening, 4e-3)


def test_where_nothing_decides_the_range_is_asked_and_not_guessed(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evening = Evening(lean_deg=0.0)
    files = write(here, evening, FULL_TURN)
    assert pipeline("import", *files) == 0
    assert ("nothing shows its range: ±250 °/s would be 16.7 rpm, ±500 °/s would be 33.3 rpm"
            in capsys.readouterr().err)
    assert config_of(here).gyroscope is None
    assert pipeline("import", *files, "--gyroscope-range", "500", "--force") == 0
    require_true_scales(here, evening, 4e-3)


def test_a_rare_range_by_which_the_plate_is_a_record_player_too_is_told(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """ICM-20649: by ±2000 °/s it would be 16.7 rpm, and the scale wrong by 2."""
    evening = Evening(range_deg_s=4000.0, lean_deg=0.0, seconds=3.0)
    files = write(here, evening, FULL_TURN)
    assert pipeline("import", *files) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "±4000 °/s would be 33.3 rpm; if that is its speed, state --gyroscope-range 4000" in told
    assert pipeline("import", *files, "--gyroscope-range", "4000", "--force") == 0
    assert "±4000" not in capsys.readouterr().out
    require_true_scales(here, evening, 4e-3)


@pytest.mark.parametrize(("range_deg_s", "folder"), [(32768.0, "turn"), (500.0, "plate_33")])
def test_whole_degrees_and_a_speed_in_the_name_of_a_folder_are_no_question(
    tmp_path: Path, range_deg_s: float, folder: str
) -> None:
    evening = Evening(range_deg_s=range_deg_s, lean_deg=0.0)
    files = evening.write(tmp_path, "rest", 0.0, 1) + evening.write(tmp_path, folder, FULL_TURN, 2)
    found = guess_session(guess_files(files, None)[0])
    assert not found.scales
    assert [source.rate for source in found.sources] == ["stopped", "33.3rpm"]
    assert found.doubts[-1].startswith(f"{folder}/")  # the rests have files of the same names


@pytest.mark.parametrize(("lean_deg", "key"), [(9.0, "runs"), (0.6, "poses")])
def test_poses_on_a_plate_that_leans_are_runs_of_the_accelerometer(
    tmp_path: Path, lean_deg: float, key: str
) -> None:
    files = Evening(lean_deg=lean_deg).write(tmp_path, "turn", FULL_TURN, 2)
    text = config_text(guess_session(guess_files(files, None)[0]), tmp_path, Choices())
    assert f"accelerometer:\n  {key}:\n" in text


def test_a_gyroscope_alone_shows_rest_and_the_plate_between_the_moves_of_a_hand(
    tmp_path: Path
) -> None:
    log = hand_log(rate_hz=50.0, rpm=45.0)
    path = tmp_path / "a.csv"
    np.savetxt(path, np.column_stack([log.time_s, log.gyr / DEG]), "%.4f", ",", comments="",
               header="t,wx_dps,wy_dps,wz_dps")
    found = guess_session(guess_files([path], None)[0])
    assert {source.rate for source in found.sources} == {"stopped", "45rpm"}


@pytest.mark.parametrize(("lean_deg", "says"), [
    (0.6, "gravity goes round at 16"), (0.0, "the speed by which the files are called")])
def test_a_large_bias_and_a_range_that_no_data_sheet_has_are_no_question(
    here: Path, capsys: pytest.CaptureFixture[str], lean_deg: float, says: str
) -> None:
    """Gyroscope like that of an MTi: offset binary, 20 °/s of bias, a gain of its own."""
    evening = Evening(range_deg_s=197.0, range_g=6.1, bias_deg_s=(-20.0, 17.0, 7.0), zero=32768,
                      lean_deg=lean_deg, rpm=100 / 6)
    files = evening.write(here, "rest", 0.0, 1) + evening.write(here, "at 17 rpm", 100 / 6, 2)
    assert pipeline("import", *files) == 0
    assert says in capsys.readouterr().out
    assert [run.rate for run in config_of(here).gyroscope.runs] == [  # type: ignore[union-attr]
        "stopped", "16.7rpm"]
    sheet = config_of(here).sensor.gyroscope
    assert sheet is not None
    assert sheet.counts_per_deg_s == pytest.approx(32768 / 197.0, rel=0.02)
    assert sheet.encoding == "offset-binary"


def test_a_long_log_at_rest_and_files_of_poses_on_the_plate_are_one_session(here: Path) -> None:
    evening = Evening()
    rest, turn = (evening.write(here, name, rpm, seed) for name, rpm, seed in (
        ("rest", 0.0, 1), ("turn", FULL_TURN, 2)))
    tables = [np.loadtxt(path, delimiter=",", skiprows=1) for path in rest]
    for i, table in enumerate(tables):
        table[:, 0] += 8000 * i
    np.savetxt("rest.csv", np.vstack(tables), "%d", ",", header=evening.header, comments="")
    files = [str(path.relative_to(here)) for path in turn]
    assert pipeline("import", "rest.csv", *files, "--output", "config.yaml") == 0
    sections = config_of(here).triads["gyroscope"].sections
    assert [bool(section.poses.log) for section in sections] == [True, False]
    require_true_scales(here, evening, 4e-3)


def test_a_phone_that_writes_an_archive_for_each_pose_has_its_sensors_joined(here: Path) -> None:
    """Both sensors have files of their own in each archive, whose times begin at 0."""
    evening = Evening(rpm=FULL_TURN)
    archives = []
    for file in write(here, evening, FULL_TURN):
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        archives.append(file.replace(".csv", ".zip"))
        with ZipFile(archives[-1], "w") as archive:
            for name, values in (("TotalAcceleration", table[:, 1:4] * evening.range_g * G / 32768),
                                 ("Gyroscope", table[:, 5:8] / evening.counts_per_rad_s)):
                rows = "\n".join(",".join(f"{v:.9g}" for v in (t / 1000, *row[::-1]))
                                 for t, row in zip(table[:, 0], values, strict=True))
                archive.writestr(f"{name}.csv", f"seconds_elapsed,z,y,x\n{rows}\n")
    assert pipeline("import", *archives, "--output", "config.yaml") == 0
    gyroscope = run_without_page(here / "config.yaml")["gyroscope"]
    assert gyroscope["n_poses"] == 36
    np.testing.assert_allclose(gyroscope["parameters"]["scale_counts_per_unit"], SCALE_GYR,
                               rtol=4e-3)


def test_both_directions_are_two_settings(here: Path) -> None:
    evening = Evening(range_deg_s=2000.0)
    assert pipeline("import", *write(here, evening, FULL_TURN, -FULL_TURN)) == 0
    config = config_of(here)
    rates = {name: rate.rate_rad_s for name, rate in config.rate.items()}  # type: ignore[union-attr]
    nominal = FULL_TURN * 2 * math.pi / 60
    assert rates == pytest.approx({"33.3rpm": nominal, "m33.3rpm": -nominal}, rel=1e-5)
    assert [run.rate for run in config.gyroscope.runs] == [  # type: ignore[union-attr]
        "stopped", "33.3rpm", "m33.3rpm"]


def test_check_run_and_apply_know_the_names_that_import_knows(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evening = Evening(header="millis,AcX,AcY,AcZ,Tmp,GyX,GyY,GyZ")
    assert pipeline("import", *write(here, evening, FULL_TURN)) == 0
    assert "columns" not in (here / "config.yaml").read_text(encoding="utf-8")
    assert pipeline("check", ".") == 0
    assert pipeline("run", ".", "--quiet") == 0
    assert pipeline("apply", "config.run", "rest/p01.csv", "--output", "out.csv") == 0
    table = np.loadtxt("out.csv", delimiter=",", skiprows=1)
    assert np.linalg.norm(table[:, 1:4].mean(axis=0)) == pytest.approx(G, abs=0.02)
    assert table[1, 0] - table[0, 0] == pytest.approx(0.04)
    capsys.readouterr()


def test_apply_remembers_the_columns_of_its_session(here: Path) -> None:
    evening = Evening(header="clock_ms,u,v,w,Tmp,GyX,GyY,GyZ")
    assert pipeline("import", *write(here, evening, FULL_TURN)) == 0
    assert "columns" in (here / "config.yaml").read_text(encoding="utf-8")
    run_without_page(here / "config.yaml")
    assert pipeline("apply", "config.run", "rest/p01.csv", "--output", "out.csv") == 0
    table = np.loadtxt("out.csv", delimiter=",", skiprows=1)
    assert np.linalg.norm(table[:, 1:4].mean(axis=0)) == pytest.approx(G, abs=0.02)


def test_six_faces_are_no_calibration(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = Evening(poses=18).write(here, "rest", 0.0, 1)
    faces = [path for path in files if _is_face(path)]
    assert len(faces) == 6
    assert pipeline("import", *(str(path.relative_to(here)) for path in faces)) == 4
    err = capsys.readouterr().err
    assert "no configuration was written" in err
    assert "6 poses" in err
    assert "at least 10 are needed" in err
    assert "at least 7 are needed" not in err  # of a model that nobody asked for


def test_one_attitude_is_no_calibration_of_either_triad(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A scale that is fitted without the misalignment would be off by many of its sds."""
    files = [Evening(poses=1).write(here, f"{name}{i}", rpm, i)[0]
             for name, rpm in (("rest", 0.0), ("33rpm_", 100 / 3), ("17rpm_", 50 / 3))
             for i in range(6)]
    for i, path in enumerate(files):  # nobody lays a sensor twice within a degree
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        tilt = Rotation.from_rotvec(np.random.default_rng(i).normal(0, 0.02, 3))
        for axes in (slice(1, 4), slice(5, 8)):
            table[:, axes] = np.rint(tilt.apply(table[:, axes]))
        np.savetxt(path, table, "%d", ",", header=Evening.header, comments="")
    assert pipeline("import", *(str(path.relative_to(here)) for path in files)) == 4
    err = capsys.readouterr().err
    assert "poses lie within 25° of" in err
    assert "import all logs again" in err
    assert "warning" not in err


def _is_face(path: Path) -> bool:
    counts = np.loadtxt(path, delimiter=",", skiprows=1)[:, 1:4].mean(axis=0)
    return float(np.abs(counts).max()) > 0.9 * float(np.linalg.norm(counts))
