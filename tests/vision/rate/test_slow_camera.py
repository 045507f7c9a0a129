"""Clips whose recorder repeated the frames of a camera that is slower than the clip."""

import numpy as np
import pytest

from tests.vision.phase_tracks import CLOCK, RPM, phase_track, steady
from vision.phase_track import PhaseTrack
from vision.rate.measure import measure_rate
from vision.rate.slow_camera import frame_times


def filled(rng: np.random.Generator, *, slower: float, seconds: float = 15.0) -> PhaseTrack:
    """A clip of 30 frames per second that shows the latest frame of a slower camera."""
    time = np.arange(round(30 * seconds)) / 30
    camera_s = 1 / (30 * slower)
    number = np.floor(time / camera_s + rng.random())
    angle = 33.3 * RPM * number * camera_s
    return phase_track(time, angle, noise_rad=4e-4, seed=int(rng.integers(1 << 30)),
                       duplicate=np.diff(number, prepend=-1) == 0)


def test_the_rate_of_a_slow_camera_is_measured() -> None:
    """Timed by the stamps a quarter of such clips was refused as unsteady."""
    pulls = []
    for seed in range(30):
        rng = np.random.default_rng([seed, 92])
        slower = rng.uniform(0.55, 0.98)
        rate = measure_rate(filled(rng, slower=slower), timebase=CLOCK)
        assert any("the camera took" in text for text in rate.warnings)
        assert rate.fit.rms_rad < 1e-3
        pulls.append((rate.rate_rad_s / (33.3 * RPM) - 1) * rate.rate_rad_s / rate.sd_rad_s)
    assert np.abs(pulls).max() < 3


@pytest.mark.parametrize("slower", [0.6, 0.83, 0.97])
def test_the_frame_rate_of_the_camera_is_found(slower: float) -> None:
    track = filled(np.random.default_rng(1), slower=slower)
    frames = frame_times(track, track.time_s)
    assert frames.camera_fps == pytest.approx(30 * slower, rel=4 * frames.relative_sd)
    assert frames.repetitions.sum() == track.duplicate.sum()
    assert len(frames.time_s) + frames.repetitions.sum() == len(track.time_s)


def test_a_recorder_that_hesitates_keeps_its_stamps() -> None:
    """Some frames are delivered twice; the next ones are stamped when they were taken."""
    time, angle = steady(33.3, seconds=20, fps=30)
    for at in ([100], [100, 300, 500], [40, 41, 333]):
        again = np.zeros(len(time), bool)
        again[at] = True
        track = phase_track(time, np.where(again, np.roll(angle, 1), angle), noise_rad=4e-4,
                            duplicate=again)
        assert frame_times(track, track.time_s).camera_fps is None
