"""Rendered clips: plate found, angle followed, rate right, or an honest refusal."""

import re
from pathlib import Path

import numpy as np
import pytest

from vision.camera import ClipWriter
from vision.errors import RateRefused
from vision.rate.measure import measure_rate
from vision.tracking.track import track_phase

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.phase_tracks import CLOCK
from tests.vision.rendered_clips import Render, error_ppm, small_scene
from tests.world.film import Recorder, Scene
from tests.world.plate import PlateMotion
from tests.world.scene import Mark, homography
from vision.geometry import PlateView

RPM = 2 * np.pi / 60
STRONG = Recorder(crf=30)


SCENES = {
    "tilt of 40 degrees in true perspective": (
        -33.3,
        Scene(tilt_rad=np.radians(40), camera_distance=4.5, radius_px=135),
    ),
    "texture and no mark": (33.3, Scene(marks=(), label=False, sensor_box=False, texture=6.0)),
    "label and sensor box and no mark": (-16.667, Scene(marks=(), glare=90)),
    "tonearm over the plate": (45.0, Scene(tonearm=True)),
    "hand for the first seconds": (33.3, Scene(hand_until_s=4.0)),
    "dim and noisy": (16.667, Scene(light=0.3, noise=5.0)),
    "rolling shutter and blur": (45.0, Scene(line_time_s=60e-6, exposure_s=1 / 25)),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_rate_is_right_within_its_sd_in_a_scene_with(name: str, render: Render) -> None:
    rpm, scene = SCENES[name]
    motion = PlateMotion(rpm * RPM, wow=((1, 5e-4, 1.0),))
    path, _ = render(motion, scene, seconds=8, recorder=STRONG, preset="veryfast")
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    assert abs(error_ppm(rate, motion)) < 30
    assert abs(error_ppm(rate, motion)) < 5 * rate.sd_rad_s / rate.rate_rad_s * 1e6


def test_a_small_plate_as_dark_as_its_table_is_found_by_what_changes(render: Render) -> None:
    """No step of brightness shows its rim; "nothing turns" was the answer."""
    motion = PlateMotion(33.3 * RPM)
    scene = Scene(width_px=640, height_px=480, centre_px=(410.0, 190.0), radius_px=30.0,
                  plate_luma=100.0, deck_luma=100.0, label=False, sensor_box=False, glare=0.0,
                  marks=(Mark(length=0.25, width=0.22),), deck_mark_azimuth_rad=None,
                  exposure_s=1 / 200)
    path, _ = render(motion, scene, seconds=8)
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    assert abs(error_ppm(rate, motion)) < 3 * rate.sd_rad_s / rate.rate_rad_s * 1e6 < 300


def test_the_motion_shows_where_the_axis_is(render: Render) -> None:
    scene = Scene(tilt_rad=np.radians(35), camera_distance=4.5, tilt_azimuth_rad=-2.0)
    path, _ = render(PlateMotion(16.7 * RPM), scene, seconds=9)
    track = track_phase(path)
    view, true = PlateView(track.plate.view), PlateView(homography(scene))
    assert view.centre_px == pytest.approx(true.centre_px, abs=0.1)
    assert view.tilt_rad == pytest.approx(true.tilt_rad, abs=np.radians(0.3))


def test_a_plate_that_keeps_step_with_the_frames_is_not_pushed_off_its_rate(
    render: Render
) -> None:
    """At 27.03 frames per turn its own texture was taken for what stands still: 4 ppm."""
    scene = Scene(marks=(), label=False, sensor_box=False, texture=6.0, noise=0.3)
    motion = PlateMotion(33.3 * RPM)
    path, _ = render(motion, scene, seconds=8, recorder=Recorder(crf=0))
    assert abs(error_ppm(measure_rate(track_phase(path), timebase=CLOCK), motion)) < 1


def test_the_rim_is_found_where_only_the_label_turns_about_the_middle_of_its_ellipse(
    render: Render
) -> None:
    """Seen steeply from nearby; the measure ended at the label, with 2.3 times the noise."""
    scene = Scene(marks=(), tilt_rad=0.6, camera_distance=4.2, texture=2.5)
    path, _ = render(PlateMotion(16.7 * RPM), scene, seconds=9)
    view, true = PlateView(track_phase(path).plate.view), PlateView(homography(scene))
    assert view.radius_px == pytest.approx(true.radius_px, rel=0.02)
    assert view.centre_px == pytest.approx(true.centre_px, abs=0.5)


def test_frame_faults_of_a_recorder_are_found_counted_and_repaired(render: Render) -> None:
    motion = PlateMotion(33.3 * RPM)
    path, truth = render(motion, small_scene(), seconds=12,
                         recorder=Recorder(lost=0.02, duplicated=0.03))
    rate = measure_rate(track_phase(path), timebase=CLOCK)
    assert rate.frames.dropped == truth.lost_before.sum() > 0
    assert rate.frames.repeated == truth.duplicate.sum() > 0
    assert abs(error_ppm(rate, motion)) < 20


def test_dropped_frames_with_true_stamps_and_jitter_cost_nothing(render: Render) -> None:
    motion = PlateMotion(-33.3 * RPM)
    recorder = Recorder(dropped=0.06, jitter_s=4e-3)
    path, truth = render(motion, small_scene(), seconds=9, recorder=recorder, suffix=".mkv")
    track = track_phase(path)
    assert np.abs(track.time_s - truth.stamp_s).max() < 0.6e-3  # mkv stores milliseconds
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert abs(error_ppm(rate, motion)) < 30


def test_a_recorder_that_stalls_does_not_lay_two_plates_over_each_other(render: Render) -> None:
    """The rough angle knows nothing of the turn that is missing; a plate of two marks came out."""
    motion = PlateMotion(33.3 * RPM)
    path, truth = render(motion, small_scene(), seconds=14,
                         recorder=Recorder(stalled_s=(8.0, 9.3)))
    track = track_phase(path)
    away = np.angle(np.exp(1j * (track.phase_rad - truth.angle_rad)))
    assert np.ptp(away) < 0.01
    rate = measure_rate(track, timebase=CLOCK)
    assert re.search(r"steps by .* at 8\.0 s, or that and whole turns", rate.warnings[0])
    assert abs(error_ppm(rate, motion)) < 30


def test_a_clip_of_uneven_frame_rate_is_not_taken_for_a_damaged_one(render: Render) -> None:
    """Matroska states no count; length times frame rate is far from it."""
    path, _ = render(PlateMotion(33.3 * RPM), small_scene(), seconds=8, suffix=".mkv",
                     recorder=Recorder(dropped=0.4))
    assert track_phase(path).notes == ()


@pytest.mark.parametrize("camera_fps", [24.0, 15.0])
def test_frames_shown_twice_do_not_hide_the_plate(camera_fps: float, render: Render) -> None:
    """As of a webcam in the dark, in a clip of 30 frames per second."""
    motion, camera = PlateMotion(33.3 * RPM), Recorder(camera_fps=camera_fps)
    path, truth = render(motion, small_scene(), fps=30, seconds=7, recorder=camera)
    track = track_phase(path)
    assert track.notes == ()
    assert (track.duplicate == truth.duplicate).mean() > 0.98
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(error_ppm(rate, motion)) < min(300, 3 * rate.sd_rad_s / rate.rate_rad_s * 1e6)


def test_stamps_that_come_late_do_not_lead_the_follower_astray(render: Render) -> None:
    """Newton's method ended beside the mark, and three frames in ten were left out."""
    motion = PlateMotion(33.3 * RPM)
    path, _ = render(motion, small_scene(label=False, sensor_box=False), seconds=8, suffix=".mkv",
                     recorder=Recorder(late_s=8e-3))
    track = track_phase(path)
    assert np.median(track.quality) - track.quality.min() < 0.05
    assert measure_rate(track, timebase=CLOCK).frames.used == len(track.time_s)


def test_two_equal_marks_opposite_each_other_do_not_halve_the_turn(render: Render) -> None:
    marks = (Mark(), Mark(azimuth_rad=np.pi))
    motion = PlateMotion(33.3 * RPM)
    path, _ = render(motion, small_scene(marks=marks, label=False, sensor_box=False), seconds=6)
    track = track_phase(path)
    assert track.plate.symmetry == 2
    assert abs(error_ppm(measure_rate(track, timebase=CLOCK, nominal_rpm=33), motion)) < 30


def test_a_small_print_tells_equal_sectors_apart_whose_view_is_refined(render: Render) -> None:
    """A mat from the side: until the view is right, a neighbouring sector fits as well as its own.

    The plate cannot change from one to the other between two frames.
    """
    sectors = tuple(Mark(0.6, a, 0.55, 0.5, 110.0) for a in np.arange(4) * np.pi / 2)
    scene = small_scene(marks=(*sectors, Mark(0.82, 0.3, 0.05, 0.05)), label=False,
                        sensor_box=False, radius_px=110.0, tilt_rad=0.9, camera_distance=4.0)
    motion = PlateMotion(16.75 * RPM)
    path, _ = render(motion, scene, seconds=8)
    track = track_phase(path)
    assert track.plate.symmetry == 1
    assert abs(error_ppm(measure_rate(track, timebase=CLOCK), motion)) < 30


def test_strobe_dots_alone_give_the_set_of_rates_and_the_nominal_one_chooses(
    render: Render,
) -> None:
    """The frames show how far the dots move, but not which of them is which."""
    dots = tuple(Mark(0.9, a, 0.06, 0.05) for a in np.linspace(0, 2 * np.pi, 24, endpoint=False))
    motion = PlateMotion(33.3 * RPM)
    path, _ = render(motion, Scene(marks=dots, label=False, sensor_box=False), seconds=10)
    track = track_phase(path)
    assert track.plate.symmetry == 24
    told = measure_rate(track, timebase=CLOCK, nominal_rpm=33.3)
    assert abs(error_ppm(told, motion)) < 30
    # A dot more or less from frame to frame, at 15 frames per second.
    spacing = np.diff(sorted(told.aliases.rates_rad_s)) / RPM
    assert spacing == pytest.approx(60 * 15 / 24, abs=0.01)
    with pytest.raises(RateRefused, match=r"may turn at 4\.2\d*, 33\.[23]\d*, .* the same 24"):
        measure_rate(track, timebase=CLOCK)


def test_an_aliased_plate_lists_its_rates_and_takes_the_nominal_one(render: Render) -> None:
    motion = PlateMotion(600 * RPM)
    path, _ = render(motion, small_scene(exposure_s=1 / 500), seconds=6)
    track = track_phase(path)
    assert abs(error_ppm(measure_rate(track, timebase=CLOCK, nominal_rpm=600), motion)) < 20
    with pytest.raises(RateRefused, match=r"may turn at (300|299\.9), 600"):
        measure_rate(track, timebase=CLOCK)


def test_an_ordinary_speed_at_15_frames_per_second_is_no_alias(render: Render) -> None:
    rpm = -78.26
    motion = PlateMotion(rpm * RPM)
    path, _ = render(motion, small_scene(exposure_s=1 / 200), seconds=6)
    track = track_phase(path)
    for nominal_rpm in (None, abs(rpm)):
        rate = measure_rate(track, timebase=CLOCK, nominal_rpm=nominal_rpm)
        assert abs(error_ppm(rate, motion)) < 30
        assert rate.warnings == ()
    # Fifteen turns a second more or less give the same frames.
    listed = np.array(rate.aliases.rates_rad_s) / RPM
    assert sorted(np.abs(listed))[:3] == pytest.approx(
        [abs(rpm), 900 - abs(rpm), 900 + abs(rpm)], abs=0.01
    )


def test_a_coasting_plate_is_refused_with_its_rate_against_time(render: Render) -> None:
    motion = PlateMotion(45 * RPM, coast_from_s=3, coast_s=5)
    path, _ = render(motion, small_scene(), seconds=9)
    with pytest.raises(RateRefused, match="slows down") as refused:
        measure_rate(track_phase(path), timebase=CLOCK)
    history = refused.value.history
    assert history is not None
    inner = slice(1, -1)
    truth = motion.rate(history.time_s[inner])
    assert history.rate_rad_s[inner] == pytest.approx(truth, rel=0.02)


def test_a_plate_at_rest_is_refused(render: Render) -> None:
    path, _ = render(PlateMotion(0.0), small_scene(), seconds=6)
    with pytest.raises(RateRefused):
        measure_rate(track_phase(path), timebase=CLOCK)


def test_the_read_out_time_of_the_camera_is_measured(render: Render) -> None:
    """It was half of the truth, the label and the marks disagreeing, when no view had it."""
    motion = PlateMotion(45 * RPM * 1.004)
    marks = (Mark(radius=0.85), Mark(radius=0.45, azimuth_rad=2.1))
    scene = Scene(marks=marks, tonearm=True, line_time_s=60e-6, exposure_s=1 / 200)
    path, _ = render(motion, scene, seconds=16, preset="veryfast")
    rate = measure_rate(
        track_phase(path), timebase=CLOCK, model=("constant_rate", "rolling_shutter")
    )
    (term,) = rate.fit.terms
    assert term.value[0] == pytest.approx(60e-6, rel=0.02)
    assert rate.fit.rms_rad < 4e-4


def test_a_slow_plate_before_a_fast_camera_is_learned_over_two_seconds_and_more(
    render: Render
) -> None:
    """All frames of its first turn would be too many to keep."""
    motion = PlateMotion(16.67 * RPM)
    path, _ = render(motion, small_scene(), seconds=4.2, fps=120)
    track = track_phase(path)
    assert len(track.time_s) == 4.2 * 120
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s / motion.rate_rad_s - 1) < 1e-4


