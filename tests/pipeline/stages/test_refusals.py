"""What a run refuses: poses that moved, models that cannot be fitted, folders it cannot write."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from tests.sessions import edit, pipeline, quick_session, results_in, rewrite_rows


def test_a_named_pose_that_moved_is_refused_by_its_name(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pose = session.parent / "accelerometer/pose_07.csv"
    table = np.loadtxt(pose, delimiter=",", skiprows=1)
    table[len(table) // 2 :, 1] += 30
    rewrite_rows(pose, table)
    assert pipeline("run", session) == 4
    assert "accelerometer/pose_07.csv: the sensor moved: accelerometer x" in capsys.readouterr().err
    assert not session.with_suffix(".run").exists()


def test_a_found_pose_that_moved_is_left_out_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session, _ = quick_session(tmp_path, 1)
    _one_long_log(session, tilted=4)
    assert pipeline("run", session) == 0
    warning = capsys.readouterr().err
    assert warning.startswith("warning: Left out beside 17 poses: long.csv")
    assert "the sensor moved" in warning
    found = results_in(session.with_suffix(".run"))
    assert found["accelerometer"]["n_poses"] == 17
    assert found["warnings"] == [warning.removeprefix("warning: ").strip()]


def test_a_refused_run_leaves_the_results_of_the_one_before(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("run", session) == 0
    folder = session.with_suffix(".run")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    for pose in sorted((session.parent / "accelerometer").iterdir())[8:]:
        pose.unlink()
    assert pipeline("run", session) == 4
    assert "8 poses give 8 equations for 9 parameters" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("model", "says"),
    [
        ("[bias, scale, misalignment, quadratic]\n  solver: paper", "solver: 'paper' knows"),
        ("[bias, scale, misalignment, g_sensitivity]", "'g_sensitivity' is no effect of the acc"),
    ],
)
def test_a_model_that_cannot_be_fitted_is_refused_with_its_line_before_anything_is_read(
    session: Path, capsys: pytest.CaptureFixture[str], model: str, says: str
) -> None:
    edit(session, "accelerometer/pose_*.csv\n  model: [bias, scale, misalignment]",
         f"accelerometer/pose_*.csv\n  model: {model}")
    assert pipeline("run", session) == 2
    said = capsys.readouterr()
    assert says in said.err
    assert f"{session}:" in said.err
    assert said.out == ""


def test_a_folder_that_cannot_be_written_is_refused(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "taken").write_text("a file")
    assert pipeline("run", session, "--output", tmp_path / "taken" / "inside") == 2
    assert "move that file away, or write to another folder" in capsys.readouterr().err


def _one_long_log(session: Path, tilted: int) -> None:
    """The accelerometer's poses as one log, turned over between them; one of them slips."""
    config = load_config(session)
    assert config.accelerometer
    rng = np.random.default_rng(0)
    parts, start = [], 0.0
    for i, pose in enumerate(config.accelerometer.poses.files):
        table = np.loadtxt(pose, delimiter=",", skiprows=1)
        step = float(np.median(np.diff(table[:, 0])))
        moving = np.repeat(table[:1], 100, axis=0)
        moving[:, 1:4] += rng.normal(0, 2000, (100, 3))
        if i == tilted:  # by 0.4°, twice: too little to break the pose, and no half of it is still
            table[len(table) // 3 :, 1:3] += 30
            table[2 * len(table) // 3 :, 1:3] += 30
        both = np.vstack([table, moving])
        both[:, 0] = start + step * np.arange(len(both))
        start = both[-1, 0] + step
        parts.append(both)
    header = pose.read_text(encoding="utf-8").splitlines()[0]
    np.savetxt(session.parent / "long.csv", np.vstack(parts), delimiter=",", header=header,
               comments="", fmt="%.4f")
    edit(session, "poses: accelerometer/pose_*.csv\n",
         "poses: {log: long.csv, find: still}\n")
