"""Whether anything moves at all: noise does not, what an encoder renews once does not."""

import numpy as np
import pytest

from vision.numbers import quantile
from vision.plate.background import OFTEN, change_over_noise, median_image, spread_choice
from vision.video.reader import Luma

FRAMES, SHAPE = 60, (180, 240)


def frames(rng: np.random.Generator, noise: float) -> list[Luma]:
    """A still scene of some contrast, in limited-range luma."""
    scene = 60 + 40 * np.sin(np.arange(SHAPE[1]) / 15) + np.arange(SHAPE[0])[:, None] / 4
    return [np.clip(np.rint(scene + noise * rng.standard_normal(SHAPE)), 16, 235).astype(np.uint8)
            for _ in range(FRAMES)]


def stands_still(images: list[Luma]) -> bool:
    return bool(quantile(change_over_noise(images), OFTEN) < 1)


@pytest.mark.parametrize("noise", [0.0, 1.0, 6.0])
def test_a_still_scene_stands_still_through_the_noise_of_the_camera(noise: float) -> None:
    assert stands_still(frames(np.random.default_rng(1), noise))


def test_blocks_that_an_encoder_renews_once_do_not_move() -> None:
    rng = np.random.default_rng(2)
    images = frames(rng, 0.3)
    renewed = rng.integers(-5, 6, (12, 15)).repeat(15, axis=0).repeat(16, axis=1)
    for image in images[40:]:
        image += renewed.astype(np.uint8)
    assert stands_still(images)


def test_noise_that_is_larger_in_bright_places_does_not_move() -> None:
    rng = np.random.default_rng(4)
    larger = np.linspace(1.0, 1.6, SHAPE[1])
    assert stands_still([np.rint(90 + larger * rng.standard_normal(SHAPE)).astype(np.uint8)
                         for _ in range(FRAMES)])


@pytest.mark.parametrize(("contrast", "moves"), [(0, False), (6, True)])
def test_blocks_that_an_encoder_renews_again_and_again_do_not_move(
    contrast: int, moves: bool
) -> None:
    """Steps of two, and no noise elsewhere; a mark of six on them is seen."""
    rng = np.random.default_rng(5)
    images = []
    for i in range(FRAMES):
        renewed = rng.choice([-1, 0, 0, 0, 0, 0, 0, 1], (12, 15))
        image = 90 + renewed.repeat(15, axis=0).repeat(16, axis=1)
        x, y = (round(c) for c in (120 + 70 * np.cos(0.35 * i), 90 + 70 * np.sin(0.35 * i)))
        image[y - 4 : y + 4, x - 4 : x + 4] += contrast
        images.append(image.astype(np.uint8))
    assert stands_still(images) != moves


@pytest.mark.parametrize(("contrast", "noise"), [(12, 2.0), (-12, 2.0), (12, 5.6)])
def test_a_faint_mark_that_goes_round_moves(contrast: int, noise: float) -> None:
    """Eight pixels of tape, for a twentieth of the turn over each place."""
    images = frames(np.random.default_rng(3), noise)
    for i, image in enumerate(images):
        x, y = (round(c) for c in (120 + 70 * np.cos(0.35 * i), 90 + 70 * np.sin(0.35 * i)))
        image[y - 4 : y + 4, x - 4 : x + 4] += np.uint8(contrast % 256)
    assert not stands_still(images)


@pytest.mark.parametrize("count", [1, 2, 3, 8, 31, 300])
def test_the_median_of_the_frames_is_that_of_each_pixel(count: int) -> None:
    rng = np.random.default_rng(1000)
    images = [rng.integers(0, 256, (7, 9), dtype=np.uint8) for _ in range(count)]
    chosen = spread_choice(count, 31)
    odd = chosen[: len(chosen) - (len(chosen) + 1) % 2]
    assert np.array_equal(median_image(images), np.median([images[i] for i in odd], axis=0))
