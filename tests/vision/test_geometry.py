"""Views of the plate: plate coordinates to pixels and back, and the rim about another spindle."""

import numpy as np
import pytest

from tests.world.scene import Scene, homography
from vision.geometry import PlateView, view_of_ellipse


def test_a_sheared_view_and_its_inverse_agree() -> None:
    view = PlateView(homography(Scene(tilt_rad=0.5)), lag_rad_px=2e-4)
    radius, azimuth = np.array([0.3, 0.9, 0.9]), np.array([0.5, 2.0, -1.2])
    radius_again, azimuth_again = view.plate(*view.pixels(radius, azimuth))
    assert radius_again == pytest.approx(radius)
    assert azimuth_again == pytest.approx(azimuth, abs=1e-6)


def test_a_view_about_another_spindle_keeps_its_rim() -> None:
    view = view_of_ellipse((231.0, 183.0), (140.0, 110.0), 0.4)
    other = view.about(218.0, 169.0)
    assert other.centre_px == pytest.approx((218.0, 169.0))
    azimuth = np.linspace(0, 2 * np.pi, 50)
    assert view.plate(*other.pixels(np.ones(50), azimuth))[0] == pytest.approx(np.ones(50))
    with pytest.raises(ValueError, match="outside the rim"):
        view.about(20.0, 20.0)
