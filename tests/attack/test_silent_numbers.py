"""Numbers that would be wrong without a word: each mistake is refused or said, and by its name.

A case is a session, what is done to it, the exit code and what must be said. Nothing is written by
a command that refuses.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.attack.mistakes import CASES, POSE_7
from tests.attack.spoilt import (
    GYR,
    appended,
    config_text,
    copy_of,
    logs,
    scaled,
    write_base,
)
from tests.sessions import pipeline


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sessions without a fault."""
    folder = tmp_path_factory.mktemp("base")
    write_base(folder)
    return folder


@pytest.mark.parametrize("case", CASES)
def test_a_mistake_is_refused_by_its_name_and_nothing_is_written(
    base: Path, tmp_path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, spoil, command, code, said = CASES[case]
    config = copy_of(base, name, tmp_path)
    spoil(config)
    before = sorted(config.parent.rglob("*"))
    assert pipeline(command, config) == code
    message = capsys.readouterr().err
    assert [part for part in said.split("|") if part not in message] == [], message
    assert sorted(config.parent.rglob("*")) == before


@pytest.mark.parametrize("name", ["paper", "rich"])
def test_a_session_without_a_fault_is_not_contradicted(
    base: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, name, tmp_path)
    assert pipeline("check", config) == 0
    assert pipeline("run", config) == 0
    streams = capsys.readouterr()
    assert streams.out.count("Nothing is missing") == 2
    assert "warning" not in streams.err


@pytest.mark.parametrize("share", [0.04, 0.1, 0.2])
def test_readings_that_failed_are_left_out_at_every_dose(
    base: Path, tmp_path: Path, share: float, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, "rich", tmp_path)
    assert pipeline("run", config) == 0
    sound = _gyroscope(config)
    failing = np.random.default_rng(7)

    def zeros(table: np.ndarray) -> np.ndarray:
        table[failing.uniform(size=len(table)) < share, GYR] = 0.0
        return table

    logs("*/**/*.csv", zeros)(config)
    assert pipeline("run", config) == 0
    streams = capsys.readouterr()
    assert "samples are no measurement" in streams.err
    spoilt = _gyroscope(config)
    for name, values in spoilt["parameters"].items():
        apart = np.abs(np.subtract(values, sound["parameters"][name]))
        assert (apart < 3 * np.array(spoilt["sd"][name])).all(), name


def _gyroscope(config: Path) -> dict[str, dict[str, list[float]]]:
    path = config.with_suffix(".run") / "results.json"
    triad: dict[str, dict[str, list[float]]] = json.loads(path.read_text())["gyroscope"]
    return triad


def test_an_effect_that_no_model_has_does_not_stop_the_run(
    base: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, "paper", tmp_path)
    appended("\neffects:\n  foo: {expression: log(-1 - temperature_c**2), unit: '1'}\n")(config)
    assert pipeline("run", config) == 0
    assert "leaves it out" in capsys.readouterr().err


def test_a_gain_off_the_data_sheet_is_said_with_both_reasons(
    base: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copy_of(base, "paper", tmp_path)
    config_text("full_scale_deg_s: 150", "full_scale_deg_s: 300")(config)
    assert pipeline("run", config) == 0
    said = capsys.readouterr().err
    assert "times the data sheet's" in said
    assert "or the rate of the plate is wrong by that factor" in said


def test_results_that_determine_nothing_are_not_applied(base: Path, tmp_path: Path) -> None:
    config = copy_of(base, "paper", tmp_path)
    assert pipeline("run", config) == 0
    results = config.with_suffix(".run") / "results.json"
    text = results.read_text(encoding="utf-8")
    edited = json.loads(text)
    edited["gyroscope"]["sd"]["scale_counts_per_unit"] = [2e4, 2e4, 2e4]
    results.write_text(json.dumps(edited), encoding="utf-8")
    assert pipeline("apply", results, config.parent / POSE_7) == 4
    assert pipeline("export", results, "--to", "json") == 4


def test_stated_errors_of_the_clock_turn_no_misfit_into_gain(base: Path, tmp_path: Path) -> None:
    """Peelle's puzzle: 1 % of a stopwatch made +20 % of gain out of a bad pose."""
    scales = []
    for sd in ("8.73e-05", "0.0175"):
        config = copy_of(base, "paper", tmp_path / sd)
        config_text("sd_rad_s: 8.73e-05", f"sd_rad_s: {sd}")(config)
        logs("gyroscope/17rpm/pose_04.csv", scaled(GYR, 1.01))(config)
        assert pipeline("run", config) == 0
        results = config.with_suffix(".run") / "results.json"
        gyroscope = json.loads(results.read_text(encoding="utf-8"))["gyroscope"]
        scales.append(gyroscope["parameters"]["scale_counts_per_unit"])
    assert np.abs(np.array(scales[1]) / scales[0] - 1).max() < 2e-3
