"""The symmetry of a plate by its template."""

import numpy as np
import pytest

from vision.geometry import view_of_ellipse
from vision.plate.mark import symmetry
from vision.plate.polar import polar_grid
from vision.plate.template import Alignment, Template

SHAPE = (100, 100)
VIEW = view_of_ellipse((50, 50), (48, 48), 0.0)
COARSE_RADII = np.linspace(0.1, 0.97, 20)


def learned(radius: np.ndarray, label: float, noise: float, used: float = 1.0) -> Alignment:
    """Two equal marks near the rim and a label, amid noise (power), in 60 frames."""
    azimuth = np.arange(256) * 2 * np.pi / 256
    marks = np.exp(6 * np.cos(2 * azimuth)) / np.exp(6) * (radius[:, None] > 0.7)
    turning = marks + label * np.cos(azimuth) * (radius[:, None] < 0.4)
    turning = (turning - turning.mean(axis=1, keepdims=True)).astype(np.float32)
    grid = polar_grid(VIEW, radius, 256, SHAPE)
    signal = float((turning**2).sum(axis=1) @ grid.weight()) * VIEW.radius_px**2 / 256
    template = Template(grid, np.zeros_like(turning), turning, 1 / (1 + noise),
                        (1 + noise) * signal)
    frames = np.arange(60)
    return Alignment(template, 0.1 * frames, frames < used * 60, np.ones(60, bool))


@pytest.mark.parametrize(("label", "noise", "used", "times"), [
    (0.3, 0.02, 1.0, 1),   # the label goes round with the marks
    (0.3, 0.5, 1.0, 2),    # most of what the marks lack does not turn: blades under a lamp
    (0.3, 0.02, 0.4, 2),   # it goes round in some of the frames only: blades that are strobed
    (0.0, 0.02, 1.0, 2),
])
def test_a_label_tells_two_equal_marks_apart_if_it_turns_with_them(
    label: float, noise: float, used: float, times: int
) -> None:
    coarse = learned(COARSE_RADII, label, noise, used)
    assert symmetry(learned(np.linspace(0.75, 0.9, 8), 0.0, noise).template, coarse) == times
