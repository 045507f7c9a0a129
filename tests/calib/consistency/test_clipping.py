"""Axes cut off below the converter's range, in logs made of noise."""

from statistics import NormalDist

import numpy as np
import pytest

from calib.consistency.raw_samples import levels_of_cut, require_unclipped
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
        counts = np.minimum(np.round(counts), limit)
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
        with pytest.raises(Undetermined, match="pose_5: gyroscope y stands at 11999"):
            require_unclipped(logs(noise, limit=11_999.0, seed=seed), "gyroscope", SPEC)


def test_one_quiet_log_among_noisy_ones_is_not_clipped() -> None:
    """At the largest rate, where its few values are those of the limit."""
    for seed in range(20):
        *noisy, _ = logs(seed=seed)
        require_unclipped([*noisy, logs(0.8, seed=seed)[-1]], "gyroscope", SPEC)


@pytest.mark.parametrize("share", [0.07, 0.12, 0.25])
def test_a_limit_shows_where_little_is_cut_off(share: float) -> None:
    """Where a pose's mean hardly moves by it, nothing need be said."""
    beyond = 12_000 + 30 * NormalDist().inv_cdf(1 - share)
    for seed in range(10):
        with pytest.raises(Undetermined, match="pose_5: gyroscope y stands at 120"):
            require_unclipped(logs(limit=round(beyond), seed=seed), "gyroscope", SPEC)


@pytest.mark.parametrize("amplitude", [0.4, 1.0, 1.6, 1.9, 2.4, 3.0, 20.0, 200.0])
@pytest.mark.parametrize("noise", [0.0, 0.2, 1.0])
def test_a_wave_of_the_turning_plate_is_not_clipped(amplitude: float, noise: float) -> None:
    random = np.random.default_rng(1)
    angle = np.arange(ROWS) / 57
    for start in np.linspace(0, 1, 8):
        wave = start + amplitude * np.sin(angle[:, None] + np.array([0.0, 2.0, 4.0]))
        counts = np.round(wave + noise * random.normal(size=(ROWS, 3)))
        log = ImuLog("pose", np.arange(ROWS) / 100, np.full((ROWS, 3), np.nan), counts)
        require_unclipped([log], "gyroscope", SPEC)


def test_a_triad_that_was_not_logged_says_nothing() -> None:
    require_unclipped(logs(limit=11_990.0), "accelerometer", SPEC)


@pytest.mark.parametrize("limit", [11_000.0, 11_990.0])
def test_the_level_of_a_cut_is_that_beyond_which_no_log_goes(limit: float) -> None:
    """In the middle of the noise, and far below it, where the axis stands still."""
    *others, cut = logs(limit=limit)
    assert levels_of_cut(cut, others, "gyroscope")[1] == limit
    assert np.isnan(levels_of_cut(cut, others, "gyroscope")[[0, 2]]).all()
    assert np.isnan(levels_of_cut(others[2], [*others, cut], "gyroscope")).all()
    beyond = logs(seed=1)[-1]
    assert np.isnan(levels_of_cut(cut, [*others, beyond], "gyroscope")).all()


def test_a_sensor_that_stopped_has_no_level_of_a_cut() -> None:
    *others, last = logs()
    last.gyroscope[:] = last.gyroscope[0]
    assert np.isnan(levels_of_cut(last, others, "gyroscope")).all()
