"""``pipeline run``: stages, what is read and followed how often, what is refused."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from calib.mounting.mounting import Mounting
from pipeline.config.load import load_config
from pipeline.logs.read import read_log
from pipeline.stages import session_logs
from pipeline.stages.context import RunContext
from pipeline.stages.poses import Recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import StageObserver, run_stages
from pipeline.stages.triads import TriadResult
from tests.pipeline.conftest import RunSession
from tests.sessions import pipeline, results_in


@pytest.fixture
def session(finished: RunSession, tmp_path: Path) -> Path:
    """A copy of the session to change, without results; its configuration."""
    folder = tmp_path / "session"
    shutil.copytree(finished.config.parent, folder, ignore=shutil.ignore_patterns("*.run"))
    return folder / finished.config.name


def edit(config: Path, old: str, new: str) -> None:
    text = config.read_text(encoding="utf-8")
    assert old in text
    config.write_text(text.replace(old, new), encoding="utf-8")


# --- the stages --------------------------------------------------------------------------------


class Notes(StageObserver):
    """Notes which stage handed over what."""

    def __init__(self) -> None:
        self.results: list[tuple[str, object]] = []

    def on_rate(self, rate: SettingRate) -> None:
        self.results.append(("rate", rate))

    def on_recordings(self, recordings: Recordings) -> None:
        self.results.append(("recordings", recordings))

    def on_triad(self, result: TriadResult) -> None:
        self.results.append((result.triad, result))

    def on_installation(self, installation: Mounting) -> None:
        self.results.append(("installation", installation))


def test_an_observer_receives_the_results_of_the_stages_in_their_order(session: Path) -> None:
    notes = Notes()
    outcome = run_stages(load_config(session), RunContext(), notes)
    assert notes.results == [
        ("rate", outcome.rates["17rpm"]),
        ("recordings", outcome.recordings),
        ("accelerometer", outcome.accelerometer),
        ("gyroscope", outcome.gyroscope),
    ]


def test_a_stage_without_a_section_makes_nothing_and_is_not_announced(session: Path) -> None:
    text = session.read_text(encoding="utf-8")
    session.write_text(text[: text.index("\ngyroscope:")] + "\n", encoding="utf-8")
    notes = Notes()
    outcome = run_stages(load_config(session), RunContext(), notes)
    assert outcome.gyroscope is None
    assert "gyroscope" not in dict(notes.results)


# --- what a run says and leaves ----------------------------------------------------------------


def test_a_run_prints_a_line_for_each_stage_and_the_report_last(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("run", session) == 0
    said = capsys.readouterr()
    lines = said.out.splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["rate", "logs", "accelerometer", "gyroscope"]
    assert "36 poses" in lines[1]
    assert lines[-1] == str(session.with_suffix(".run") / "report.html")
    assert lines[-2].startswith("next: pipeline ")
    assert said.err == ""
    left = sorted(path.name for path in session.with_suffix(".run").iterdir())
    assert left == ["history.jsonl", "report.html", "results.json"]


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_the_truth_lies_within_five_sds_of_every_parameter(
    finished: RunSession, triad: str
) -> None:
    found = results_in(finished.folder)[triad]
    truth = getattr(finished.truth, triad)
    for key, values in found["parameters"].items():
        away = (np.array(values) - getattr(truth, key)) / np.array(found["sd"][key])
        assert np.abs(away).max() < 5, key


def test_the_same_input_gives_the_same_results_byte_for_byte(
    finished: RunSession, session: Path, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "elsewhere"
    assert pipeline("run", session, "--output", elsewhere) == 0
    again = (elsewhere / "results.json").read_bytes()
    assert again == (finished.folder / "results.json").read_bytes()


@pytest.mark.parametrize("alone", ["accelerometer", "gyroscope"])
def test_each_triad_can_be_calibrated_alone(
    finished: RunSession, session: Path, alone: str
) -> None:
    other = {"accelerometer": "gyroscope", "gyroscope": "accelerometer"}[alone]
    blocks = session.read_text(encoding="utf-8").split("\n\n")
    kept = [block for block in blocks if not block.startswith(f"{other}:")]
    assert len(kept) == len(blocks) - 1
    session.write_text("\n\n".join(kept), encoding="utf-8")
    assert pipeline("run", session) == 0
    found = results_in(session.with_suffix(".run"))
    assert found[other] is None
    both = results_in(finished.folder)[alone]
    assert found[alone]["parameters"] == both["parameters"]


def test_both_solvers_end_in_the_same_parameters(finished: RunSession, session: Path) -> None:
    edit(session, "  model: [bias, scale, misalignment]",
         "  model: [bias, scale, misalignment]\n  solver: paper")
    assert pipeline("run", session) == 0
    paper, default = results_in(session.with_suffix(".run")), results_in(finished.folder)
    for triad in ("accelerometer", "gyroscope"):
        for key, values in paper[triad]["parameters"].items():
            same = np.array(default[triad]["parameters"][key])
            scale = np.abs(same).max()
            assert np.abs(np.array(values) - same).max() < 1e-9 * scale, (triad, key)


def test_an_added_effect_is_fitted_and_reported_with_its_unit(session: Path) -> None:
    edit(session, "accelerometer/pose_*.csv\n  model: [bias, scale, misalignment]",
         "accelerometer/pose_*.csv\n  model: [bias, scale, misalignment, bias_drift]")
    assert pipeline("run", session) == 0
    found = results_in(session.with_suffix(".run"))["accelerometer"]
    assert found["model"][-1] == "bias_drift"
    drift = found["effects"]["bias_drift"]
    assert drift["unit"] == "m/s²/h"
    assert len(drift["values"]) == len(drift["sd"]) == 3
    assert min(drift["sd"]) > 0


def test_a_mounted_sensor_and_a_certificate_are_part_of_the_same_run(
    finished: RunSession, session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses = results_in(finished.folder)["accelerometer"]["poses"]
    upright = next(p["label"] for p in poses if p["corrected"][2] > 9.7)
    text = session.read_text(encoding="utf-8") + f"installation: {{log: {upright}}}\n" + CERTIFICATE
    session.write_text(text, encoding="utf-8")
    assert pipeline("run", session) == 0
    lines = capsys.readouterr().out.splitlines()
    (said,) = (line for line in lines if line.startswith("installation"))
    found = results_in(session.with_suffix(".run"))
    mounting = found["installation"]
    assert f"order {mounting['order']}" in said
    assert max(abs(mounting["roll_deg"]), abs(mounting["pitch_deg"])) < 5
    assert mounting["after"][2] == pytest.approx(9.80267, abs=0.02)
    away = found["accelerometer"]["certificate"]["bias"]["difference"]
    bias = np.array(found["accelerometer"]["parameters"]["bias_counts"])
    assert away == pytest.approx(bias - [33_600, 33_400, 32_000])
    assert found["gyroscope"]["certificate"] is None
    assert any("33600" in line and "bias" in line for line in lines)


CERTIFICATE = """
certificate:
  accelerometer:
    bias_counts: [33600, 33400, 32000]
    scale_counts_per_unit: [550, 550, 550]
