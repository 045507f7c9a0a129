"""``pipeline run``: stages, what is read and followed how often, what is refused."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.logs.read import read_log
from pipeline.results.write import results_of, results_text
from pipeline.stages import session_logs
from pipeline.stages.context import RunContext
from pipeline.stages.run import StageResult, run_stages
from tests.pipeline.conftest import RunSession
from tests.sessions import edit, pipeline, results_in, rewrite_rows, run_without_page


def test_the_results_of_the_stages_are_handed_over_in_their_order(session: Path) -> None:
    results: list[StageResult] = []
    outcome = run_stages(load_config(session), RunContext(), results.append)
    assert results == [outcome.rates["17rpm"], outcome.recordings, outcome.triad("accelerometer"),
                       outcome.triad("gyroscope")]


def test_a_stage_without_a_section_makes_nothing_and_is_not_announced(session: Path) -> None:
    text = session.read_text(encoding="utf-8")
    session.write_text(text[: text.index("\ngyroscope:")] + "\n", encoding="utf-8")
    results: list[StageResult] = []
    outcome = run_stages(load_config(session), RunContext(), results.append)
    assert outcome.triad("gyroscope") is None
    assert results[2:] == [outcome.triad("accelerometer")]


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


@pytest.mark.parametrize(("changed", "new"), [
    ("gyroscope", ["gyroscope"]), ("accelerometer", ["accelerometer", "gyroscope"])])
def test_after_a_change_of_a_model_no_log_is_read_again_and_the_results_are_those_of_a_new_run(
    session: Path, changed: str, new: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = run_stages(load_config(session), RunContext())
    head, word, tail = session.read_text(encoding="utf-8").partition(f"\n{changed}:")
    model = "model: [bias, scale, misalignment"
    session.write_text(head + word + tail.replace(model, f"{model}, quadratic", 1), "utf-8")
    config = load_config(session)
    expected = results_text(results_of(run_stages(config, RunContext())))
    for name in ("read_session", "average_recordings", "measure_rates"):
        monkeypatch.delattr(f"pipeline.stages.run.{name}")
    results: list[StageResult] = []
    again = run_stages(config, RunContext(), results.append, before)
    assert results_text(results_of(again)) == expected
    assert results == [again.triad(triad) for triad in new]  # type: ignore[arg-type]


def test_other_logs_are_read_whatever_was_run_before(session: Path) -> None:
    before = run_stages(load_config(session), RunContext())
    edit(session, "accelerometer/pose_*.csv\n", "accelerometer/pose_*.csv\n  exclude: [pose_03]\n")
    after = run_stages(load_config(session), RunContext(), before=before)
    triad = after.triad("accelerometer")
    assert triad is not None
    assert len(triad.comparison.poses) == 17


@pytest.mark.parametrize("alone", ["accelerometer", "gyroscope"])
def test_each_triad_can_be_calibrated_alone(
    finished: RunSession, session: Path, alone: str
) -> None:
    other = {"accelerometer": "gyroscope", "gyroscope": "accelerometer"}[alone]
    blocks = session.read_text(encoding="utf-8").split("\n\n")
    kept = [block for block in blocks if not block.startswith(f"{other}:")]
    assert len(kept) == len(blocks) - 1
    session.write_text("\n\n".join(kept), encoding="utf-8")
    found = run_without_page(session)
    assert found[other] is None
    both = results_in(finished.folder)[alone]
    assert found[alone]["parameters"] == both["parameters"]


def test_both_solvers_end_in_the_same_parameters(finished: RunSession, session: Path) -> None:
    edit(session, "  model: [bias, scale, misalignment]",
         "  model: [bias, scale, misalignment]\n  solver: paper")
    paper, default = run_without_page(session), results_in(finished.folder)
    for triad in ("accelerometer", "gyroscope"):
        for key, values in paper[triad]["parameters"].items():
            same = np.array(default[triad]["parameters"][key])
            scale = np.abs(same).max()
            assert np.abs(np.array(values) - same).max() < 1e-9 * scale, (triad, key)


def test_an_added_effect_is_fitted_and_reported_with_its_unit(session: Path) -> None:
    edit(session, "accelerometer/pose_*.csv\n  model: [bias, scale, misalignment]",
         "accelerometer/pose_*.csv\n  model: [bias, scale, misalignment, bias_drift]")
    found = run_without_page(session)["accelerometer"]
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
        rewrite_rows(pose, table)
    later, sooner = run_without_page(session), results_in(finished.folder)
    assert later["session_start_s"] == pytest.approx(sooner["session_start_s"] + 5000)
    for triad in ("accelerometer", "gyroscope"):
        for one, other in zip(later[triad]["poses"], sooner[triad]["poses"], strict=True):
            assert one["time_s"] == pytest.approx(other["time_s"], abs=1e-6)
            assert one["time_s"] > 0


def test_poses_that_serve_both_triads_are_read_once(
    session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edit(session, "  runs:\n", "  runs:\n    - {poses: accelerometer/pose_*.csv, rate: stopped}\n")
    read: list[str] = []

    def counting(path: Path, *rest: object) -> object:
        read.append(path.name)
        return read_log(path, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(session_logs, "read_log", counting)
    assert run_without_page(session)["gyroscope"]["n_poses"] == 36
    assert len(read) == 36
