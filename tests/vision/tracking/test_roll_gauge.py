"""The roll of a camera as the picture around the plate shows it, and what it does to the sd."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vision.phase_tracks import CLOCK, phase_track, steady
from vision.geometry import view_of_ellipse
from vision.rate.measure import measure_rate
from vision.tracking.roll_gauge import RollGauge

VIEW = view_of_ellipse((240.0, 190.0), (120.0, 110.0), 0.0)
ROLL_RAD = 3e-3


def table(seed: int = 2) -> NDArray[np.float32]:
    rough = cv2.GaussianBlur(np.random.default_rng(seed).standard_normal((360, 480)), (0, 0), 4)
    return np.asarray(110 + 25 * rough / rough.std(), np.float32)


def seen(picture: NDArray[Any], seed: int, light: float = 1.0) -> NDArray[np.uint8]:
    noise = np.random.default_rng(seed).normal(0, 2, picture.shape)
    return np.clip(light * picture + noise, 0, 255).astype(np.uint8)


def moved(x: float = 0.0, y: float = 0.0, roll_rad: float = 0.0, zoom: float = 1.0) -> NDArray[Any]:
    """The table, rolled counter-clockwise about the spindle."""
    turn = cv2.getRotationMatrix2D((240.0, 190.0), np.degrees(roll_rad), zoom)
    turn[:, 2] += x, y
    return np.asarray(cv2.warpAffine(table(), turn, (480, 360), borderMode=cv2.BORDER_REFLECT))


@pytest.fixture(scope="module")
def gauge() -> RollGauge:
    return RollGauge([seen(table(), seed) for seed in range(10, 30)], VIEW)


@pytest.mark.parametrize("also", [{}, {"x": 0.7, "y": -0.5}, {"zoom": 1.002}])
@pytest.mark.parametrize("roll_rad", [ROLL_RAD, -ROLL_RAD, 0.0])
def test_the_roll_is_told_from_a_shift_a_zoom_and_another_light(
    also: dict[str, float], roll_rad: float, gauge: RollGauge
) -> None:
    image = seen(moved(roll_rad=roll_rad, **also), 50, light=0.97)
    assert gauge.roll_rad(image) == pytest.approx(roll_rad, abs=0.05 * ROLL_RAD)


def test_what_turns_inside_the_rim_is_no_roll(gauge: RollGauge) -> None:
    image = table()
    y, x = np.indices(image.shape)
    plate = ((x - 240) / 100) ** 2 + ((y - 190) / 90) ** 2 < 1
    image[plate] = table(9)[plate]
    assert abs(gauge.roll_rad(seen(image, 51))) < 0.05 * ROLL_RAD


def test_a_plate_that_fills_the_frame_shows_no_roll() -> None:
    wide = view_of_ellipse((240.0, 180.0), (700.0, 700.0), 0.0)
    assert np.isnan(RollGauge([seen(table(), 1)], wide).roll_rad(seen(table(), 2)))


def rate_with(roll_rad: NDArray[Any]) -> Any:
    """The rate of a minute whose angles have the roll of the camera in them."""
    time, angle = steady()
    looked = np.where(np.arange(len(time)) % 16 == 0, roll_rad, np.nan)
    return measure_rate(phase_track(time, angle + roll_rad, noise_rad=2e-4, roll_rad=looked),
                        timebase=CLOCK)


def test_a_rate_of_the_camera_is_part_of_the_sd() -> None:
    time, _ = steady()
    rate = rate_with(np.radians(0.02) * time)
    error = rate.rate_rad_s / (33.3 * 2 * np.pi / 60) - 1
    assert error == pytest.approx(100e-6, rel=0.1)
    assert rate.uncertainty.image_rad_s / rate.rate_rad_s == pytest.approx(100e-6, rel=0.1)
    assert any("it rolls by 1.2° against what stands around" in text for text in rate.warnings)


def test_scatter_of_the_looks_is_no_roll() -> None:
    noise = np.random.default_rng(4).normal(0, 2e-5, 900)
    rate, still = rate_with(noise), rate_with(np.zeros(900))
    assert rate.uncertainty.image_rad_s < 1.5 * still.uncertainty.image_rad_s
    assert not any("rolls" in text for text in rate.warnings)
