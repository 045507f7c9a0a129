"""Frozen blocks: found in a noisy log, never in a quiet one, left out with their rows named."""

import numpy as np
import pytest

from calib.poses.checks.frozen import frozen_samples, without_frozen
from calib.poses.imu_log import ImuLog

STEP = 0.00122  #: of the public log that has such blocks, rad/s


def noisy(sd_in_steps: float, t: int = 5000, seed: int = 0) -> np.ndarray:
    """Readings (t, 3) of a converter."""
    rng = np.random.default_rng(seed)
    return np.asarray(np.rint(rng.normal(0.4, sd_in_steps, (t, 3))) * STEP)


def log_of(readings: np.ndarray) -> ImuLog:
    return ImuLog("log", np.arange(len(readings)) / 100, np.full_like(readings, np.nan), readings)


@pytest.mark.parametrize("sd_in_steps", [1.0, 3.0, 20.0])
def test_a_frozen_block_is_found_whole(sd_in_steps: float) -> None:
    readings = noisy(sd_in_steps)
    readings[700:800], readings[3000:3100] = readings[700], readings[3000]
    frozen = np.flatnonzero(frozen_samples(log_of(readings)))
    true = np.r_[701:800, 3001:3100]
    assert set(true) <= set(frozen)
    assert len(frozen) <= len(true) + 4  # a neighbour may repeat by chance


@pytest.mark.parametrize("sd_in_steps", [0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 5.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_log_without_frozen_blocks_has_none(sd_in_steps: float, seed: int) -> None:
    assert not frozen_samples(log_of(noisy(sd_in_steps, 20_000, seed))).any()


def test_a_sensor_that_is_read_faster_than_it_measures_is_not_frozen() -> None:
    assert not frozen_samples(log_of(np.repeat(noisy(3.0, 500), 10, axis=0))).any()


def test_one_triad_that_froze_is_found_beside_another_that_runs() -> None:
    readings = noisy(3.0)
    readings[700:800] = readings[700]
    log = ImuLog("log", np.arange(5000) / 100, noisy(3.0, seed=1), readings)
    assert set(range(701, 800)) <= set(np.flatnonzero(frozen_samples(log)))


def test_frozen_samples_are_left_out_and_named() -> None:
    readings = noisy(3.0)
    readings[700:800] = readings[700]
    rest, note = without_frozen(log_of(readings), turning=False)
    assert len(rest.time_s) == 5000 - 99
    assert note == ("log: 1 frozen block, in which the logger wrote one reading again and again "
                    "(rows 702-800); 99 of 5000 samples are left out.")
    turning, _ = without_frozen(log_of(readings), turning=True)
    assert turning.time_s[0] == 8.0  # the longest stretch without a gap
    same, nothing = without_frozen(log_of(noisy(3.0)), turning=False)
    assert nothing is None
    assert len(same.time_s) == 5000
