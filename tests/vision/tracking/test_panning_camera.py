"""A camera that is panned over a scene in which nothing turns, on arrays."""

from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from vision.errors import NoPlate, OnlyShifts
from vision.tracking.periodic_track import picture_return
from vision.tracking.small_clip import SmallClip
from vision.video.reader import NO_CHROMA, Frame

FPS = 25.0
FRAMES = 200


def scene(width: int) -> NDArray[np.uint8]:
    """Cards of all tones, (180, width)."""
    rng = np.random.default_rng(11)
    image = np.full((180, width), 110, np.uint8)
    for _ in range(width // 6):
        x, y = int(rng.integers(0, width)), int(rng.integers(0, 180))
        tone = int(rng.integers(20, 230))
        cv2.rectangle(image, (x, y), (x + int(rng.integers(8, 40)), y + int(rng.integers(8, 40))),
                      (tone,), -1)
    return image


def small_clip(images: list[NDArray[np.uint8]]) -> SmallClip:
    rng = np.random.default_rng(12)
    noisy = [np.clip(image + rng.normal(0, 2, image.shape), 0, 255) for image in images]
    frames = [Frame(i / FPS, image.astype(np.uint8), NO_CHROMA) for i, image in enumerate(noisy)]
    small = SmallClip(cast(Any, SimpleNamespace(frames_stated=FRAMES, reduction=2)))
    for _ in small.followed([frames]):
        pass
    return small


def test_a_camera_that_is_panned_is_said_to_move_with_its_speed() -> None:
    wide, px_s = scene(1300), 120.0
    images = [wide[:, x : x + 320] for x in (px_s * np.arange(FRAMES) / FPS).astype(int)]
    small = small_clip(images)
    with pytest.raises(OnlyShifts, match="the camera moves: all that it sees shifts by 2"):
        picture_return(small)
    assert small.pans_px_s == pytest.approx(2 * px_s, rel=0.05)


def test_things_that_pass_before_a_camera_on_a_stand_do_not_move_it() -> None:
    still, rng = scene(320), np.random.default_rng(13)
    way = np.cumsum(rng.normal(0, 9, (FRAMES, 2)), axis=0) % (320, 180)
    images = [still.copy() for _ in range(FRAMES)]
    for image, (x, y) in zip(images, way.astype(int), strict=True):
        cv2.circle(image, (int(x), int(y)), 30, (240,), -1)
    small = small_clip(images)
    with pytest.raises(NoPlate) as refused:
        picture_return(small)
    assert not isinstance(refused.value, OnlyShifts)
    assert small.pans_px_s == 0


def test_what_passes_by_has_no_time_after_which_the_picture_returns() -> None:
    """Boxes on a belt, by chance alike for a while: what comes next need not be as far apart."""
    still, images = scene(320), []
    for i in range(FRAMES):
        image = still.copy()
        image[60:120] = 40
        for x in np.arange(-640, 960, 100) + 2.9 * i % 100:
            cv2.rectangle(image, (int(x), 75), (int(x) + 30, 105), (220,), -1)
        images.append(image)
    with pytest.raises(OnlyShifts, match="it passes by in one direction") as refused:
        picture_return(small_clip(images))
    assert refused.value.returns is None
