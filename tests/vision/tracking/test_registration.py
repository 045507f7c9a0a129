"""A camera in a hand, or bumped once: its motion is taken out by what stands around the plate."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vision.phase_tracks import CLOCK
from vision.rate.measure import measure_rate
from vision.tracking.registration import registration
from vision.tracking.track import track_phase
from vision.video.reader import NO_CHROMA, Frame

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.edited_clips import Image, again
from tests.vision.rendered_clips import Render, small_scene
from tests.world.film import Scene
from tests.world.plate import PlateMotion

MOTION = PlateMotion(33.3 * 2 * np.pi / 60)
SCENE = Scene(tilt_rad=0.3, radius_px=105.0, exposure_s=1 / 200)


@pytest.fixture(scope="module")
def still(render: Render) -> Path:
    return render(MOTION, SCENE, seconds=12)[0]


def with_things_around(image: Image) -> Image:
    """Cards on the table, in all corners of the frame."""
    image = image.copy()
    for x, y, tone in ((30, 40, 220), (70, 300, 30), (400, 50, 200), (440, 290, 60), (30, 170, 90)):
        cv2.rectangle(image, (x, y), (x + 26, y + 34), (tone, tone, tone), -1)
        cv2.rectangle(image, (x + 8, y + 9), (x + 15, y + 20), (255 - tone,) * 3, -1)
    return image


def moved(image: NDArray[Any], x: float, y: float, roll_rad: float) -> NDArray[Any]:
    h, w = image.shape[:2]
    turn = cv2.getRotationMatrix2D((w / 2, h / 2), np.degrees(roll_rad), 1.0)
    turn[:, 2] += x, y
    return np.asarray(cv2.warpAffine(image, turn, (w, h), borderMode=cv2.BORDER_REPLICATE))


def sway(i: int) -> tuple[float, float, float]:
    """Motion of a hand: some pixels and a degree, in some seconds."""
    t = i / 15
    return 9 * np.sin(1.9 * t), 7 * np.sin(2.7 * t + 1), 0.015 * np.sin(1.1 * t + 2)


def roll(i: int) -> tuple[float, float, float]:
    """On a stand that gives way: a tenth of a degree per second."""
    return 0.0, 0.0, float(np.radians(0.1) * i / 15)


def bump(i: int) -> tuple[float, float, float]:
    """Pushed once, after the plate was learned."""
    return (12.0, -7.0, 0.01) if i > 140 else (0.0, 0.0, 0.0)


@pytest.mark.parametrize("how", [sway, bump, roll])
def test_a_camera_that_moves_is_followed(how: Any, still: Path, tmp_path: Path) -> None:
    path = again(still, tmp_path / "hand.mp4",
                 change=lambda i, image: moved(with_things_around(image), *how(i)))
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    error = abs(rate.rate_rad_s / MOTION.rate_rad_s - 1)
    assert error < 3 * rate.sd_rad_s / rate.rate_rad_s < 600e-6
    assert any("the camera moved by up to" in text for text in rate.warnings)


def test_a_roll_that_is_too_slow_to_be_followed_is_in_the_sd(still: Path, tmp_path: Path) -> None:
    """Half a degree in all, 200 ppm: corners move by less than a pixel."""
    path = again(still, tmp_path / "slow.mp4", change=lambda i, image: moved(
        with_things_around(image), 0.0, 0.0, float(np.radians(0.04) * i / 15)))
    track = track_phase(path)
    rate = measure_rate(track, timebase=CLOCK)
    error = abs(rate.rate_rad_s / MOTION.rate_rad_s - 1)
    assert track.notes == ()
    assert 50e-6 < error < 2.5 * rate.uncertainty.image_rad_s / rate.rate_rad_s
    assert any("fix the camera and film again: it rolls" in text for text in rate.warnings)


def test_a_camera_on_a_stand_is_left_alone(still: Path, tmp_path: Path) -> None:
    path = again(still, tmp_path / "stand.mp4", change=lambda i, image: with_things_around(image))
    assert track_phase(path).notes == ()


def test_a_hand_beside_the_plate_is_no_camera_that_moves(render: Render) -> None:
    """It is in most of the frames that are learned from, and moves in one place only."""
    motion = PlateMotion(-45.0 * 2 * np.pi / 60)
    path, _ = render(motion, small_scene(hand_until_s=2.0), seconds=4, fps=120)
    assert not any("the camera moved" in text for text in track_phase(path).notes)


def frames(images: list[NDArray[np.uint8]]) -> list[Frame]:
    return [Frame(i / 15, image, NO_CHROMA) for i, image in enumerate(images)]


def test_frames_are_brought_back_to_a_tenth_of_a_pixel() -> None:
    rng = np.random.default_rng(2)
    rough = cv2.GaussianBlur(rng.standard_normal((360, 480)), (0, 0), 3)
    table = np.clip(128 + 60 * rough / rough.std(), 0, 255).astype(np.uint8)
    clip = frames([np.asarray(moved(table, *sway(i)), np.uint8) for i in range(40)])
    camera = registration(clip)
    assert camera is not None
    assert camera.moves
    shown = [camera.back(frame).luma[60:-60, 60:-60].astype(float) for frame in clip]
    slope = np.abs(np.gradient(shown[20])[1]).mean()
    assert max(np.abs(luma - shown[20]).mean() for luma in shown) < 0.1 * slope + 1.5
    rolls = [sway(i)[2] for i in range(40)]
    largest = max(abs(roll - rolls[20]) for roll in rolls)
    assert camera.largest_roll_rad == pytest.approx(largest, abs=5e-4)


def test_what_stands_on_one_side_only_is_no_surroundings() -> None:
    """A tonearm rides on a warped record."""
    rng = np.random.default_rng(2)
    images = []
    arm = np.kron(rng.integers(0, 255, (14, 12)), np.ones((8, 8))).astype(np.uint8)
    for i in range(40):
        image = np.full((360, 480), 40, np.uint8)
        y = 40 + round(4 * np.sin(0.4 * i))
        image[y : y + 112, 340:436] = arm
        images.append(image)
    assert registration(frames(images)) is None


def test_bands_of_a_flickering_lamp_are_no_motion_of_the_camera() -> None:
    """They shift corners without contrast; brought back, the frames are no more alike."""
    rng = np.random.default_rng(2)
    scene = cv2.GaussianBlur(rng.uniform(60, 180, (360, 480)), (0, 0), 5)
    scene = 110 + 20 * (scene - scene.mean()) / scene.std()
    row = np.arange(360)[:, None]
    frames = [
        Frame(i / 25, np.clip(
            scene * (1 + 0.2 * np.sin(row / 40 + 2.3 * i)) + rng.normal(0, 1.5, scene.shape),
            0, 255).astype(np.uint8), NO_CHROMA)
        for i in range(30)]
    camera = registration(frames)
    assert camera is not None
    assert not camera.moves
    swayed = [Frame(frame.time_s, moved(scene, *sway(8 * i)).astype(np.uint8), NO_CHROMA)
              for i, frame in enumerate(frames)]
    camera = registration(swayed)
    assert camera is not None
    assert camera.moves
