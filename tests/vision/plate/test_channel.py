"""Plates whose only mark is one of colour, as bright as the plate."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from vision.errors import RateRefused
from vision.geometry import PlateOverride, PlateView
from vision.phase_track import PhaseTrack
from vision.plate.channel import ChromaAxis, axes_of_colour
from vision.rate.measure import RateMeasurement, measure_rate
from vision.tracking.track import track_phase
from vision.video.reader import NO_CHROMA, ClipReader, Frame

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.edited_clips import Image, again
from tests.vision.phase_tracks import CLOCK, phase_track
from tests.vision.rendered_clips import Render, small_scene
from tests.world.film import Recorder
from tests.world.plate import PlateMotion
from tests.world.scene import Mark, Scene, homography

RPM = 2 * np.pi / 60
MOTION = PlateMotion(-33.3 * RPM)
RED = Mark(luma=Scene().plate_luma, blue=-10.0, red=50.0)
SCENE = small_scene(marks=(RED,), label=False, sensor_box=False, chroma_noise=1.0)


def rate_of(track: PhaseTrack) -> RateMeasurement:
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.direction == "cw"
    error = rate.rate_rad_s / abs(MOTION.rate_rad_s) - 1
    assert abs(error) < 1e-4
    assert abs(error) < 5 * rate.sd_rad_s / rate.rate_rad_s
    return rate


@pytest.fixture(scope="module")
def clip(render: Render) -> Path:
    return render(MOTION, SCENE, seconds=10)[0]


def test_a_red_mark_as_bright_as_the_plate_is_followed_by_its_colour(clip: Path) -> None:
    track = track_phase(clip)
    rate = rate_of(track)
    cr, _, sign, cb, _ = track.plate.channel.split()
    axis = np.array([float(cr), float(sign + cb)])
    assert abs(axis @ (RED.red, RED.blue)) == pytest.approx(np.hypot(RED.red, RED.blue), rel=0.03)
    assert rate.channel == track.plate.channel
    assert rate.warnings == ()


def test_what_is_found_by_colour_stands_in_pixels_of_the_clip(clip: Path) -> None:
    track = track_phase(clip)
    assert track.plate.size_px == (SCENE.width_px, SCENE.height_px)
    # A single mark shows the centre to a pixel or so: perspective looks much the same.
    view, true = PlateView(track.plate.view), PlateView(homography(SCENE))
    centre = [(c + 0.5) * track.plate.reduction - 0.5 for c in view.centre_px]
    assert centre == pytest.approx(true.centre_px, abs=2.0)
    assert track.plate.mark_radius == pytest.approx(RED.radius, abs=0.03)


def test_the_rim_given_by_hand_holds_for_a_clip_followed_by_colour(clip: Path) -> None:
    given = PlateOverride(centre_px=(155.3, 120.7), radius_px=96.3)
    rate_of(track_phase(clip, plate=given))
    with pytest.raises(RateRefused, match="turns about a fixed axis"):
        track_phase(clip, plate=PlateOverride(centre_px=(40.0, 40.0), radius_px=26.7))


@pytest.mark.parametrize(
    ("codec", "pixel_format", "suffix"),
    [
        ("libx264", "yuv420p10le", ".mp4"),
        ("libx264", "yuv444p", ".mp4"),
        ("mjpeg", "yuvj420p", ".avi"),
        ("rawvideo", "yuyv422", ".avi"),
        ("prores_ks", "yuv422p10le", ".mov"),
        ("png", "rgb24", ".mov"),
        ("gif", "rgb8", ".gif"),
    ],
)
def test_colour_is_followed_in_frames_of(
    codec: str, pixel_format: str, suffix: str, render: Render
) -> None:
    recorder = Recorder(codec=codec, pixel_format=pixel_format)
    track = track_phase(render(MOTION, SCENE, seconds=4, suffix=suffix, recorder=recorder)[0])
    assert track.plate.channel != "luma"
    rate_of(track)


@pytest.mark.parametrize("codec", ["libx264", "ffv1"])
def test_a_grey_clip_of_such_a_mark_is_refused(codec: str, render: Render) -> None:
    recorder = Recorder(codec=codec, pixel_format="gray")
    path, _ = render(MOTION, SCENE, seconds=5, suffix=".mkv", recorder=recorder)
    with pytest.raises(RateRefused, match="nothing in the frame turns about a fixed axis"):
        track_phase(path)


def test_a_plate_at_rest_with_a_red_mark_is_refused(render: Render) -> None:
    path, _ = render(PlateMotion(0.0), SCENE, seconds=6)
    with pytest.raises(RateRefused, match="turns about a fixed axis"):
        track_phase(path)


def test_a_mark_that_is_bright_too_is_followed_by_its_brightness(render: Render) -> None:
    path, _ = render(MOTION, small_scene(marks=(Mark(blue=-10.0, red=50.0),)), seconds=5)
    track = track_phase(path)
    assert (track.plate.channel, track.plate.reduction) == ("luma", 1)
    rate_of(track)


def test_a_clip_gives_chroma_only_when_asked(clip: Path) -> None:
    with ClipReader(clip) as reader:
        plain = next(iter(reader))[0]
    with ClipReader(clip, colours=True) as reader:
        coloured = next(iter(reader))[0]
    assert plain.chroma is NO_CHROMA
    assert plain.luma.shape == (240, 320)
    assert coloured.luma.shape == (120, 160)
    assert coloured.chroma.shape == (120, 160, 2)


def frame(luma: Image, cr: Image, cb: Image) -> Frame:
    return Frame(0.0, luma, np.dstack([cr, cb]))


def test_the_axes_of_colour_are_those_along_which_it_changes() -> None:
    rng = np.random.default_rng(0)
    frames = []
    for i in range(40):
        luma = rng.integers(0, 255, (30, 40), np.uint8)
        cr, cb = (128 + rng.normal(0, 2, (2, 30, 40))).astype(int)
        x = i % 30
        cr[5:12, x : x + 8] += 30
        cb[5:12, x : x + 8] -= 40
        frames.append(frame(luma, cr.astype(np.uint8), cb.astype(np.uint8)))
    first = axes_of_colour(frames)[0]
    assert isinstance(first, ChromaAxis)
    assert (first.cr, first.cb) == pytest.approx((-0.6, 0.8), abs=0.02)
    image = first(frames[7]).astype(float)
    assert image.shape == (30, 40)
    assert image[5:12, 7:15].mean() == pytest.approx(128 - 50, abs=1)
    assert image[20:].mean() == pytest.approx(128, abs=1)
    assert str(ChromaAxis(0.6, -0.8)) == "0.60 Cr - 0.80 Cb"


def test_what_has_no_colour_has_no_axis() -> None:
    grey = np.full((30, 40), 128, np.uint8)
    assert axes_of_colour([frame(grey, grey, grey)] * 20) == []


def test_less_than_a_turn_in_the_brightness_does_not_hide_a_mark_of_colour(
    clip: Path, render: Render, tmp_path: Path
) -> None:
    """No rate could be had from it."""
    grey = small_scene(label=False, sensor_box=False)
    slow, _ = render(PlateMotion(3.0 * RPM), grey, seconds=10)
    assert track_phase(slow).apparent_turns == pytest.approx(0.5, abs=0.01)
    capture = cv2.VideoCapture(str(slow))

    def beside(i: int, image: Image) -> Image:
        return np.hstack([capture.read()[1], image])

    track = track_phase(again(clip, tmp_path / "beside.mp4", change=beside))
    assert track.plate.channel != "luma"
    rate_of(track)


def test_turns_are_counted_where_the_plate_was_seen() -> None:
    time = np.arange(100) / 15
    track = phase_track(time, -0.5 * time)
    gaps = np.where(np.arange(100) % 7 == 3, np.nan, track.phase_rad)
    for phase in (track.phase_rad, gaps):
        turns = replace(track, phase_rad=phase).apparent_turns
        assert turns == pytest.approx(0.5 * time[-1] / (2 * np.pi))


def test_turns_are_counted_over_gaps_of_almost_half_a_turn() -> None:
    """The shortest way from 13 frames before to the next would be back: a quarter of a turn."""
    time = np.arange(120) / 15
    track = phase_track(time, 3.48 * time)
    shown = np.mod(3.48 * time, 2 * np.pi) < 3.2
    turns = replace(track, phase_rad=np.where(shown, track.phase_rad, np.nan)).apparent_turns
    assert turns == pytest.approx(3.48 * time[-1] / (2 * np.pi))
