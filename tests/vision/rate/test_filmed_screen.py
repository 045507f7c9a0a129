"""A camera's clock from a hand on a screen: the screen holds its pictures, the camera samples."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.world.screen import FloatArray, ScreenHand
from vision.errors import RateRefused
from vision.rate.filmed_screen import FilmedScreen, clock_by_screen

TURN = 2 * np.pi
RATE = 17 * TURN / 60


def measured(time_s: FloatArray, angle_rad: FloatArray, dropped: int = 0) -> Any:
    """What the vision stage hands on of a film, as far as a clock needs it."""
    return SimpleNamespace(
        history=SimpleNamespace(angle=SimpleNamespace(time_s=time_s, angle_rad=angle_rad)),
        revolutions=abs(angle_rad[-1] - angle_rad[0]) / TURN,
        frames=SimpleNamespace(dropped=dropped),
    )


def filmed(
    seed: int, seconds: float, fps: float, refresh_hz: float, fast_ppm: float = 80.0
) -> FilmedScreen:
    """A film read out line by line, in which the lines spread over up to 8 ms of the disc."""
    rng = np.random.default_rng(seed)
    hand = ScreenHand(RATE, refresh_hz, float(rng.choice([1 / 200, 1 / 100, 1 / 60, 1 / 33])),
                      missed=0.005, phase=rng.random(), seed=seed)
    true_s = 1 + rng.random() / fps + np.arange(round(seconds * fps)) / fps
    row_s = rng.uniform(0, 4e-3) * np.sin(RATE * true_s + rng.uniform(0, TURN))
    rows = np.linspace(-1, 1, 5) * rng.uniform(0, 4e-3)
    angle = np.mean([hand.angle(true_s + row_s + row) - RATE * row for row in rows], axis=0)
    angle += 2e-3 * rng.standard_normal(len(angle))
    stamps = (true_s - true_s[0]) * (1 + 1e-6 * fast_ppm)
    return clock_by_screen(measured(stamps, angle), "film.mp4", RATE, refresh_hz)


@pytest.mark.parametrize("fps", [15.0, 24.0, 29.97, 60.0])
def test_a_clock_80_ppm_fast_is_known_to_a_few_ppm_after_five_minutes(fps: float) -> None:
    """Screens off their 60 Hz by some hundred ppm, 12 of each frame rate."""
    rng = np.random.default_rng(round(fps))
    films = [filmed(seed, 300.0, fps, 60 * (1 + 3e-4 * rng.standard_normal()))
             for seed in range(12)]
    error = np.array([1e6 * film.fast - 80 for film in films])
    sd = np.array([1e6 * np.hypot(film.frames_sd, film.refresh_sd) for film in films])
    assert np.median(sd) < 3
    assert (np.abs(error) < 3 * np.hypot(sd, 0.5)).all()
    assert np.sqrt(np.mean((error / sd) ** 2)) < 1.5


def test_a_screen_in_step_with_the_camera_has_a_large_sd_instead_of_a_wrong_clock() -> None:
    """60 Hz and 30 frames per second, 20 to 80 ppm apart: in a minute no refresh slips through."""
    rng = np.random.default_rng(3)
    films = [filmed(seed, 60.0, 30.0, 60 * (1 + 1e-6 * rng.uniform(20, 80)), 0.0)
             for seed in range(20)]
    error = np.array([1e6 * film.fast for film in films])
    sd = np.array([1e6 * np.hypot(film.frames_sd, film.refresh_sd) for film in films])
    assert np.median(sd) > 20
    assert np.abs(error / sd).max() < 3


def test_a_few_turns_and_lost_frames_are_refused() -> None:
    time = np.arange(300) / 15.0
    with pytest.raises(RateRefused, match=r"film.mp4: the hand makes 5.\d turns, at least 8"):
        clock_by_screen(measured(time, RATE * time), "film.mp4", RATE, 60.0)
    time = np.arange(900) / 15.0
    with pytest.raises(RateRefused, match="3 frames are missing without a gap"):
        clock_by_screen(measured(time, RATE * time, 3), "film.mp4", RATE, 60.0)
