"""Readings that a logger truncated toward zero, in logs made of noise."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.truncation import before_truncation, truncation_steps
from calib.poses.imu_log import FloatArray, ImuLog

STEP = 0.01  #: m/s²
ROWS = 600


def logs(
    whole: Callable[[FloatArray], FloatArray], noise: float, seed: int, tails: bool = False
) -> list[ImuLog]:
    """Eighteen logs in steps of 0.01 m/s² with ``noise`` in steps, two axes of each near zero."""
    random = np.random.default_rng(seed)
    written = []
    for i in range(18):
        mean = random.normal(scale=3 * noise, size=3) + 981 * np.eye(3)[i % 3]
        scatter = (random.laplace(scale=np.sqrt(0.5), size=(ROWS, 3)) if tails
                   else random.normal(size=(ROWS, 3)))
        readings = STEP * whole(mean + noise * scatter)
        written.append(ImuLog(f"pose_{i}", np.arange(ROWS) / 100, readings,
                              np.full((ROWS, 3), np.nan)))
    return written


def half_way(values: FloatArray) -> FloatArray:
    """Values of a converter that has none at zero."""
    return np.floor(values) + 0.5


@pytest.mark.parametrize(("noise", "most"), [(1.2, 12), (3.0, 18), (10.0, 18)])
def test_readings_truncated_toward_zero_are_told(noise: float, most: int) -> None:
    told = [truncation_steps(logs(np.trunc, noise, seed), "accelerometer") for seed in range(20)]
    assert sum(steps is not None for steps in told) >= most
    assert all(np.allclose(steps, STEP) for steps in told if steps is not None)


@pytest.mark.parametrize("tails", [False, True])
@pytest.mark.parametrize("noise", [0.2, 0.7, 1.2, 3.0, 10.0])
@pytest.mark.parametrize("whole", [np.rint, np.floor, np.ceil, half_way])
def test_readings_cut_otherwise_are_not(
    whole: Callable[[FloatArray], FloatArray], noise: float, tails: bool
) -> None:
    for seed in range(20):
        assert truncation_steps(logs(whole, noise, seed, tails), "accelerometer") is None


def test_a_dead_band_about_zero_is_no_truncation() -> None:
    def dead(values: FloatArray) -> FloatArray:
        return np.where(np.abs(values) < 3.5, 0.0, np.rint(values))

    for seed in range(20):
        assert truncation_steps(logs(dead, 3.0, seed), "accelerometer") is None


def test_the_means_of_truncated_readings_are_restored() -> None:
    pairs = zip(logs(lambda values: values, 3.0, 0), logs(np.trunc, 3.0, 0), strict=True)
    for true, cut in pairs:
        restored = before_truncation(cut, {"accelerometer": np.full(3, STEP)})
        off = restored.accelerometer.mean(axis=0) - true.accelerometer.mean(axis=0)
        assert np.abs(off).max() < 0.1 * STEP


def test_a_short_log_and_one_without_the_triad_tell_nothing() -> None:
    (first, *_) = logs(np.trunc, 3.0, 0)
    assert truncation_steps([first.take(slice(0, 5))], "accelerometer") is None
    assert truncation_steps([first], "gyroscope") is None
    assert np.isnan(before_truncation(first, {"gyroscope": np.ones(3)}).gyroscope).all()


def test_zeros_in_one_part_of_one_log_tell_nothing() -> None:
    log = logs(np.rint, 3.0, 0)[0]
    readings = np.full((ROWS, 3), 5.0) + log.accelerometer
    readings[:50, 0] = STEP * np.trunc(np.random.default_rng(0).normal(scale=3.0, size=50))
    assert truncation_steps([replace(log, accelerometer=readings)], "accelerometer") is None
