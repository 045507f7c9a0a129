"""``pipeline apply`` takes what no log tells as after the session, and says so."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.apply import apply_results
from pipeline.results.read import load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log, with_effects
from tests.sessions import results_in


@pytest.mark.parametrize(
    ("name", "theta", "shift", "says"),
    [
        ("hysteresis", [0.02, -0.01, 0.03], 0.0, "no sample of a log tells hysteresis"),
        ("vibration_rectification", [1.0, 2.0, 3.0], 0.0, "tells vibration_rectification"),
        ("bias_drift", [3600.0, 0.0, 0.0], "end", "bias_drift at the end of the session, and"),
        ("bias_step", [0.2, 0.0, 0.0], 0.2, "bias_step at the last level."),
    ],
)
def test_what_no_log_tells_counts_as_after_the_session_and_is_said(
    finished: RunSession, tmp_path: Path, name: str, theta: list[float], shift: float | str,
    says: str,
) -> None:
    with_effects(finished, tmp_path, "accelerometer", {name: theta})
    results = results_in(tmp_path)
    if name != "bias_step":  # which stays as it is
        results["accelerometer"]["prediction"]["parts"]["untold"] = {name: 0.0123}
    (tmp_path / "results.json").write_text(json.dumps(results), encoding="utf-8")
    stored = load_results(tmp_path)
    plain = apply_results(load_results(finished.folder), a_log()).triads["accelerometer"]
    applied = apply_results(stored, a_log())
    end = max(pose["time_s"] for pose in results["accelerometer"]["poses"])
    wanted = end if shift == "end" else shift
    assert plain[:, 0] - applied.triads["accelerometer"][:, 0] == pytest.approx(
        np.full(500, wanted))
    [note] = applied.left_out
    assert note.startswith("accelerometer: ")
    assert says in note
    assert ("12 mm/s²" in note) == (name != "bias_step")
    told = apply_results(stored, a_log(), session_clock=True).left_out
    assert bool(told) == (name in ("hysteresis", "vibration_rectification"))
