"""Results of a run with further effects written into them, and a log to correct by them."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from calib.effects.effect import EFFECTS
from calib.poses.imu_log import ImuLog
from pipeline.results.read import Stored, load_results
from tests.pipeline.conftest import RunSession
from tests.sessions import results_in


def a_log(**columns: np.ndarray) -> ImuLog:
    """Five seconds of random counts."""
    rng = np.random.default_rng(0)
    counts = rng.integers(20_000, 45_000, (2, 500, 3)).astype(float)
    return ImuLog("drive.csv", np.arange(500) / 100, counts[0], counts[1], columns)


def with_effects(
    finished: RunSession, folder: Path, triad: str, effects: dict[str, list[float]],
    own: dict[str, Any] | None = None, shapes: dict[str, float] | None = None,
) -> Stored:
    """The session's results with further effects of these sizes."""
    found = results_in(finished.folder)
    stored = found[triad]["correction"]
    for name, values in effects.items():
        stored["model"].append(name)
        found[triad]["model"].append(name)
        if name in EFFECTS and (shape := EFFECTS[name].shape) is not None:
            stored["shapes"][name] = shape.starts[0]
        stored["theta"] += values
        found[triad]["effects"][name] = {"values": values, "sd": [0.1] * len(values), "unit": "?"}
    stored["own_effects"] = own or {}
    stored["shapes"] |= shapes or {}
    (folder / "results.json").write_text(json.dumps(found), encoding="utf-8")
    return load_results(folder)