"""


def test_time_counts_from_the_start_of_the_session_whatever_the_logger_s_clock(
    finished: RunSession, session: Path
) -> None:
    for pose in sorted(session.parent.rglob("pose_*.csv")):
        table = np.loadtxt(pose, delimiter=",", skiprows=1)
        table[:, 0] += 5000
        _rewrite(pose, table)
    assert pipeline("run", session) == 0
    later, sooner = results_in(session.with_suffix(".run")), results_in(finished.folder)
    assert later["session_start_s"] == pytest.approx(sooner["session_start_s"] + 5000)
    for triad in ("accelerometer", "gyroscope"):
        for one, other in zip(later[triad]["poses"], sooner[triad]["poses"], strict=True):
            assert one["time_s"] == pytest.approx(other["time_s"], abs=1e-6)
            assert one["time_s"] > 0


# --- what is read how often ----------------------------------------------------------------------


def test_poses_that_serve_both_triads_are_read_once(
    session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edit(session, "  runs:\n", "  runs:\n    - {poses: accelerometer/pose_*.csv, rate: stopped}\n")
    read: list[str] = []

    def counting(path: Path, *rest: object) -> object:
        read.append(path.name)
        return read_log(path, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(session_logs, "read_log", counting)
    assert pipeline("run", session) == 0
    assert len(read) == 36
    assert results_in(session.with_suffix(".run"))["gyroscope"]["n_poses"] == 36


# --- what is refused ---------------------------------------------------------------------------


def test_a_named_pose_that_moved_is_refused_by_its_name(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pose = session.parent / "accelerometer/pose_07.csv"
    table = np.loadtxt(pose, delimiter=",", skiprows=1)
    table[len(table) // 2 :, 1] += 500
    _rewrite(pose, table)
    assert pipeline("run", session) == 4
    assert "accelerometer/pose_07.csv: the sensor moved: accelerometer x" in capsys.readouterr().err
    assert not session.with_suffix(".run").exists()


def test_a_found_pose_that_moved_is_left_out_and_named(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _one_long_log(session, tilted=4)
    assert pipeline("run", session) == 0
    warning = capsys.readouterr().err
    assert warning.startswith("warning: Left out: long.csv")
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
    assert "choose another with --output" in capsys.readouterr().err


def _rewrite(path: Path, table: np.ndarray) -> None:
    header = path.read_text(encoding="utf-8").splitlines()[0]
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.4f")


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
        if i == tilted:  # by 0.2°, half way: too little to break the pose in two
            table[len(table) // 2 :, 1:3] += 12
        both = np.vstack([table, moving])
        both[:, 0] = start + step * np.arange(len(both))
        start = both[-1, 0] + step
        parts.append(both)
    header = pose.read_text(encoding="utf-8").splitlines()[0]
    np.savetxt(session.parent / "long.csv", np.vstack(parts), delimiter=",", header=header,
               comments="", fmt="%.4f")
    edit(session, "poses: accelerometer/pose_*.csv\n",
         "poses: {log: long.csv, find: still}\n")
