"""The mean rate beside slow changes of it: a drift, and a motor's start and stop."""

from contextlib import suppress

import numpy as np
import pytest

from tests.chance import spread_bounds
from tests.vision.mixed_tracks import mixed_track
from tests.vision.motor_tracks import motor_track
from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.rate.measure import measure_rate
from vision.rate.slow_changes import slow_rate
from vision.rate.terms import fit_rate
from vision.rate.unwrap import continuous_angle


def drifting(time: FloatArray, rpm: float, change: float) -> FloatArray:
    """Angle of a plate whose rate changes evenly by a share of its mean."""
    span = float(np.ptp(time))
    return rpm * RPM * (time + change * (time**2 / (2 * span) - time / 2))


@pytest.mark.parametrize("change", [-0.008, 0.006])
def test_a_plate_that_warms_up_has_its_mean_rate_and_its_change(change: float) -> None:
    """It was refused: its angle wanders by a degree about an even rotation."""
    time, _ = steady(33.3, seconds=80.0, fps=30)
    track = phase_track(time, drifting(time, 33.3, change), noise_rad=NOISE)
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(rate.rate_rad_s - 33.3 * RPM) < 3 * rate.sd_rad_s < 3e-6 * rate.rate_rad_s
    (said,) = rate.warnings
    assert f"the rate changes by {change:+.2%} ± 0.00%, evenly, within the clip" in said


def test_the_mean_of_a_drifting_rate_is_that_of_the_clip_not_of_its_frames() -> None:
    """Nine tenths of the frames of the second half were dropped, and the stamps show it."""
    time, _ = steady(33.3, seconds=60.0, fps=30)
    kept = (time < 30) | (np.arange(len(time)) % 10 == 9)
    track = phase_track(time[kept], drifting(time, 33.3, 0.006)[kept], noise_rad=NOISE)
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(rate.rate_rad_s - 33.3 * RPM) < 3 * rate.sd_rad_s < 2e-5 * rate.rate_rad_s


def test_the_sds_of_a_mean_rate_and_of_its_change_are_those_of_repeated_measurements() -> None:
    pulls = []
    for seed in range(80):
        rng = np.random.default_rng([seed, 33])
        time = np.arange(rng.integers(60, 600)) / 30
        change = 0.003 * rng.standard_normal()
        track = phase_track(time, drifting(time, 33.3, change), noise_rad=5e-3, seed=seed)
        angle = continuous_angle(track, time, 33.3 * RPM)
        fit, x, base = fit_rate(track, angle, angle.stepped, 33.3 * RPM)
        mean = slow_rate(fit, x, angle.angle_rad, base, (False, False))
        pulls.append([(mean.rate_rad_s - 33.3 * RPM) / mean.sd_rad_s,
                      (mean.change - change) / mean.change_sd])
    rms = np.sqrt(np.mean(np.square(pulls), axis=0))
    low, high = spread_bounds(len(pulls))
    assert (low < rms).all()
    assert (rms < high).all()


@pytest.mark.parametrize("change", [-0.0015, 0.006])
def test_a_plate_that_starts_and_then_drifts_is_measured_after_the_start(change: float) -> None:
    """It was refused: what drifts had no steady part."""
    time, _ = steady(33.3, seconds=60.0, fps=30)
    fine = np.arange(0, 60, 1e-3)
    started = 1 - np.exp(-np.maximum(fine - 1, 0) / 0.7)
    rates = 33.3 * RPM * started * (1 + change * (fine / 60 - 0.5))
    angle = np.interp(time, fine, np.cumsum(rates) * 1e-3)
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    middle_s = rate.history.angle.time_s[[0, -1]].mean()
    true = 33.3 * RPM * (1 + change * (middle_s / 60 - 0.5))
    assert abs(rate.rate_rad_s - true) < 3 * rate.sd_rad_s < 3e-5 * true
    assert "turns steadily from" in rate.warnings[0]
    assert "evenly, within the clip" in rate.warnings[1]


def test_a_change_that_noise_hides_from_turn_to_turn_is_told() -> None:
    """The rates of three turns that scatter by half a degree differ by more than a per cent."""
    time = np.arange(240) / 25
    track = phase_track(time, drifting(time, 16.67, -0.012), noise_rad=8.6e-3)
    with pytest.raises(RateRefused, match="does not turn steadily"):
        measure_rate(track, timebase=CLOCK)


@pytest.mark.parametrize("track", [793, 909])
def test_a_change_of_two_per_cent_in_a_turn_and_a_half_is_told(track: int) -> None:
    """Where the noise was that of a fit which takes it to be as small as usual, it was hidden."""
    rate = measure_rate(mixed_track((90417, track)).track, timebase=CLOCK)
    assert any("the rate changes by" in text for text in rate.warnings)


def test_of_less_than_two_turns_no_drift_stands_for_frames_that_are_mismeasured() -> None:
    """Without a prior the drift follows them, and the plate was said to be unsteady."""
    track = mixed_track((6121, 118))
    rate = measure_rate(track.track, timebase=CLOCK)
    assert abs(rate.rate_rad_s - abs(track.rate_rad_s)) < 4 * rate.sd_rad_s


def test_a_plate_that_drifts_evenly_has_no_steady_part() -> None:
    time, _ = steady(33.3, seconds=80.0, fps=30)
    track = phase_track(time, drifting(time, 33.3, 0.013), noise_rad=2e-3)
    with pytest.raises(RateRefused, match="does not turn steadily"):
        measure_rate(track, timebase=CLOCK)


def test_the_end_of_the_run_up_does_not_lower_the_rate() -> None:
    pulls = []
    for seed in range(30):
        made = motor_track(np.random.default_rng([seed, 78]))
        with suppress(RateRefused):
            rate = measure_rate(made.track, timebase=CLOCK)
            pulls.append((rate.rate_rad_s - made.rate_rad_s) / rate.uncertainty.image_rad_s)
    assert len(pulls) >= 29
    away = np.abs(pulls)
    assert (away < 4).all()
    assert (away < 2).mean() > 0.93
    assert abs(np.mean(pulls)) < 0.35


def test_a_transient_is_told_from_a_steady_plate() -> None:
    """A run-up of a second is taken out; the sd grows by what the shorter part leaves open."""
    fps, rate, tau = 30.0, 33.3 * RPM, 1.0
    time = np.arange(0, 30, 1 / fps)
    past = np.maximum(time - 2, 0)
    angle = rate * (past - tau * (1 - np.exp(-past / tau)))
    measured = measure_rate(phase_track(time, angle, noise_rad=4e-4), timebase=CLOCK)
    assert "turns steadily from" in measured.warnings[0]
    assert abs(measured.rate_rad_s / rate - 1) < 2e-6
    whole = measure_rate(phase_track(time, rate * time, noise_rad=4e-4), timebase=CLOCK)
    assert measured.uncertainty.image_rad_s < 5 * whole.uncertainty.image_rad_s
