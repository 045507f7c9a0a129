"""The rate of the part of a clip between the motor's start and its stop."""

from contextlib import suppress

import numpy as np

from tests.vision.motor_tracks import motor_track
from tests.vision.phase_tracks import CLOCK, RPM, phase_track
from vision.errors import RateRefused
from vision.rate.measure import measure_rate


def test_the_end_of_the_run_up_does_not_lower_the_rate() -> None:
    pulls = []
    for seed in range(60):
        made = motor_track(np.random.default_rng([seed, 78]))
        with suppress(RateRefused):
            rate = measure_rate(made.track, timebase=CLOCK)
            pulls.append((rate.rate_rad_s - made.rate_rad_s) / rate.uncertainty.image_rad_s)
    assert len(pulls) >= 59
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
