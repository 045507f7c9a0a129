"""A shutter that changes while the camera films moves the angle against the stamps."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vision.phase_tracks import CLOCK, phase_track, steady
from vision.geometry import view_of_ellipse
from vision.plate.polar import polar_grid
from vision.plate.template import Template
from vision.rate.measure import measure_rate
from vision.tracking.tracker import PlateTracker

RPM = 2 * np.pi / 60
SECONDS = 25.0


@pytest.mark.parametrize(("first_s", "last_s"), [(1 / 60, 1 / 30), (1 / 30, 1 / 250)])
@pytest.mark.parametrize("stamped", [0.5, 0.0, -0.5])
def test_the_rate_is_within_its_sd_wherever_in_the_exposure_the_stamps_are(
    first_s: float, last_s: float, stamped: float
) -> None:
    time, angle = steady(33.3, SECONDS)
    exposure = first_s + (last_s - first_s) * time / SECONDS
    rate_rad_s = 33.3 * RPM
    rng = np.random.default_rng(3)
    smear = (rate_rad_s * exposure) ** 2 / 12 + 2e-4 * rng.standard_normal(len(time))
    track = phase_track(time, angle + stamped * rate_rad_s * exposure, noise_rad=2e-4,
                        smear_rad2=smear - smear.mean())
    rate = measure_rate(track, timebase=CLOCK)
    error = abs(rate.rate_rad_s / rate_rad_s - 1)
    assert error < 2 * rate.sd_rad_s / rate.rate_rad_s
    assert 300e-6 < rate.sd_rad_s / rate.rate_rad_s < 900e-6
    assert any("lock the exposure" in text for text in rate.warnings)


@pytest.mark.parametrize(("smear_noise", "dimmed", "share"), [(3e-4, 0, 0.5), (1.2e-3, 20, 0.9)])
def test_a_smear_that_shows_little_still_widens_the_sd_where_it_changed(
    smear_noise: float, dimmed: int, share: float
) -> None:
    """A faint label, 15 s at 16.6 rpm: at 3 sds with even light, at 1 where that changes too."""
    time, angle = steady(16.6, 15.0)
    exposure = 0.007 * (0.036 / 0.007) ** (time / 15.0)
    rate_rad_s = 16.6 * RPM
    pulls = []
    for seed in range(20):
        rng = np.random.default_rng([seed, 31])
        smear = (rate_rad_s * exposure) ** 2 / 12 + smear_noise * rng.standard_normal(len(time))
        track = phase_track(time, angle + 0.5 * rate_rad_s * exposure, noise_rad=1e-3,
                            smear_rad2=smear - smear.mean(), seed=seed,
                            brightness=np.linspace(140, 140 - dimmed, len(time)))
        rate = measure_rate(track, timebase=CLOCK)
        pulls.append((rate.rate_rad_s - rate_rad_s) / rate.sd_rad_s)
    assert (np.abs(pulls) < 2).mean() > share


def test_a_lamp_that_dims_while_the_smear_stays_costs_little_and_is_no_shutter() -> None:
    time, angle = steady(33.3, SECONDS)
    smear = 1e-6 * np.random.default_rng(3).standard_normal(len(time))
    track = phase_track(time, angle, noise_rad=2e-4, smear_rad2=smear,
                        brightness=np.linspace(140, 100, len(time)))
    rate = measure_rate(track, timebase=CLOCK)
    assert not any("lock the exposure" in text for text in rate.warnings)
    assert rate.sd_rad_s / rate.rate_rad_s < 60e-6


def test_an_exposure_that_stays_costs_next_to_nothing() -> None:
    time, angle = steady(33.3, SECONDS)
    smear = 2e-4 * np.random.default_rng(4).standard_normal(len(time))
    still = measure_rate(phase_track(time, angle, noise_rad=2e-4), timebase=CLOCK)
    noisy = measure_rate(phase_track(time, angle, noise_rad=2e-4, smear_rad2=smear),
                         timebase=CLOCK)
    assert noisy.warnings == ()
    assert noisy.sd_rad_s == pytest.approx(still.sd_rad_s, abs=20e-6 * still.rate_rad_s)
    told = 0
    for seed in range(60):
        smear = 1e-3 * np.random.default_rng([seed, 32]).standard_normal(len(time))
        track = phase_track(time, angle, noise_rad=2e-4, smear_rad2=smear)
        told += bool(measure_rate(track, timebase=CLOCK).warnings)
    assert told <= 3


def test_the_tracker_measures_how_far_each_frame_is_smeared_beyond_its_template() -> None:
    """The plate averaged over the angle that it turns while the shutter is open."""
    n, width_rad = 1024, 0.07
    grid = polar_grid(view_of_ellipse((240.0, 180.0), (140.0, 140.0), 0.0),
                      np.linspace(0.5, 0.9, 20), n, (360, 480))
    azimuth = np.arange(n) * 2 * np.pi / n
    away = np.angle(np.exp(1j * (azimuth - 1.0)))
    plate = 60 * np.exp(-((away / 0.12) ** 2) / 2) + 30 * np.cos(5 * azimuth)
    order = np.fft.rfftfreq(n, 1 / n)

    def shown(angle: float, swept: float) -> NDArray[np.uint8]:
        smear = np.sinc(order * swept / (2 * np.pi)) * np.exp(-1j * order * angle)
        seen = 120 + np.fft.irfft(np.fft.rfft(plate) * smear, n)
        return np.rint(np.tile(seen, (20, 1))).astype(np.uint8)

    turning = np.tile(plate - plate.mean(), (20, 1)).astype(np.float32)
    background = np.full((20, n), 120 + plate.mean(), np.float32)
    tracker = PlateTracker(Template(grid, background, turning, 1.0, 1.0), 1.0)
    time = np.arange(40) / 15
    swept = np.where(np.arange(40) < 20, 0.0, width_rad)
    angles = tracker.angles(time, [shown(t, s) for t, s in zip(time, swept, strict=True)])
    assert abs(angles.smear_rad2[:20].mean()) < 0.05 * width_rad**2 / 12
    assert angles.smear_rad2[20:].mean() == pytest.approx(width_rad**2 / 12, rel=0.1)
