"""Frames reduced by a whole factor, and the thread that decodes them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vision.video.reduction import reduced


@pytest.mark.parametrize("factor", [1, 2, 3, 4, 6, 8])
def test_a_reduced_frame_has_the_means_of_its_blocks(factor: int) -> None:
    image = np.random.default_rng(1000).integers(0, 256, (101, 130), dtype=np.uint8)
    h, w = 101 // factor, 130 // factor
    blocks = image[: h * factor, : w * factor].reshape(h, factor, w, factor).mean(axis=(1, 3))
    # Each halving rounds once.
    assert reduced(image, factor) == pytest.approx(blocks, abs=0.51 * max(1, factor.bit_length()))
    assert reduced(image, factor).shape == (h, w)


def test_a_reader_outside_of_a_with_ends_with_the_interpreter() -> None:
    """It waited for a thread that had not been started."""
    typed = ("from vision.video.reader import ClipReader\n"
             "clip = ClipReader('data/example/video/17rpm.mp4')\n"
             "print(len(next(iter(clip))))")
    ended = subprocess.run(
        [sys.executable, "-c", typed], timeout=30, capture_output=True, text=True, check=True,
        cwd=Path(__file__).parents[3])
    assert ended.stdout.split() == ["16"]
