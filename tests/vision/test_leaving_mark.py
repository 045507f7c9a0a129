"""Rendered clips of a plate that is partly outside the frame, its mark for a part of each turn."""

import numpy as np
import pytest

from vision.rate.measure import measure_rate
from vision.tracking.track import track_phase

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.phase_tracks import CLOCK
from tests.vision.rendered_clips import Render, error_ppm
from tests.world.film import Recorder, Scene
from tests.world.plate import PlateMotion
from tests.world.scene import Mark

RPM = 2 * np.pi / 60
STRONG = Recorder(crf=30)


def test_a_plate_half_outside_the_frame_is_followed_by_its_label_and_mark(render: Render) -> None:
    """Where most frames show no mark, those that do were set aside as outliers."""
    motion = PlateMotion(33.21 * RPM)
    path, _ = render(motion, Scene(centre_px=(5.0, 181.0), sensor_box=False), seconds=9,
                     recorder=STRONG, preset="veryfast")
    track = track_phase(path)
    assert np.nanmedian(track.quality) > 0.98
    rate = measure_rate(track, timebase=CLOCK)
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    assert abs(error_ppm(rate, motion)) < min(100, 3 * sd_ppm)


def test_what_turns_in_step_with_the_frames_bends_no_line_where_the_mark_leaves(
    render: Render,
) -> None:
    """27 frames per turn: the 27th wave was taken for background, which made 30 ppm in 8 s."""
    motion = PlateMotion(33.21 * RPM, angle_rad=4.4)
    path, _ = render(motion, Scene(centre_px=(30.0, 181.0), sensor_box=False), seconds=8,
                     recorder=Recorder(crf=1), preset="veryfast")
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    assert abs(error_ppm(rate, motion)) < 8
    assert 1 < sd_ppm < 8


def test_a_mark_that_leaves_the_frame_for_half_of_each_turn_is_followed(render: Render) -> None:
    scene = Scene(centre_px=(5.0, 181.0), label=False, sensor_box=False)
    motion = PlateMotion(16.7 * RPM)
    path, _ = render(motion, scene, seconds=8, recorder=STRONG)
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    assert abs(error_ppm(rate, motion)) < min(100, 4 * sd_ppm)


def test_frames_that_do_not_show_the_mark_show_no_angle(render: Render) -> None:
    """What little the rest of the plate looks like at any angle is not taken for one."""
    motion = PlateMotion(33.21 * RPM)
    scene = Scene(centre_px=(30.0, 181.0), marks=(Mark(0.8, 0.0, 0.2, 0.2),), label=False,
                  sensor_box=False)
    path, _ = render(motion, scene, seconds=12, recorder=STRONG)
    track = track_phase(path)
    hidden = ~np.isfinite(track.phase_rad)
    assert 0.2 < hidden.mean() < 0.5
    assert not track.duplicate[hidden].any()
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.used > 0.85 * (~hidden).sum()
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    assert abs(error_ppm(rate, motion)) < min(60, 3 * sd_ppm)
