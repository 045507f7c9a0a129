"""Outlines of possible plates in the picture at rest."""

import cv2
import numpy as np
import pytest

from vision.plate.detect import proposals


@pytest.mark.parametrize("bright", [False, True])
def test_a_small_plate_on_its_deck_has_an_outline_beside_a_table_of_many_shades(
    *, bright: bool
) -> None:
    """Plate and deck are the two darkest hundredths of the picture, or the two brightest."""
    shades = np.random.default_rng(0).normal(140, 12, (24, 32)).clip(110, 170).astype(np.float32)
    table = cv2.resize(shades, (640, 480), interpolation=cv2.INTER_CUBIC)
    cv2.rectangle(table, (365, 165), (435, 235), 85, -1)
    cv2.ellipse(table, (400, 200), (34, 22), 20, 0, 360, 50, -1, cv2.LINE_AA)
    picture = np.asarray(255 - table if bright else table, np.uint8)
    assert any(abs(view.radius_px - 34) < 3
               and np.hypot(view.centre_px[0] - 400, view.centre_px[1] - 200) < 3
               for view in proposals(picture, [picture]))
