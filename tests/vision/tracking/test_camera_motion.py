"""The camera's roll against what lies around the plate, where it can be determined."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from vision.geometry import view_of_ellipse
from vision.tracking.camera_motion import CameraMotion

Image = NDArray[np.uint8]
H, W = 360, 480


def surroundings() -> Image:
    """Something to be seen everywhere."""
    coarse = np.random.default_rng(0).uniform(60, 200, (12, 16)).astype(np.float32)
    return np.asarray(cv2.resize(coarse, (W, H), interpolation=cv2.INTER_CUBIC), np.uint8)


def rolled(image: Image, angle_rad: float) -> Image:
    """The image turned counter-clockwise about the spindle."""
    turn = cv2.getRotationMatrix2D((W / 2, H / 2), np.degrees(angle_rad), 1.0)
    moved = cv2.warpAffine(image, turn, (W, H), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)


@pytest.mark.parametrize("angle_rad", [0.004, -0.01])
def test_a_roll_is_measured_step_by_step(angle_rad: float) -> None:
    background = surroundings()
    camera = CameraMotion(view_of_ellipse((W / 2, H / 2), (120.0, 120.0), 0.0), background)
    measured = [camera.roll(rolled(background, angle_rad * i / 5)) for i in range(1, 6)]
    assert measured[-1] == pytest.approx(angle_rad, rel=0.05)


@pytest.mark.parametrize(
    ("centre_px", "radius_px"), [((240.0, 180.0), 400.0), ((180.0, 120.0), 350.0)]
)
def test_a_plate_that_fills_the_frame_leaves_the_roll_undetermined(
    centre_px: tuple[float, float], radius_px: float
) -> None:
    """Nothing is to be seen around it, or one corner of the frame only."""
    camera = CameraMotion(view_of_ellipse(centre_px, (radius_px, radius_px), 0.0), surroundings())
    assert np.isnan(camera.roll(surroundings()))


def test_an_even_surface_around_the_plate_leaves_the_roll_undetermined() -> None:
    even = np.full((H, W), 100, np.uint8)
    camera = CameraMotion(view_of_ellipse((W / 2, H / 2), (120.0, 120.0), 0.0), even)
    assert np.isnan(camera.roll(even))


def test_a_thing_that_moves_beside_the_plate_does_not_roll_the_camera() -> None:
    background = surroundings()
    camera = CameraMotion(view_of_ellipse((W / 2, H / 2), (120.0, 120.0), 0.0), background)
    rolls = []
    for x in range(0, 90, 15):
        frame = background.copy()
        frame[20:120, x : x + 40] = 250
        rolls.append(camera.roll(frame))
    seen = np.array(rolls)[np.isfinite(rolls)]
    assert np.abs(seen).max(initial=0.0) < np.radians(0.15)
