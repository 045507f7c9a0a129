"""``exclude``: a pose that is excluded might as well never have been recorded."""

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.errors import ConfigError
from pipeline.exclusion import excluding
from pipeline.results.write import results_of
from pipeline.stages.context import RunContext
from pipeline.stages.excluded_poses import choose, short_names
from pipeline.stages.run import Outcome, run_stages
from tests.sessions import configured, edit, pipeline, quick_session, rewrite_rows, typed
from tests.world.hand_turned import Stop, turn_through

pytestmark = pytest.mark.usefixtures("bare_page")

ACC, GYRO = "accelerometer/pose_{:02d}.csv", "gyroscope/17rpm/pose_{:02d}.csv"
OUT = {"accelerometer": (3, 12), "gyroscope": (18,)}
LIMIT = 38_500  #: counts of an accelerometer's axis, between what it reads at 45° and at 0°


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Short poses, one of which is damaged."""
    folder = tmp_path_factory.mktemp("session")
    config, _ = quick_session(folder)
    (folder / ACC.format(12)).write_text("time_s,acc_x\nnonsense", encoding="utf-8")
    return config


def copy_excluding(session: Path, folder: Path, accelerometer: str, gyroscope: str) -> Path:
    """A copy of the configuration that excludes poses."""
    shutil.copytree(session.parent, folder, dirs_exist_ok=True)
    config = folder / session.name
    poses = "accelerometer/pose_*.csv\n"
    edit(config, poses, f"{poses}  exclude: {accelerometer}\n")
    edit(config, ", rate: 17rpm}", f", rate: 17rpm, exclude: {gyroscope}}}")
    return config


def run(config: Path) -> Outcome:
    return run_stages(load_config(config), RunContext())


@pytest.fixture(scope="module")
def excluded(session: Path, tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The session without three of its poses."""
    folder = tmp_path_factory.mktemp("excluded")
    return run(copy_excluding(session, folder, "[pose_03, 12]", "pose_18.csv"))


def without_exclusions(outcome: Outcome) -> dict[str, Any]:
    results = results_of(outcome).as_json()
    return {triad: {key: value for key, value in results[triad].items() if key != "excluded"}
            for triad in OUT}


def test_excluding_a_pose_gives_the_results_of_a_session_without_it(
    excluded: Outcome, session: Path, tmp_path: Path
) -> None:
    shutil.copytree(session.parent, tmp_path, dirs_exist_ok=True)
    for name, numbers in zip((ACC, GYRO), OUT.values(), strict=True):
        for number in numbers:
            (tmp_path / name.format(number)).unlink()
    assert without_exclusions(run(tmp_path / session.name)) == without_exclusions(excluded)


def test_an_excluded_pose_is_named_with_its_error_by_the_fit_without_it(
    excluded: Outcome, session: Path
) -> None:
    result = excluded.triad("accelerometer")
    assert result is not None
    damaged, = (each for each in result.excluded if each.label == ACC.format(12))
    assert damaged.predicted is None  # it cannot even be read
    shown, = (each for each in result.excluded if each.label == ACC.format(3))
    assert shown.predicted is not None
    calibration = result.calibration
    table = np.loadtxt(session.parent / ACC.format(3), delimiter=",", skiprows=1, usecols=(1, 2, 3))
    force = calibration.parameters.correct(table.mean(axis=0)[None])[0]
    gravity = result.gravity
    assert gravity is not None
    assert shown.predicted.residual.residual == pytest.approx(
        float(np.linalg.norm(force)) - gravity.value_m_s2, abs=1e-6)
    assert abs(shown.predicted.residual.in_sd) < 4
    listed = results_of(excluded).as_json()["accelerometer"]["excluded"]
    assert [(each["label"], each["residual"] is None) for each in listed] == [
        (ACC.format(3), False), (ACC.format(12), True)]


