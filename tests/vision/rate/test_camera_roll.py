"""A camera that rolls while it films."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from vision.rate.camera_roll import camera_roll
from vision.rate.measure import measure_rate
from vision.tracking.track import track_phase

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.edited_clips import again
from tests.vision.phase_tracks import CLOCK
from tests.vision.rendered_clips import Render, small_scene
from tests.world.film import Scene
from tests.world.plate import PlateMotion

MOTION = PlateMotion(33.3 * 2 * np.pi / 60)
SCENE = Scene(tilt_rad=0.3)


@pytest.fixture(scope="module")
def still(render: Render) -> Path:
    return render(MOTION, SCENE, seconds=12)[0]


def test_a_camera_that_stands_does_not_roll(still: Path) -> None:
    track = track_phase(still)
    assert camera_roll(track, CLOCK.times(track)) is None


@pytest.mark.parametrize("degrees_per_s", [0.1, -0.05])
def test_a_camera_that_rolls_is_noticed_and_doubted(
    still: Path, tmp_path: Path, degrees_per_s: float
) -> None:
    h, w = SCENE.height_px, SCENE.width_px

    def roll(i: int, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        turn = cv2.getRotationMatrix2D((w / 2, h / 2), degrees_per_s * i / 15, 1.0)
        return cv2.warpAffine(image, turn, (w, h), borderMode=cv2.BORDER_REPLICATE)

    track = track_phase(again(still, tmp_path / "rolls.mp4", change=roll))
    seen = camera_roll(track, CLOCK.times(track))
    assert seen is not None
    assert np.degrees(seen.rate_rad_s) == pytest.approx(degrees_per_s, rel=0.15)
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(rate.rate_rad_s - MOTION.rate_rad_s) < 2 * rate.uncertainty.image_rad_s
    assert any("the camera rolled by" in warning for warning in rate.warnings)


@pytest.mark.parametrize("fps", [50, 120])
def test_a_hand_beside_the_plate_is_no_camera_that_rolls(render: Render, fps: float) -> None:
    """It is in most of the frames that are learned from, and moves in one place only."""
    motion = PlateMotion(-45.0 * 2 * np.pi / 60)
    path, _ = render(motion, small_scene(hand_until_s=2.0), seconds=6, fps=fps)
    track = track_phase(path)
    assert camera_roll(track, CLOCK.times(track)) is None