@pytest.mark.parametrize("second", [(235, 90, 60, 60, 140), (135, 125, 16, 250, 20)],
                         ids=["side by side", "a bold wheel before the rim of a dim plate"])
def test_of_two_things_that_turn_both_rates_are_said_and_the_larger_is_the_plate(
    tmp_path: Path, second: tuple[int, ...]
) -> None:
    """One was measured, and of the other not a word: the bold one, however small."""
    y, x = np.mgrid[:180, :320]
    writer = ClipWriter(tmp_path / "twins.mkv")
    for time_s in np.arange(200) / 25.0:
        image = np.full((180, 320), 150.0)
        for (at_x, at_y, size, luma, mark), rad_s in (((85, 90, 60, 60, 140), 2.1), (second, 3.3)):
            away, radius = x - at_x + 1j * (y - at_y), np.hypot(x - at_x, y - at_y)
            near = np.abs(np.angle(away * np.exp(-1j * rad_s * time_s))) < 9 / size
            image[radius < size] = luma
            image[near & (radius > 0.75 * size) & (radius < size)] = mark
        writer.write(np.repeat(np.rint(image).astype(np.uint8)[:, :, None], 3, axis=2), time_s)
    writer.end(keep=True)
    rate = measure_rate(track_phase(tmp_path / "twins.mkv"), timebase=CLOCK)
    assert second[2] == 60 or abs(rate.rate_rad_s) == pytest.approx(2.1, rel=1e-3)
    said = [re.search(r"two things turn in the frame, at about ([\d.]+) rpm and, beside it, "
                      r"([\d.]+) rpm", text) for text in rate.warnings]
    both = sorted(float(rpm) * RPM for found in said if found for rpm in found.groups())
    assert both == pytest.approx([2.1, 3.3], rel=0.01)
