"""A folder for each pose with a file for each sensor, as apps for phones leave it, and other files.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from scipy.ndimage import uniform_filter1d

from pipeline.console.import_text import guess_lines
from pipeline.errors import UnreadableInput
from pipeline.guess.agreement import disagreements
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.files import guess_files
from pipeline.guess.session import SessionGuess, guess_session
from tests.pipeline.guess.foreign import samples, write_lines
from tests.pipeline.guess.hand_log import GRAVITY_M_S2, hand_log
from tests.sessions import pipeline, typed
from tests.world.write import COUNT_COLUMNS

HEADER = "seconds_elapsed,z,y,x"
OF_NO_READINGS = {"Annotation.csv": f"{HEADER}\n", "Metadata.csv": "device,rate\nphone,100\n",
                  "Empty.csv": ";;;\n;;;\n", "Nothing.csv": ""}


def write_folders(root: Path) -> list[Path]:
    """Six sensors of each rest, every second one corrected, and four files without a reading."""
    log = hand_log()
    gravity = GRAVITY_M_S2 * log.acc / np.linalg.norm(log.acc, axis=1, keepdims=True)
    left = uniform_filter1d(log.acc - gravity, 20, axis=0) - np.array([0.12, -0.2, 0.25])
    tables = {"Accelerometer": left, "TotalAcceleration": log.acc,
              "AccelerometerUncalibrated": log.acc + 0.1, "AngularVelocity": log.gyr,
              "Gravity": gravity, "Magnetometer": 40 * log.field}
    for i in range(log.rest.max() + 1):
        folder = root / f"pose{i:02d}"
        folder.mkdir()
        rows = log.rest == i
        for name, values in tables.items():
            np.savetxt(folder / f"{name}.csv", np.column_stack([
                log.time_s[rows] - log.time_s[rows][0] + 0.013, values[rows][:, ::-1]]),
                "%.6f", ",", header=HEADER, comments="")
        for name, text in OF_NO_READINGS.items():
            (folder / name).write_text(text, encoding="utf-8")
    return sorted(root.glob("*/*.csv"))


@pytest.fixture(scope="module")
def guessed(tmp_path_factory: pytest.TempPathFactory) -> tuple[SessionGuess, tuple[str, ...]]:
    tables, passed_over = guess_files(write_folders(tmp_path_factory.mktemp("folders")), None)
    return guess_session(tables), passed_over


def test_one_accelerometer_and_the_gyroscope_of_each_folder_are_used(
    guessed: tuple[SessionGuess, tuple[str, ...]]
) -> None:
    names = {table.path.name: bool(table.accelerometer) for table in guessed[0].tables}
    assert names == {"AccelerometerUncalibrated.csv": True, "AngularVelocity.csv": False}
    assert len(guessed[0].tables) == 36


def test_files_without_readings_are_named_in_one_line(
    guessed: tuple[SessionGuess, tuple[str, ...]]
) -> None:
    notes = [note for note in guessed[1] if "no line is a row of readings" in note]
    assert len(notes) == 1
    assert all(name in notes[0] for name in OF_NO_READINGS)
    assert "72 files" in notes[0]


def test_one_sentence_says_what_is_not_used_and_only_of_accelerometers(
    guessed: tuple[SessionGuess, tuple[str, ...]]
) -> None:
    notes = [note for note in guessed[1] if "not used" in note]
    assert len(notes) == 1
    assert notes[0].startswith("Accelerometer.csv (18 files): not used, because gravity is removed")


@pytest.mark.parametrize("name", [*OF_NO_READINGS])
def test_a_file_without_readings_is_refused_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(OF_NO_READINGS[name], encoding="utf-8")
    with pytest.raises(UnreadableInput, match=name):
        guess_files([tmp_path / name], None)


def test_a_damaged_log_beside_whole_ones_is_refused(tmp_path: Path) -> None:
    rows = [",".join(f"{value:.4f}" for value in row) for row in
            np.random.default_rng(0).normal(size=(200, 4))]
    (tmp_path / "a.csv").write_text("\n".join(["t,ax,ay,az", *rows]), encoding="utf-8")
    damaged = "\n".join(["t,ax,ay,az", *rows]).encode() + b"\n1,\xff\xfe,3,4"
    (tmp_path / "b.csv").write_bytes(damaged)
    with pytest.raises(UnreadableInput, match=r"b\.csv:202"):
        guess_files([tmp_path / "a.csv", tmp_path / "b.csv"], None)


def test_check_names_the_folders_of_files_with_one_name_and_warns_once(tmp_path: Path) -> None:
    files, config = write_folders(tmp_path), tmp_path / "session.yaml"
    assert pipeline("import", *files, "--output", config, "--latitude", "45") == 0
    _, printed, warned = typed("check", config)
    assert ("static intervals in 36 files, pose00/AccelerometerUncalibrated.csv to "
            "pose17/AngularVelocity.csv") in printed
    assert len(set(warned.splitlines())) == len(warned.splitlines())


def test_a_log_without_a_gyroscope_is_only_taken_as_at_rest(tmp_path: Path) -> None:
    log = hand_log()
    np.savetxt(tmp_path / "log.csv", np.column_stack([log.time_s, log.acc]), "%.5f", ",",
               header="time_s,acc_x,acc_y,acc_z", comments="")
    lines = guess_lines(guess_session(guess_files([tmp_path / "log.csv"], None)[0]))
    assert any("taken as at rest, since no gyroscope shows a plate" in line for line in lines)


def test_a_rate_as_long_as_gravity_in_counts_is_none_where_most_files_deny_it(
    tmp_path: Path
) -> None:
    """A gyroscope alone without names at 45 rpm, 269 °/s: 256 counts are 1 g."""
    rng, files = np.random.default_rng(4), []
    for k, up in enumerate([*np.vstack([np.eye(3), -np.eye(3)]).repeat(2, axis=0)] * 2):
        rate = 269.0 * up * (k < 12) + rng.normal([1.2, -0.4, 0.7], 0.05, (300, 3))
        lines = [",".join([f"{20 * i}", *(f"{value:.2f}" for value in row)])
                 for i, row in enumerate(rate)]
        files.append(write_lines(tmp_path / f"g{k}.txt", lines))
    files += [write_lines(tmp_path / f"r{k}.txt", lines) for k in range(4)]
    with pytest.raises(UnreadableInput, match="name their columns"):
        guess_files(files, None)


@pytest.mark.parametrize("is_one_attitude", [True, False])
def test_files_of_one_attitude_each_do_not_lie_in_one(
    tmp_path: Path, is_one_attitude: bool
) -> None:
    rng = np.random.default_rng(3)
    files = [tmp_path / f"p{k}.csv" for k in range(5)]
    for k, path in enumerate(files):
        up = np.roll([9.8, 0.3, 0.8], 0 if is_one_attitude else k)
        rows = np.column_stack([0.01 * np.arange(800), up + rng.normal(0, 0.03, (800, 3))])
        np.savetxt(path, rows, "%.4f", ",", header="t,ax,ay,az", comments="")
    faults = [*disagreements(guess_session(guess_files(files, None)[0]))]
    assert any("lay in one attitude" in fault for fault in faults) == is_one_attitude


def test_the_volts_of_poses_in_files_of_their_own_are_told_with_their_zero(tmp_path: Path) -> None:
    log = hand_log()
    for i in range(18):
        volts = 1.65 + 0.33 * log.acc[log.rest == i] / 9.80665
        np.savetxt(tmp_path / f"pose{i:02d}.csv", volts, "%.5f", ",", header="AI0,AI1,AI2",
                   comments="")
    with pytest.raises(UnreadableInput, match=r"\(18 files\).* about 1\.6.* the volts"):
        guess_files(sorted(tmp_path.glob("*.csv")), None)


def test_files_without_a_header_have_that_of_the_first_one(tmp_path: Path) -> None:
    """A logger that begins a new file, and `split`; the axes z, y, x were taken for x, y, z."""
    log = hand_log(rate_hz=50.0)
    lines = [",".join(f"{value:.5f}" for value in row) for row in np.column_stack(
        [log.time_s, log.acc[:, ::-1], log.gyr[:, ::-1]])]
    names = ["t", *(f"{sensor}{axis}" for sensor in ("Accel", "Gyro") for axis in "ZYX")]
    parts = (["", *lines[:1300]], lines[1300:])
    parts[0][0] = ",".join(names)
    files = [write_lines(tmp_path / f"log_{i}.csv", part) for i, part in enumerate(parts)]
    first, second = guess_files(files, None)[0]
    assert second.accelerometer == first.accelerometer
    assert second.gyroscope == first.gyroscope
    assert second.accelerometer is not None
    assert second.accelerometer.columns == ("AccelX", "AccelY", "AccelZ")
    assert second.columns == ["time_s", "acc_z", "acc_y", "acc_x", "gyr_z", "gyr_y", "gyr_x"]


def test_files_in_another_unit_are_named(tmp_path: Path) -> None:
    log, files = hand_log(rests=10, rate_hz=50.0), []
    for name, rows, unit in (("a", slice(750), 1.0), ("b", slice(750, None), GRAVITY_M_S2)):
        files.append(tmp_path / f"{name}.csv")
        np.savetxt(files[-1], np.column_stack([log.time_s, log.acc / unit])[rows], "%.5f", ",",
                   header="t,ax,ay,az", comments="")
    (fault,) = disagreements(guess_session(guess_files(files, None)[0]))
    assert "b.csv: a typical reading is 0.984 m/s² long in m/s², the unit of the other" in fault


def titled(files: list[Path]) -> str:
    text = config_text(guess_session(guess_files(files, None)[0]), files[0].parent, Choices())
    return text.splitlines()[1]


def test_a_session_is_called_by_its_only_file_or_the_folder_of_all(tmp_path: Path) -> None:
    rows = ["time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z",
            *(each.s for each in samples(hand_log(rate_hz=20.0)))]
    for file, title in (("board 7.csv", '"board 7"'), ("on.csv", '"on"'),
                        ("a\nb: {c}.csv", '"a?b: {c}"')):
        assert titled([write_lines(tmp_path / file, rows)]) == f"title: {title}"
    every = []
    for pose in range(2):
        (tmp_path / "shelf" / f"pose{pose}").mkdir(parents=True)
        part = [rows[0], *rows[1 + 540 * pose : 541 + 540 * pose]]
        every.append(write_lines(tmp_path / "shelf" / f"pose{pose}" / "log.csv", part))
    assert titled(every) == "title: shelf"


def test_a_file_in_which_an_axis_has_no_number_is_told_by_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = hand_log()
    for i in range(log.rest.max() + 1):
        rows = log.rest == i
        gyr = log.gyr[rows] * [1.0, 1.0, np.nan if i == 4 else 1.0]
        axes = np.column_stack([log.acc[rows], gyr]).T
        savemat(tmp_path / f"pose{i:02d}.mat", {
            "time_s": log.time_s[rows], **dict(zip(COUNT_COLUMNS, axes, strict=True)),
            "temp": np.full(rows.sum(), np.nan)})
    config = tmp_path / "config.yaml"
    pipeline("import", *sorted(tmp_path.glob("*.mat")), "--output", config)
    out = " ".join("".join(capsys.readouterr()).split())
    assert "our bug" not in out
    assert "pose04.mat, row 1: column gyr_z: found nan" in out
