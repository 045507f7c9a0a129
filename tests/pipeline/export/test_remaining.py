"""What an export says that it leaves is what a log corrected without the effect has."""

import csv
import math
import re
from pathlib import Path

import numpy as np
import pytest

from calib.effects.catalogue import find_effect
from pipeline.export.parts import remaining_error, session_conditions, triad_named
from pipeline.export.write import EXPORTERS
from pipeline.results.read import load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import with_effects
from tests.sessions import results_in

EFFECTS = {
    "accelerometer": {"quadratic": [1e-4, -2e-4, 3e-4], "temperature_bias": [0.01, 0.0, -0.02]},
    "gyroscope": {"g_sensitivity": [1e-4 * i for i in range(9)], "asymmetry": [1e-3, 0.0, 2e-3]},
}


@pytest.mark.parametrize("triad", EFFECTS)
def test_the_size_is_that_of_the_correction_without_the_effects(
    finished: RunSession, tmp_path: Path, triad: str
) -> None:
    stored = with_effects(finished, tmp_path, triad, EFFECTS[triad])
    each = triad_named(stored, triad)
    assert each is not None
    size = remaining_error(stored, each, EFFECTS[triad])
    at = session_conditions(stored, each, each.correction.model.effects)
    # The poses' corrected vectors as readings: their errors differ in second order only.
    matrix, offset = each.correction.linear_form()
    nominal = type(at).of_vectors(
        np.linalg.solve(matrix, (at.vector - offset).T).T, at.columns, time_s=at.time_s,
        force=at.force)
    whole, bare = each.correction.sensor_part(), each.correction.sensor_part(())
    error = whole.correct(nominal) - bare.correct(nominal)
    assert size == pytest.approx(np.linalg.norm(error, axis=1).max(), rel=0.02)


def test_the_force_comes_from_every_direction(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope",
                          {"g_sensitivity": [1e-3, 0, 0, 0, 0, 0, 0, 0, 0]})
    each = triad_named(stored, "gyroscope")
    assert each is not None
    gravity = stored.gravity_m_s2
    size = remaining_error(stored, each, ["g_sensitivity"])
    assert size == pytest.approx(1e-3 * gravity, rel=1e-3)
    note = next(n for n in EXPORTERS["px4"](stored).loses if "g_sensitivity" in n)
    said = re.search(r"up to ([\d.]+) °/s\.", note)
    assert said is not None
    assert float(said[1]) == pytest.approx(math.degrees(size), rel=0.05)
    at = session_conditions(stored, each, [find_effect("g_sensitivity")])
    assert len(at) == 26 * len(stored.contents.triads["gyroscope"].poses)


def test_a_drift_counts_from_the_beginning_of_the_session(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", {"bias_drift": [1.0, 0, 0]})
    poses = results_in(finished.folder)["accelerometer"]["poses"]
    longest_h = max(abs(pose["time_s"]) for pose in poses) / 3600
    each = triad_named(stored, "accelerometer")
    assert each is not None
    assert remaining_error(stored, each, ["bias_drift"]) == pytest.approx(longest_h, rel=0.01)
    note = next(one for one in EXPORTERS["px4"](stored).loses if "bias_drift" in one)
    assert "`pipeline apply --session-clock` corrects it" in note


def test_errors_of_the_bench_are_no_loss(finished: RunSession, tmp_path: Path) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {"reference_offset": [0.1]})
    for form in ("px4", "arduino", "ardupilot", "kalibr"):
        assert not any("reference_offset" in note for note in EXPORTERS[form](stored).loses)


def test_residuals_are_those_of_the_results(finished: RunSession) -> None:
    stored = load_results(finished.folder)
    text = EXPORTERS["residuals"](stored).files["residuals.csv"]
    rows = list(csv.DictReader(text.splitlines()))
    results = results_in(finished.folder)
    poses = [pose for triad in ("accelerometer", "gyroscope") for pose in results[triad]["poses"]]
    assert len(rows) == len(poses)
    for row, pose in zip(rows, poses, strict=True):
        assert row["pose"] == pose["label"]
        assert float(row["residual"]) == pose["residual"]
        assert float(row["residual_sds"]) == pytest.approx(pose["residual"] / pose["sd"])
        assert float(row["corrected_z"]) == pose["corrected"][2]
        assert float(row["temperature_c"]) == pose["columns"]["temperature_c"]
    assert [row["unit"] for row in rows[:: len(rows) - 1]] == ["m/s²", "rad/s"]
    reference = results["accelerometer"]["poses"][0]["reference"]
    force = np.linalg.norm([float(rows[0][f"corrected_{axis}"]) for axis in "xyz"])
    assert force - reference == pytest.approx(float(rows[0]["residual"]), abs=1e-6)
