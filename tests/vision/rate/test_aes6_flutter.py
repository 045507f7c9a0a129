"""Wow and flutter of a platter: the standard's curve, tones, a simulated plate."""

import numpy as np
import pytest

from tests.vision.phase_tracks import CLOCK, RPM, phase_track
from tests.world.plate import PlateMotion
from vision.errors import RateRefused
from vision.rate.aes6_flutter import (
    CURVE_DB,
    CURVE_HZ,
    PlatterFlutter,
    course_of_clip,
    course_of_rates,
    platter_flutter,
)
from vision.rate.measure import measure_rate

RATE = 33.3 * RPM


@pytest.mark.parametrize(("hz", "db"), list(zip(CURVE_HZ, CURVE_DB, strict=True)))
def test_a_tone_of_a_tenth_of_a_per_cent_is_weighted_as_the_standard_says(
    hz: float, db: float
) -> None:
    """A sine stays below 0.0997 % for 95 % of the time; to 1 %."""
    time = np.arange(0, max(20.0, 30 / hz), 1 / max(60.0, 7.3 * hz))
    found = platter_flutter(course_of_rates(time, RATE * (1 + 1e-3 * np.sin(
        2 * np.pi * hz * time + 0.3))), "tone")
    assert found.weighted == pytest.approx(0.997e-3 * 10 ** (db / 20), rel=0.01)
    if 0.3 < hz < 150:  # within the band
        assert found.unweighted == pytest.approx(0.997e-3, rel=0.02)
        at = int(found.amplitude.argmax())
        assert found.hz[at] == pytest.approx(hz, rel=0.05)
        assert found.amplitude[at] == pytest.approx(1e-3, rel=0.16)  # between two bins


def test_a_clip_and_a_gyroscope_agree_on_the_plate_of_the_world() -> None:
    """Wow once per turn and a wave at 4 Hz; the plate's angle is integrated, not differentiated."""
    order = 4.0 * 2 * np.pi / RATE
    motion = PlateMotion(RATE, wow=((1, 1e-3, 0.4), (order, 2e-3, 1.0)), drift_rad_s2=1e-5)
    frames = np.arange(0, 60, 1 / 30)
    track = phase_track(frames, motion.angle(frames), noise_rad=1e-5)
    clip = platter_flutter(course_of_clip(measure_rate(track, timebase=CLOCK)), "clip")
    samples = np.arange(0, 60, 1 / 200)
    rates = motion.rate(samples) + 1e-5 * np.random.default_rng(1).standard_normal(len(samples))
    gyro = platter_flutter(course_of_rates(samples, rates), "gyro")
    # Both waves at all their phases; 33 1/3 rpm is damped by 10.2 dB.
    phase = np.linspace(0, 2 * np.pi, 400)
    both = 2e-3 * np.sin(phase[:, None]) + 1e-3 * 10 ** (-10.2 / 20) * np.sin(phase)
    for found in (clip, gyro):
        assert found.weighted == pytest.approx(np.quantile(np.abs(both), 0.95), rel=0.01)
        assert found.drift_per_s == pytest.approx(1e-5 / RATE, abs=4e-7)
        strongest = found.hz[found.amplitude.argmax()]
        assert strongest == pytest.approx(4.0, abs=0.05)
    assert clip.unweighted == pytest.approx(gyro.unweighted, rel=0.02)
    assert gyro.highest_hz == pytest.approx(90.0)
    assert gyro.weighted_noise == 0.0


def is_noise(found: PlatterFlutter) -> bool:
    """Whether the spectrum has the mean square that is stated, at low and at high frequencies."""
    ratio = (found.amplitude / found.noise_amplitude) ** 2
    return all(abs(half.mean() - 1) < 0.2 for half in np.array_split(ratio, 2))


def test_the_noise_of_the_angles_has_the_figure_that_is_stated() -> None:
    frames = np.arange(0, 60, 1 / 30)
    track = phase_track(frames, 0.5 + RATE * frames, noise_rad=1e-3, seed=4)
    found = platter_flutter(course_of_clip(measure_rate(track, timebase=CLOCK)), "clip")
    assert found.weighted == pytest.approx(found.weighted_noise, rel=0.1)
    assert found.unweighted == pytest.approx(found.unweighted_noise, rel=0.1)
    assert is_noise(found)


def test_the_noise_of_a_gyroscope_has_the_figure_that_is_stated_and_the_room_has_none() -> None:
    time = np.arange(0, 40, 1 / 200)
    noise = 1e-3 * np.random.default_rng(7).standard_normal((len(time), 3))
    room = 0.02 * np.column_stack([np.cos(RATE * time), -np.sin(RATE * time)])  # a leaning table
    found = platter_flutter(course_of_rates(time, RATE + noise[:, 0], room + noise[:, 1:]), "gyro")
    assert found.weighted == pytest.approx(found.weighted_noise, rel=0.15)
    assert found.unweighted == pytest.approx(found.unweighted_noise, rel=0.05)
    assert is_noise(found)


def test_what_is_too_short_or_too_slow_is_refused() -> None:
    for seconds, rate_hz in ((3.0, 50.0), (30.0, 5.0)):
        time = np.arange(0, seconds, 1 / rate_hz)
        with pytest.raises(RateRefused, match=r"log: .* at least 5 s and 9 per second"):
            platter_flutter(course_of_rates(time, np.full(len(time), RATE)), "log")
