"""Frames reduced by a whole factor."""

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
