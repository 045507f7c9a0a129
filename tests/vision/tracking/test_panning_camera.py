"""What changes where nothing turns: a camera, what passes before it, a light; on arrays."""

import re
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from vision.errors import NoPlate, OnlyShifts, RateRefused
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


def number(refusal: RateRefused) -> float:
    """The first number of a sentence."""
    return float(re.findall(r"[0-9.]+", str(refusal))[0])


def test_a_camera_that_is_panned_is_said_to_move_with_its_speed() -> None:
    wide, px_s = scene(1300), 120.0
    images = [wide[:, x : x + 320] for x in (px_s * np.arange(FRAMES) / FPS).astype(int)]
    with pytest.raises(OnlyShifts, match="its view: all that it sees shifts") as refused:
        picture_return(small_clip(images))
    assert number(refused.value) == pytest.approx(2 * px_s, rel=0.2)


def test_things_that_pass_before_a_camera_on_a_stand_do_not_move_it() -> None:
    still, rng = scene(320), np.random.default_rng(13)
    way = np.cumsum(rng.normal(0, 9, (FRAMES, 2)), axis=0) % (320, 180)
    images = [still.copy() for _ in range(FRAMES)]
    for image, (x, y) in zip(images, way.astype(int), strict=True):
        cv2.circle(image, (int(x), int(y)), 30, (240,), -1)
    with pytest.raises(NoPlate, match=r"what changes, .* repeats nothing") as refused:
        picture_return(small_clip(images))
    assert not isinstance(refused.value, OnlyShifts)


@pytest.mark.parametrize(("roll", "zoom", "says"), [
    (0.3, 0.0, "turns by"), (0.0, 0.08, "grows or shrinks by")])
def test_a_camera_that_rolls_or_zooms_is_said_to_do_so(
    roll: float, zoom: float, says: str
) -> None:
    wide = scene(640)
    images = []
    for t in np.arange(FRAMES) / FPS:
        turned = cv2.getRotationMatrix2D((320, 90), np.degrees(roll * t), np.exp(zoom * t))
        turned[0, 2] -= 160
        images.append(cv2.warpAffine(wide, turned, (320, 180), borderMode=cv2.BORDER_REFLECT))
    with pytest.raises(OnlyShifts, match=f"its view: all that it sees {says}") as refused:
        picture_return(small_clip(images))
    expected = np.degrees(roll) if roll else 100 * zoom
    assert number(refused.value) == pytest.approx(expected, rel=0.2)


def test_a_disc_that_goes_through_the_view_passes_by_and_a_mark_on_a_plate_does_not() -> None:
    still, px_s = (100 + scene(320) * 0.1).astype(np.uint8), 45.0  # few places show that they stand
    for around, says in ((0.0, "passes by"), (0.1, "repeats nothing"), (0.4, "repeats nothing")):
        images = []
        for t in np.arange(FRAMES) / FPS:
            image, angle = still.copy(), around * t  # an eighth of a turn, half a turn
            at = (160 + 70 * np.cos(angle), 90 + 70 * np.sin(angle)) if around else (px_s * t, 80)
            cv2.circle(image, (int(at[0]), int(at[1])), 18, (240,), -1)
            images.append(image)
        with pytest.raises(NoPlate, match=says) as refused:
            picture_return(small_clip(images))
        assert around or number(refused.value) == pytest.approx(2 * px_s, rel=0.2)


def test_a_light_that_changes_and_a_hand_that_ticks_are_told() -> None:
    still = scene(320)
    lamp = [np.clip(still * (0.8 + 0.1 * np.sin(0.2 * i) + 0.05 * np.sin(0.37 * i)), 0, 255)
            for i in range(FRAMES)]
    ticks = []
    for i in range(FRAMES):
        image, angle = still.copy(), 0.1 * (i // 25)
        end = (int(160 + 70 * np.sin(angle)), int(90 - 70 * np.cos(angle)))
        cv2.line(image, (160, 90), end, (250,), 4)
        ticks.append(image)
    with pytest.raises(NoPlate, match=r"the light changes, .* nothing beside it repeats"):
        picture_return(small_clip(lamp))
    with pytest.raises(NoPlate, match=r"in steps .* in \d of 199 frames"):
        picture_return(small_clip(ticks))


def test_a_hand_that_reaches_into_the_view_twice_moves_in_no_steps() -> None:
    """Half of all change was in few frames, as of a clock."""
    images = [scene(320) for _ in range(FRAMES)]
    for first, frames in ((20, 22), (131, 26)):
        for i in range(frames):
            reach = int(320 - 200 * np.sin(np.pi * i / frames))
            cv2.rectangle(images[first + i], (reach, 70), (320, 110), (240,), -1)
    with pytest.raises(NoPlate, match=r"what changes, .* repeats nothing"):
        picture_return(small_clip(images))


def test_what_crosses_evenly_is_not_said_to_move_in_steps_by_an_encoder_s_key_frames() -> None:
    """Nearly all change was taken for noise, and the little that key frames add for steps."""
    random, images = np.random.default_rng(0), []
    for i in range(60):
        image = np.full((240, 320), 120, np.uint8)
        cv2.rectangle(image, (5 * i, 100), (5 * i + 40, 160), (230,), -1)
        drawn_anew = random.normal(0, 6, image.shape) * (i in (12, 48))
        images.append(np.clip(image + drawn_anew, 0, 255).astype(np.uint8))
    with pytest.raises(OnlyShifts, match="passes by in one direction"):
        picture_return(small_clip(images))


def test_boxes_on_a_plain_belt_are_not_taken_for_the_surroundings_of_a_plate() -> None:
    images = []
    for i in range(FRAMES):
        image = np.full((180, 320), 110, np.uint8)
        for x in np.arange(-630, 960, 70) + 1.6 * i % 70:
            cv2.rectangle(image, (int(x), 60), (int(x) + 35, 120), (190,), -1)
            cv2.rectangle(image, (int(x) + 6, 70), (int(x) + 20, 95), (40,), -1)
        images.append(image)
    with pytest.raises(OnlyShifts, match="passes by in one direction"):
        picture_return(small_clip(images))


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
