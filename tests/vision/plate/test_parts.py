"""A pattern that repeats around the plate: how many parts pass, which way, and about which axis."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from vision.geometry import PlateView, view_of_ellipse
from vision.plate.parts import EqualParts, equal_parts
from vision.plate.polar import Grid, Strips, polar_grid

FRAMES, FPS, SHAPE = 180, 30.0, (360, 480)
TIME = np.arange(FRAMES) / FPS
RADII = np.linspace(0.1, 0.97, 20)
TRUE = view_of_ellipse((240.0, 190.0), (120.0, 95.0), 0.1).about(243.0, 184.0)
GUESS = view_of_ellipse((236.0, 192.0), (122.0, 103.0), 0.0)

Light = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def found(light: Light, noise: float = 3.0) -> EqualParts | None:
    """Equal parts of frames in which a place (radius, azimuth) of the plate has a light by time."""
    rng = np.random.default_rng(1)

    def sample(view: PlateView, azimuths: int, frames: slice) -> tuple[Grid, Strips]:
        grid = polar_grid(view, RADII, azimuths, SHAPE)
        radius, azimuth = TRUE.plate(grid.x.astype(float), grid.y.astype(float))
        strips = light(radius, azimuth) + rng.normal(0, noise, (FRAMES, *radius.shape))
        return grid, strips[frames].astype(np.float32)

    return equal_parts(GUESS, sample, 1024, TIME)


def dots(count: int, rate_rad_s: float) -> Light:
    def light(radius: NDArray[np.float64], azimuth: NDArray[np.float64]) -> NDArray[np.float64]:
        ring = (radius > 0.78) & (radius < 0.95)
        turned = azimuth - rate_rad_s * TIME[:, None, None]
        return np.asarray(30 * ring * np.sign(np.sin(count * turned)))

    return light


@pytest.mark.parametrize(("count", "rate_rad_s"), [
    (18, 1.75), (18, 4.69), (35, -3.47), (72, 4.69), (90, -3.47), (90, 1.75)])
def test_parts_are_counted_and_show_the_axis_and_the_rate(count: int, rate_rad_s: float) -> None:
    parts = found(dots(count, rate_rad_s))
    assert parts is not None
    assert parts.count == count
    # As near as the template's own refinement needs: a tenth of a part.
    assert parts.view.centre_px == pytest.approx(TRUE.centre_px, abs=0.1 * 120 / count)
    seen = np.polyfit(TIME, parts.rotation.angle_rad, 1)[0]
    spacing = 2 * np.pi * FPS / count
    assert (seen - rate_rad_s + spacing / 2) % spacing - spacing / 2 == pytest.approx(0, abs=1e-3)
    assert abs(seen) <= spacing / 2 + 1e-3


def test_where_nothing_varies_along_an_arc_the_parts_are_not_counted() -> None:
    """A division by nothing that varies ended in an error of ours."""
    def behind(radius: NDArray[np.float64], azimuth: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(dots(35, 1.75)(radius, azimuth) * (np.cos(azimuth) < 0.9))

    assert found(behind, noise=0) is None


def test_a_lamp_that_flickers_and_a_single_mark_are_no_parts() -> None:
    def lamp(radius: NDArray[np.float64], azimuth: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(30 * (radius < 1) * np.sin(40 * azimuth)
                          * np.sin(2 * np.pi * 3.1 * TIME)[:, None, None])

    def mark(radius: NDArray[np.float64], azimuth: NDArray[np.float64]) -> NDArray[np.float64]:
        away = np.angle(np.exp(1j * (azimuth - 3.5 * TIME[:, None, None])))
        return np.asarray(150 * (np.abs(radius - 0.8) < 0.1) * (np.abs(away) < 0.1))

    assert found(lamp) is None
    assert found(mark) is None
