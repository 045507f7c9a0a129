"""Axes cut off below the converter's range, in logs made of noise."""

import numpy as np
import pytest

from calib.consistency.clipping import require_unclipped
from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

SPEC = TriadSpec(4.0, 16, "twos-complement")
ROWS = 600


def logs(noise: float = 30.0, limit: float = np.inf, seed: int = 0) -> list[ImuLog]:
    """Six logs at rates from -12,000 to 12,000 counts, cut off at ``limit``."""
    random = np.random.default_rng(seed)
    made = []
    for i, rate in enumerate(np.linspace(-12_000, 12_000, 6)):
        counts: FloatArray = rate * np.array([0.2, 1.0, -0.5]) + random.uniform(-0.5, 0.5, 3)
        counts = counts + noise * random.normal(size=(ROWS, 3))
        counts = np.clip(np.round(counts), -limit, limit)
        made.append(ImuLog(f"pose_{i}", np.arange(ROWS) / 100, np.full((ROWS, 3), np.nan), counts))
    return made


def test_an_axis_that_stops_at_a_limit_is_named_with_its_value() -> None:
    with pytest.raises(Undetermined, match="pose_5: gyroscope y stands at 11990 in"):
        require_unclipped(logs(limit=11_990.0), "gyroscope", SPEC)


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 3.0, 30.0])
def test_noise_is_not_clipped_however_coarse(noise: float) -> None:
    """Wherever between two steps the means of a quiet sensor lie."""
    for seed in range(20):
        require_unclipped(logs(noise, seed=seed), "gyroscope", SPEC)


@pytest.mark.parametrize("noise", [1.5, 3.0, 30.0])
def test_a_limit_shows_beside_noise_of_a_step_and_a_half_and_more(noise: float) -> None:
    for seed in range(20):
        with pytest.raises(Undetermined, match="pose_5: gyroscope y stands at 11990"):
            require_unclipped(logs(noise, limit=11_990.0, seed=seed), "gyroscope", SPEC)


def test_one_quiet_log_among_noisy_ones_is_not_clipped() -> None:
    """At the largest rate, where its few values are those of the limit."""
    for seed in range(20):
        *noisy, _ = logs(seed=seed)
        require_unclipped([*noisy, logs(0.8, seed=seed)[-1]], "gyroscope", SPEC)


def test_one_log_alone_and_a_triad_that_was_not_logged_say_nothing() -> None:
    clipped = logs(limit=11_990.0)
    require_unclipped(clipped[:1], "gyroscope", SPEC)
    require_unclipped(clipped, "accelerometer", SPEC)
