"""A log that froze is told from a converter whose steps are larger than the noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.raw_samples import find_frozen, require_running
from calib.errors import Undetermined
from calib.poses.imu_log import ImuLog

ROWS, POSES, FROZE = 400, 24, 5


def session(sd_in_steps: float, memory: float, seed: int) -> list[ImuLog]:
    """Logs of poses, each in a place of its own between the steps of the converter."""
    rng = np.random.default_rng(seed)

    def triad() -> np.ndarray:
        white = rng.normal(size=(ROWS, 3))
        slow = np.empty_like(white)
        slow[0] = white[0]
        for i in range(1, ROWS):
            slow[i] = memory * slow[i - 1] + np.sqrt(1 - memory**2) * white[i]
        return np.asarray(np.rint(rng.uniform(-50, 50, 3) + sd_in_steps * slow))

    return [ImuLog(f"pose_{i}", np.arange(ROWS) / 100, triad(), triad()) for i in range(POSES)]


@pytest.mark.parametrize("sd_in_steps", [0.02, 0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_a_coarse_quiet_converter_did_not_freeze(sd_in_steps: float, memory: float) -> None:
    for seed in range(3):
        assert find_frozen(session(sd_in_steps, memory, seed)) == []


@pytest.mark.parametrize(("of", "sd_in_steps"), [
    *(("all axes", sd) for sd in (0.4, 0.7, 2.0, 20.0)), ("the accelerometer", 0.7),
    ("the gyroscope", 20.0), ("gyroscope y", 2.0), ("accelerometer x", 20.0)])
def test_a_log_that_froze_is_found_where_noise_would_show(of: str, sd_in_steps: float) -> None:
    logs = session(sd_in_steps, 0.0, 7)
    for name, triad in (("accelerometer", logs[FROZE].accelerometer),
                        ("gyroscope", logs[FROZE].gyroscope)):
        axes = ["xyz".index(of[-1])] if of[-2] == " " else [0, 1, 2]
        if of == "all axes" or name in of:
            triad[150:, axes] = triad[150, axes]
    (frozen,) = find_frozen(logs)
    assert (frozen.index, frozen.start + frozen.count, frozen.of) == (FROZE, ROWS, of)
    assert abs(frozen.start - 150) < 10


def test_all_poses_of_an_axis_that_is_cut_off_are_named_at_once() -> None:
    runs = [session(20.0, 0.0, seed) for seed in (1, 2)]
    for logs in runs:
        logs[FROZE].accelerometer[:, 2] = 9600.0
    runs[1][FROZE] = replace(runs[1][FROZE], label="turning/pose_5")
    with pytest.raises(Undetermined) as refused:
        require_running(runs)
    said = str(refused.value)
    assert said.startswith("pose_5: stands still: its samples 1 to 400 are one and the same")
    assert "The axis is cut off at that reading, or stuck. Record the pose again. " in said
    assert said.endswith("The same is to be done with turning/pose_5.")


def test_a_log_that_froze_has_a_part_before() -> None:
    logs = session(20.0, 0.0, 7)
    for triad in (logs[FROZE].accelerometer, logs[FROZE].gyroscope):
        triad[150:] = triad[150]
    with pytest.raises(Undetermined, match=r"pose_5: froze: .* to the part before"):
        require_running([logs])
