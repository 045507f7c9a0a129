"""The history: one line for every run, shown as a staircase."""

import json
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from pipeline.results.history import history_rows, history_text, read_history, with_step
from pipeline.results.schema.file import ResultsFile
from pipeline.results.schema.noise import HistoryLine
from tests.pipeline.conftest import RunSession
from tests.sessions import pipeline, results_in

pytestmark = pytest.mark.usefixtures("bare_page")

NOON = datetime.fromisoformat("2026-05-01T12:00:00+02:00")


def with_model(found: dict[str, Any], model: list[str], rms: float) -> dict[str, Any]:
    section = found["accelerometer"]
    return found | {"accelerometer": section | {
        "model": model, "residual_rms": rms,
        "correction": section["correction"] | {"model": model}}}


def test_a_run_leaves_one_line_with_model_errors_and_verdict(finished: RunSession) -> None:
    (step,) = read_history(finished.folder)
    found = results_in(finished.folder)
    for triad in ("accelerometer", "gyroscope"):
        own = step.triads[triad]
        assert own.model == ["bias", "scale", "misalignment"]
        assert own.residual_rms == found[triad]["residual_rms"]
        assert own.loo_rms == found[triad]["loo_rms"]
        assert own.chi2 / own.dof == pytest.approx(found[triad]["chi2"] / found[triad]["dof"])
        assert own.verdict == found[triad]["diagnosis"]["verdict"]
    assert step.config_sha256 == found["config_sha256"]
    assert datetime.fromisoformat(step.when).tzinfo is not None


def test_the_table_is_a_staircase_and_shows_equal_runs_once(
    finished: RunSession, tmp_path: Path
) -> None:
    found = results_in(finished.folder)
    base = ["bias", "scale", "misalignment"]
    steps: tuple[HistoryLine, ...] = ()
    for model, rms in ((base, 0.009), (base, 0.009), ([*base, "quadratic"], 0.0005)):
        steps = with_step(steps, ResultsFile.parsed(with_model(found, model, rms)), NOON)
    (tmp_path / "history.jsonl").write_text(history_text(steps), encoding="utf-8")
    assert len(read_history(tmp_path)) == 3
    titles, *rows = history_rows(read_history(tmp_path))["accelerometer"]
    assert titles[:3] == ("when", "model", "RMS [mm/s²]")
    assert titles[-2] == "dof"  # tells runs of one model by their poses
    assert [row[-2] for row in rows] == ["9", "9"]
    assert [row[:3] for row in rows] == [
        ("2026-05-01 12:00", "base", "9"),
        ("2026-05-01 12:00", "base + quadratic", "0.5"),
    ]
    assert len(history_rows(read_history(tmp_path))["gyroscope"]) == 2  # title, one row


def test_the_command_shows_both_triads(
    finished: RunSession, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("history", finished.config) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if not line.startswith(" ")] == ["accelerometer", "gyroscope"]
    assert "nothing_missing" in lines[2]
    assert pipeline("history", finished.config, "--json") == 0
    runs = json.loads(capsys.readouterr().out)
    assert "".join(json.dumps(run, ensure_ascii=False) + "\n" for run in runs) == (
        finished.folder / "history.jsonl").read_text(encoding="utf-8")


def test_without_a_run_the_command_says_what_to_type(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("history", finished.config, "--output", tmp_path) == 0
    assert f"Type: pipeline run {finished.config}" in capsys.readouterr().out


@pytest.mark.parametrize("line", ["{", "[]", json.dumps({"when": "now"})])
def test_a_damaged_history_is_reported_with_its_line_and_nothing_is_written(
    finished: RunSession, tmp_path: Path, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    history = tmp_path / "history.jsonl"
    steps = with_step((), ResultsFile.parsed(results_in(finished.folder)), NOON)
    history.write_text(history_text(steps), encoding="utf-8")
    whole = history.read_text(encoding="utf-8") + line + "\n"
    history.write_text(whole, encoding="utf-8")
    assert pipeline("run", finished.config, "--output", tmp_path) == 3
    assert f"{history}:2: is not a line" in capsys.readouterr().err
    assert history.read_text(encoding="utf-8") == whole
    assert list(tmp_path.iterdir()) == [history]
