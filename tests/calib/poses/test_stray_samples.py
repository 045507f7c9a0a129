"""Stray samples at every dose: found and left out, never in a sound log, refused where too many."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.errors import Undetermined
from calib.poses.checks.stray_samples import stray_samples, without_strays
from calib.poses.imu_log import ImuLog

Mistake = Callable[[np.ndarray, np.ndarray], None]
NEAR_ZERO, TURNING, ON_ONE_G = (20.0, -8.0, 5.0), (100.0, -30.0, 6500.0), (16384.0, 300.0, -200.0)


def noise(samples: int, sd: float, memory: float, mean: tuple[float, ...], seed: int,
          wave: float = 0.0) -> np.ndarray:
    """Counts (t, 3): noise of one correlation time on a wave, rounded."""
    rng = np.random.default_rng(seed)
    white = rng.normal(size=(samples, 3))
    slow = np.empty_like(white)
    slow[0] = white[0]
    for i in range(1, samples):
        slow[i] = memory * slow[i - 1] + np.sqrt(1 - memory**2) * white[i]
    turning = wave * np.sin(np.arange(samples)[:, None] / 30 + np.array([0.0, 2.0, 4.0]))
    return np.asarray(np.rint(np.asarray(mean) + sd * slow + turning))


def log_of(counts: np.ndarray) -> ImuLog:
    nothing = np.full_like(counts, np.nan)
    return ImuLog("pose.csv", np.arange(len(counts)) / 100, nothing, counts)


def zeros(counts: np.ndarray, bad: np.ndarray) -> None:
    counts[bad] = 0.0


def ones(counts: np.ndarray, bad: np.ndarray) -> None:
    counts[bad] = -1.0


def converter_end(counts: np.ndarray, bad: np.ndarray) -> None:
    counts[bad] = -32768.0


def one_axis(counts: np.ndarray, bad: np.ndarray) -> None:
    counts[bad, 0] = 0.0


def spikes(counts: np.ndarray, bad: np.ndarray) -> None:
    counts[bad, 1] += np.random.default_rng(3).integers(100, 200, int(bad.sum()))


@pytest.mark.parametrize("mean", [NEAR_ZERO, TURNING, ON_ONE_G])
@pytest.mark.parametrize("mistake", [zeros, ones, converter_end, one_axis, spikes])
@pytest.mark.parametrize("share", [0.04, 0.05, 0.1, 0.2, 0.3])
def test_the_mean_is_right_or_the_pose_is_refused(
    share: float, mistake: Mistake, mean: tuple[float, ...]
) -> None:
    counts = noise(600, 5.0, 0.3, mean, seed=int(1000 * share))
    bad = np.random.default_rng(1).uniform(size=len(counts)) < share
    true = counts[~bad].mean(axis=0)
    mistake(counts, bad)
    rest, note = without_strays(log_of(counts))
    assert np.abs(rest.gyroscope.mean(axis=0) - true).max() < 5.0 / np.sqrt(len(counts))
    assert note is not None
    assert f"{len(counts) - len(rest.time_s)} of 600 samples are no measurement" in note


@pytest.mark.parametrize("share", [0.4, 0.45])
@pytest.mark.parametrize("mistake", [zeros, ones, converter_end])
def test_too_many_are_refused(mistake: Mistake, share: float) -> None:
    counts = noise(600, 5.0, 0.3, TURNING, seed=2)
    mistake(counts, np.random.default_rng(1).uniform(size=600) < share)
    with pytest.raises(Undetermined, match=r"samples are no measurement: \(.* At most 33 %"):
        without_strays(log_of(counts))


@settings(max_examples=150, deadline=None)
@given(sd=st.floats(0.02, 50.0), memory=st.sampled_from([0.0, 0.5, 0.9, 0.99]),
       samples=st.integers(60, 2000), wave=st.floats(0.0, 10.0), seed=st.integers(0, 10**6),
       mean=st.sampled_from([NEAR_ZERO, TURNING, (0.4, 0.0, -0.5)]))
def test_a_sound_log_has_none(
    sd: float, memory: float, samples: int, wave: float, seed: int, mean: tuple[float, ...]
) -> None:
    assert not stray_samples(noise(samples, sd, memory, mean, seed, wave * sd)).any()


def test_a_median_between_two_levels_makes_no_noise_small() -> None:
    """Half of the samples of an even count on either side: their deviation is half a step."""
    level = np.repeat(np.arange(2010.0, 2020.0), [1, 10, 29, 55, 105, 105, 55, 29, 10, 1])
    values = np.random.default_rng(3).permutation(np.column_stack([level, level - 2000, level]))
    assert np.median(values[:, 0]) == 2014.5
    assert not stray_samples(values).any()


def test_a_knock_is_left_to_the_checks_of_motion() -> None:
    counts = noise(600, 5.0, 0.3, NEAR_ZERO, seed=5)
    counts[200:260, 2] += np.rint(300 * np.sin(np.arange(60) / 5))
    assert not stray_samples(counts).any()


def test_samples_that_do_not_move_the_mean_stay() -> None:
    counts = noise(6000, 5.0, 0.3, NEAR_ZERO, seed=6)
    counts[[100, 3000], 0] += [60, -60]
    assert not stray_samples(counts).any()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("at", [-1.0, -0.5, 0.0, 0.5])
def test_what_a_limit_leaves_of_the_noise_is_no_failed_reading(at: float, seed: int) -> None:
    counts = noise(240, 8.0, 0.3, ON_ONE_G, seed)
    counts[:, 0] = np.minimum(counts[:, 0], ON_ONE_G[0] + np.rint(at * 8.0))
    assert not stray_samples(counts).any()


def test_few_samples_do_not_show_their_noise_well_enough_to_call_one_stray() -> None:
    """Stops of 14 samples, as a slow log has on a plate between the hand and the turn."""
    rng = np.random.default_rng(8)
    stray = [stray_samples(rng.normal(0.0, 1.0, (14, 3))).any() for _ in range(1000)]
    assert np.mean(stray) < 0.005


@pytest.mark.parametrize("ratio", [2 / 3, 0.8, 0.97])
def test_a_coarse_reading_interpolated_at_other_times_is_no_failed_one(ratio: float) -> None:
    """Its own values repeat, and those between them do not: three of four such poses had some."""
    stray = []
    for seed in range(20):
        counts = noise(400, 1.0, 0.3, NEAR_ZERO, seed)
        at = np.arange(0, len(counts) - 1, ratio)
        stray.append(stray_samples(np.column_stack(
            [np.interp(at, np.arange(len(counts)), axis) for axis in counts.T])).any())
    assert np.mean(stray) <= 0.1


@pytest.mark.parametrize(("start_s", "offset_s"), [(0.0154, 0.0031), (0.0154, 0.005),
                                                   (1.7e9, 0.0031)])
def test_a_reading_interpolated_at_the_times_of_another_sensor_is_no_failed_one(
    start_s: float, offset_s: float
) -> None:
    """Rounding parted values that are equal, so that others seemed to repeat."""
    stray = []
    for seed in range(20):
        readings = 0.00061086525 * noise(950, 1.7, 0.0, NEAR_ZERO, seed)
        time_s = start_s + 0.01 * np.arange(len(readings))
        stray.append(stray_samples(np.column_stack(
            [np.interp(time_s[1:] - offset_s, time_s, axis) for axis in readings.T])).any())
    assert not any(stray)


@pytest.mark.parametrize("sd", [1.0, 1.5])
def test_a_coarse_reading_between_stamps_that_agree_by_chance_is_no_failed_one(sd: float) -> None:
    """Stamps of whole milliseconds: one value of each axis repeats in a fifth of such poses."""
    stray = []
    for seed in range(40):
        counts = noise(170, sd, 0.0, NEAR_ZERO, seed)
        at, of = (np.rint(20.0 * np.arange(len(counts)) + 3.0 * np.random.default_rng(
            1000 + seed + order).uniform(size=len(counts))) for order in (0, 40))
        stray.append(stray_samples(np.column_stack(
            [np.interp(at[10:-10], of, axis) for axis in counts.T])).any())
    assert np.mean(stray) <= 0.1


def test_a_reading_that_fails_on_one_level_in_the_noise_of_all_axes_is_left_out() -> None:
    """Its axes repeat zero in the same samples."""
    errors = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        values = rng.normal(rng.normal(0.0, 5.0, 3), 5.0, (150, 3))
        bad = rng.uniform(size=150) < 0.25
        true = values[~bad].mean(axis=0)
        values[bad] = 0.0
        errors.append(np.abs(values[~stray_samples(values)].mean(axis=0) - true).max())
    assert np.mean(np.array(errors) > 2 * 5.0 / np.sqrt(150)) <= 0.05
