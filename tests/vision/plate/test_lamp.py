"""A lamp in bands is told from what moves, and is taken out of the frames."""

import numpy as np
import pytest

from vision.plate.lamp import changing_light, in_even_light
from vision.video.reader import Luma

SHAPE = (180, 240)
RNG = np.random.default_rng(0)
TABLE = np.kron(RNG.uniform(40, 150, (12, 16)), np.ones((15, 15)))


def film(along: int, depth: float, mark: float = 0.0) -> list[Luma]:
    """A table under a lamp that flickers along an axis, and a mark that goes round on it."""
    lines = np.arange(SHAPE[1 - along])
    images = []
    for i in range(60):
        light = 1 + depth * np.sin(2 * np.pi * (lines / 70 + 0.137 * i))
        image = TABLE * (light[:, None] if along else light)
        x, y = (round(c) for c in (120 + 60 * np.cos(0.35 * i), 90 + 60 * np.sin(0.35 * i)))
        image[y - 12 : y + 12, x - 12 : x + 12] += mark
        images.append(np.rint(image + RNG.normal(0, 2, SHAPE)).astype(np.uint8))
    return images


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("depth", [0.03, 0.3])
def test_the_lines_of_a_lamp_are_found_and_its_light_is_taken_out(along: int, depth: float) -> None:
    images = film(along, depth)
    assert changing_light(images) == along
    even = np.array(in_even_light(images, along), float)
    assert even.std(axis=0).mean() < 2.3  # the noise


def test_what_moves_is_no_light_and_stays() -> None:
    assert changing_light(film(1, 0.0, 60.0)) is None
    even = np.array(in_even_light(film(1, 0.2, 60.0), 1), float)
    assert np.ptp(even, axis=0).max() > 50


def test_pictures_that_follow_each_other_are_no_light() -> None:
    first, second = (RNG.integers(0, high, SHAPE).astype(np.uint8) for high in (120, 255))
    assert changing_light([first, first, second, second, first, first]) is None
