"""The rendered world keeps its own promises, so that it can be the truth for others."""

import numpy as np
import pytest

from tests.vision.rendered_clips import Render
from tests.world.picture import Picture
from tests.world.plate import PlateMotion
from tests.world.scene import Mark, Scene, homography


@pytest.mark.parametrize("tilt", [0.0, 0.6])
def test_a_rendered_mark_is_where_the_geometry_puts_it(tilt: float) -> None:
    """Angle of the mark's centroid on the plate against the angle asked for: 1e-4 rad."""
    scene = Scene(
        marks=(Mark(radius=0.6, length=0.16, width=0.16),),
        label=False,
        sensor_box=False,
        glare=0.0,
        shading=0.0,
        tilt_rad=tilt,
        deck_mark_azimuth_rad=None,
    )
    picture, rows = Picture(scene), np.ones(scene.height_px)
    back = np.linalg.inv(homography(scene))
    y, x = np.mgrid[: scene.height_px, : scene.width_px]
    u, v, n = (row[0] * x + row[1] * y + row[2] for row in back)
    u, v, area = u / n, v / n, 1 / np.abs(n) ** 3  # pixels to area of the plate
    errors = []
    for angle in np.linspace(0, 2 * np.pi, 25):
        near = np.hypot(u - 0.6 * np.cos(angle), v - 0.6 * np.sin(angle)) < 0.2
        light = np.where(near, picture.luma(angle * rows, 0.0) - 60, 0).clip(0) * area
        seen = np.arctan2((light * v).sum(), (light * u).sum())
        errors.append(np.angle(np.exp(1j * (seen - angle))))
    assert np.abs(errors).max() < 5e-4
    assert abs(np.mean(errors)) < 1e-4


def test_angle_is_the_integral_of_rate() -> None:
    motion = PlateMotion(
        -3.5, wow=((1, 2e-3, 0.3), (7.3, 1e-3, 1.0)), drift_rad_s2=1e-3, run_up_s=2.0
    )
    time = np.linspace(0, 20, 200_001)
    rate = motion.rate(time)
    integral = np.concatenate([[0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])
    assert motion.angle(time) == pytest.approx(integral, abs=1e-6)


def test_stamps_in_the_file_are_the_true_times(render: Render) -> None:
    cv2 = pytest.importorskip("cv2")
    from tests.world.film import Recorder

    path, truth = render(PlateMotion(3.5), seconds=3, recorder=Recorder(dropped=0.1, jitter_s=2e-3))
    capture, stamps = cv2.VideoCapture(str(path)), []
    while capture.read()[0]:
        stamps.append(capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3)
    assert np.array(stamps) == pytest.approx(truth.stamp_s, abs=2e-5)
