"""A new effect is one decorated function: YAML, run, diagnosis, page, apply, export follow."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from calib.effects.effect import EFFECTS, Page, effect, per_axis
from calib.effects.typical import typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray
from tests.sessions import pipeline, quick_session, results_in

KNEE_C = 20.0


@pytest.fixture
def knee() -> Iterator[str]:
    """An effect that no other line of the product knows, registered for one test."""

    @effect(
        *AXES,
        unit="{u}/K",
        logged=("temperature_c",),
        page=Page(
            formula="e_k = c_k · (T − 20 °C)²",
            typical={"any": typical(note="unknown")},
            source="a test",
            confounded="temperature_bias",
            separates="a soak",
            expressions=(f"0.01 * (temperature_c - {KNEE_C})**2",),
        ),
    )
    def heat_knee(at: Conditions) -> FloatArray:
        """Bias that moves with the square of the warmth above a knee."""
        warmth = at.column("temperature_c")[:, None] - KNEE_C
        return per_axis(1e-2 * warmth**2 * np.ones_like(at.vector))

    yield heat_knee.__name__
    del EFFECTS["heat_knee"]


def with_model(config: Path, name: str) -> Path:
    text = config.read_text(encoding="utf-8")
    assert "misalignment]" in text
    config.write_text(text.replace("misalignment]", f"misalignment, {name}]"), encoding="utf-8")
    return config


def test_a_registered_effect_is_usable_everywhere(
    knee: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, _ = quick_session(tmp_path)
    with_model(config, knee)
    assert pipeline("check", config) == 0
    assert pipeline("run", config) == 0
    results = config.with_suffix(".run")
    capsys.readouterr()
    for triad in ("accelerometer", "gyroscope"):
        section = results_in(results)[triad]
        assert section["model"][-1] == knee
        assert len(section["effects"][knee]["values"]) == 3
        assert section["effects"][knee]["unit"] == {
            "accelerometer": "m/s²/K", "gyroscope": "rad/s/K"
        }[triad]
    assert knee in (results / "report.html").read_text(encoding="utf-8")

    assert pipeline("effects", knee) == 0
    page = capsys.readouterr().out
    assert "(T − 20 °C)²" in page
    assert f"pipeline add CONFIG accelerometer.{knee}" in page
    assert pipeline("effects") == 0
    assert knee in capsys.readouterr().out

    log = config.parent / "gyroscope/17rpm/pose_03.csv"
    corrected = []
    for size in (0.0, 1.0):
        theirs = results_in(results)
        for triad in ("accelerometer", "gyroscope"):
            theirs[triad]["correction"]["theta"][-3:] = [size] * 3
            theirs[triad]["effects"][knee]["values"] = [size] * 3
        corrected.append(applied(theirs, log, tmp_path / f"out{size:g}.csv"))
    plain, with_effect = corrected
    warmth = plain[:, 7] - KNEE_C
    assert warmth.any()
    # As large for every axis: the misalignment of per mille is all that could tell.
    assert plain[:, 1:4] - with_effect[:, 1:4] == pytest.approx(
        np.tile(1e-2 * warmth[:, None] ** 2, 3), rel=0.05
    )

    assert pipeline("export", results, "--to", "arduino", "--output", tmp_path / "c") == 0
    header = (tmp_path / "c/imu_calibration.h").read_text(encoding="utf-8")
    assert "/* errors of heat_knee */" in header
    assert header.count("* (temperature_c - 20.0f)") == 6  # three axes of two triads


def applied(results: dict[str, object], log: Path, output: Path) -> FloatArray:
    folder = output.with_suffix("")
    folder.mkdir()
    (folder / "results.json").write_text(json.dumps(results), encoding="utf-8")
    assert pipeline("apply", folder, log, "--output", output) == 0
    return np.loadtxt(output, delimiter=",", skiprows=1)


def test_a_log_without_the_column_is_refused_by_its_name(
    knee: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, _ = quick_session(tmp_path)
    assert pipeline("run", with_model(config, knee)) == 0
    log = tmp_path / "cold.csv"
    rows = (config.parent / "gyroscope/17rpm/pose_03.csv").read_text().splitlines()
    log.write_text("\n".join(row.rsplit(",", 1)[0] for row in rows))
    capsys.readouterr()
    assert pipeline("apply", config.with_suffix(".run"), log) == 4
    message = capsys.readouterr().err
    assert "contains heat_knee" in message
    assert "the log has no column temperature_c" in message