def test_check_refuses_a_name_that_no_pose_has_with_its_line(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_excluding(session, tmp_path, "[pose_03, pose_31, 12]", "[]")
    line = 1 + next(i for i, text in enumerate(config.read_text(encoding="utf-8").splitlines())
                    if "pose_31" in text)
    assert pipeline("check", config) == 2
    message = capsys.readouterr().err
    assert f"config.yaml:{line}: accelerometer.exclude" in message
    assert "no pose is named 'pose_31'" in message
    assert "did you mean 'pose_" in message
    edit(config, "pose_31, ", "")
    assert pipeline("check", config) == 0
    assert "16 poses, without pose_03, 12" in capsys.readouterr().out


def test_poses_are_excluded_by_the_names_of_their_triad(excluded: Outcome) -> None:
    targets = ["gyroscope.pose_02", "accelerometer.pose_07", "gyroscope.pose_01.csv"]
    changed, notes = excluding(excluded.config, excluded.recordings, targets)
    text = changed.source.text
    assert not notes
    assert "exclude: [pose_03, 12, pose_07]" in text
    assert "rate: 17rpm, exclude: [pose_18.csv, pose_02, pose_01]}" in text


@pytest.mark.parametrize(("target", "says"), [
    ("pose_07", "names no pose. Write accelerometer.NAME or gyroscope.NAME"),
    ("gyroscope.pose_77", "gyroscope.pose_77: no pose is named 'pose_77' (did you mean 'pose_"),
    ("accelerometer.pose_03", "accelerometer.pose_03: is excluded already"),
])
def test_a_target_that_is_no_pose_of_the_fit_is_refused(
    excluded: Outcome, target: str, says: str
) -> None:
    with pytest.raises(ConfigError, match=re.escape(says)):
        excluding(excluded.config, excluded.recordings, [target])


LONG = """
sensor: {accelerometer: {unit: m_s2}}
site: {gravity_m_s2: 9.80665}
accelerometer:
  poses: {log: log.csv, find: still}
"""
LABELS = ("a/pose_1.csv", "b/pose_1.csv", "b/pose_2.csv.gz", "long.csv 8.0-14.5 s", "t.csv row 3")


@pytest.mark.parametrize("i", range(len(LABELS)))
def test_every_pose_has_a_name_and_a_number_that_mean_it_alone(i: int) -> None:
    for name in (short_names(LABELS[i])[-1], i + 1):
        choice = choose(LABELS, [name])
        assert choice.excluded.tolist() == [i]
        assert sorted([*choice.kept, *choice.excluded]) == list(range(len(LABELS)))


@pytest.mark.parametrize(("names", "problem"), [
    (["pose_1"], "'pose_1' means several poses: a/pose_1.csv, b/pose_1.csv"),
    ([6], "there is no pose 6: the section has 5 poses"),
    (["pose_2", "b/pose_2.csv.gz"], "'b/pose_2.csv.gz' is excluded twice"),
    ([1, 2, 3, 4, 5], "all 5 poses of the section are excluded"),
    (["b/pose_1", "pose_1"], "'pose_1' means several"),
    (["row 4"], r"no pose is named 'row 4' \(did you mean 'row 3'"),
])
def test_names_that_mean_no_pose_or_several_are_refused(
    names: list[str | int], problem: str
) -> None:
    with pytest.raises(ValueError, match=problem):
        choose(LABELS, names)


def test_a_stop_of_a_long_log_is_excluded_by_its_times(tmp_path: Path) -> None:
    log = turn_through([Stop(2.0, 0.01)] * 14, 43)
    table = np.column_stack([log.time_s, log.force_m_s2])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", comments="", fmt="%.5f",
               header="time_s,acc_x,acc_y,acc_z")
    config = configured(tmp_path, LONG)
    labels = labels_of(run(config))
    name = short_names(labels[4])[0]
    edit(config, "find: still}", f'find: still}}\n  exclude: ["{name}"]')
    assert labels_of(run(config)) == [*labels[:4], *labels[5:]]
    edit(config, name, "0.0-0.1 s")
    with pytest.raises(ConfigError, match=r"no pose is named '0.0-0.1 s'"):
        run(config)


def labels_of(outcome: Outcome) -> list[str]:
    assert outcome.triad("accelerometer") is not None
    return list(outcome.triad("accelerometer").calibration.fit.poses.label)


def test_poses_for_which_a_session_is_refused_are_excluded_wherever_their_files_are_poses(
    tmp_path: Path,
) -> None:
    config, _ = quick_session(tmp_path)
    edit(config, ", rate: 17rpm}",
         ", rate: 17rpm}\n    - {poses: accelerometer/pose_*.csv, rate: stopped}")
    for number in (7, 9):
        path = tmp_path / ACC.format(number)
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        table[len(table) // 2 :, 1] += 30
        rewrite_rows(path, table)
    code, _, errors = typed("run", config)
    assert (code, "`pipeline exclude CONFIG TRIAD.NAME...` leaves out poses" in errors) == (4, True)
    code, _, errors = typed("exclude", config, "accelerometer.pose_09")
    assert code == 4  # for pose_07
    assert f"{ACC.format(9)} is a pose of the gyroscope too (rate: stopped)" in errors
    assert "config.yaml was changed" in errors
    assert typed("exclude", config, "accelerometer.pose_07")[0] == 0
    read = load_config(config).triads
    out = ("pose_09", "pose_07")
    assert [one.exclude for triad in read.values() for one in triad.sections] == [out, (), out]


def test_the_level_of_an_axis_that_is_cut_off_outlives_its_pose(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What lies beyond nine tenths of gravity along x, of which an amplifier passes no more."""
    config = copy_excluding(session, tmp_path, "[pose_12, RESTING]", "TURNING")
    for name, place in ((GYRO, "TURNING"), (ACC, "RESTING")):
        tables = {number: np.loadtxt(tmp_path / name.format(number), delimiter=",", skiprows=1)
                  for number in range(1, 19) if (name, number) != (ACC, 12)}
        highest = max(tables, key=lambda number: float(tables[number][:, 1].mean()))
        table = tables[highest]
        table[:, 1] = LIMIT
        rewrite_rows(tmp_path / name.format(highest), table)
        edit(config, place, f"pose_{highest:02d}")
    assert pipeline("run", config) == 0
    capsys.readouterr()
    out, log = tmp_path / "out.csv", tmp_path / ACC.format(highest)
    assert pipeline("apply", config.with_suffix(".run"), log, "--output", out) == 0
    assert f"{len(table)} of {len(table)} samples are saturated" in capsys.readouterr().err
    assert (np.loadtxt(out, delimiter=",", skiprows=1)[:, -1] == 1).all()
