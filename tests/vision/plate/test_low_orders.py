"""Angular orders of reduced frames about an axis, against those of the pattern that was drawn."""

import numpy as np
import pytest

from vision.geometry import view_of_ellipse
from vision.plate.low_orders import ORDERS, PixelSeries

RADII = np.linspace(0.1, 0.97, 20)
SHAPE = (360, 640)
VIEW = view_of_ellipse((300.0, 190.0), (150.0, 110.0), 0.3)
ANGLES = np.array([0.0, 0.4, 1.9])


def frames(amplitude: np.ndarray) -> list[np.ndarray]:
    """Waves of orders 1 ... around the plate at three of its angles, grey 128 elsewhere."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    radius, azimuth = VIEW.plate(x, y)
    order = np.arange(1, ORDERS + 1)[:, None, None]
    images = []
    for angle in ANGLES:
        wave = amplitude[:, None, None] * np.cos(order * (azimuth - angle))
        images.append(np.round(128 + (radius < 1) * wave.sum(axis=0)).astype(np.uint8))
    return images


def test_orders_are_those_of_the_pattern_and_turn_with_it() -> None:
    amplitude = np.array([20.0, 0, 12, 0, 9, 0, 6, 4])
    spectra = PixelSeries(frames(amplitude)).low_orders(VIEW, RADII)
    assert spectra.shape == (ORDERS, len(RADII), len(ANGLES))
    outer = spectra[:, RADII > 0.6]  # nearer to the spindle the waves are narrower than its pixels
    order = np.arange(1, ORDERS + 1)[:, None, None]
    expected = amplitude[:, None, None] / 2 * np.exp(-1j * order * ANGLES)
    assert np.abs(outer - expected).max() < 1.2


def test_what_lies_outside_the_frame_does_not_vary() -> None:
    rng = np.random.default_rng(3)
    images = [rng.integers(0, 255, SHAPE, np.uint8) for _ in range(5)]
    beyond = view_of_ellipse((1300.0, 190.0), (150.0, 110.0), 0.3)
    spectra = PixelSeries(images).low_orders(beyond, RADII)
    assert spectra == pytest.approx(0)
