"""Sample times from the device's clock, or from arrivals in bursts."""

import numpy as np
import pytest

from pipeline.devices.sample import DeviceClock, Unwrap, rate_of, straight_line
from pipeline.devices.xsens import COUNTER
from tests.pipeline.devices.real_streams import captured


def heard(made_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Arrivals: the host looks 30 times a second at most, and every few seconds is busy."""
    looked = np.cumsum(rng.exponential(1 / 30, 10_000))
    busy = rng.random(len(looked)) < 0.01
    looked = np.sort(looked + busy * rng.uniform(0, 0.5, len(looked)))
    return looked[np.searchsorted(looked, made_s)]


@pytest.mark.parametrize("seed", range(5))
def test_the_line_through_bursts_is_that_of_the_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    made = 3.0 + np.arange(6000) / 99.3
    t0, step = straight_line(heard(made, rng))
    assert 1 / step == pytest.approx(99.3, rel=3e-4)
    assert t0 == pytest.approx(3.0, abs=0.02)


def test_real_bursts_give_the_same_rate_in_both_halves() -> None:
    path = captured("mpu6050_sunsided", "set-2__unmoved-with-z-pointing-front-and-x-up.csv.gz")
    arrival = np.loadtxt(path, delimiter=",", skiprows=1)[:, 0]
    half = len(arrival) // 2
    first, second = straight_line(arrival[:half])[1], straight_line(arrival[half:])[1]
    assert second == pytest.approx(first, rel=2e-3)
    assert first == pytest.approx(0.01, rel=0.02)


def test_a_host_clock_that_jumps_back_does_not_spoil_the_line() -> None:
    path = captured("mpu6050_sunsided", "set-1__unmoved-z-pointing-left.csv.gz")
    arrival = np.loadtxt(path, delimiter=",", skiprows=1)[:, 0]
    assert (np.diff(arrival) < -10).any()
    assert straight_line(arrival)[1] == pytest.approx(0.01, rel=0.01)


def test_counters_wrap_and_tell_of_lost_samples() -> None:
    unwrap = Unwrap(COUNTER)
    assert [unwrap(ticks) for ticks in (65534, 65535, 0, 1, 5)] == [0, 1, 2, 3, 7]
    assert unwrap.restarts == 0


def test_a_device_that_starts_anew_goes_on_from_where_it_was() -> None:
    unwrap = Unwrap(DeviceClock("board microseconds", 1e-6, 1 << 32))
    assert [unwrap(ticks) for ticks in (10, 20, 3, 13)] == [0, 10, 11, 21]
    assert unwrap.restarts == 1
    assert Unwrap(DeviceClock("rows", None, None))(5) == 0


def test_a_clock_coarser_than_the_samples_neither_stands_nor_drifts() -> None:
    unwrap = Unwrap(DeviceClock("board milliseconds", 1e-3, 1 << 32))
    assert [unwrap(ticks) for ticks in (5, 5, 7, 8, 8, 8, 11, 12)] == [0, 1, 2, 3, 4, 5, 6, 7]
    assert unwrap.restarts == 0
    made_s = np.arange(5000) / 1700
    ticks = [unwrap(int(1e3 * made) + 13) for made in made_s]
    assert (np.diff(ticks) >= 1).all()


def test_few_samples_give_no_rate() -> None:
    assert np.isnan(rate_of([1.0]))
    assert straight_line(np.array([2.0])) == (2.0, 0.0)
    assert rate_of([0.0, 0.5, 1.0]) == 2.0
