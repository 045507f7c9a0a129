"""``pipeline rate`` where there is no file, or no constant rate."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.errors import DeviceError
from pipeline.stages.live_clip import film_clip
from tests.sessions import pipeline
from tests.vision.rendered_clips import small_scene
from tests.world.film import film
from tests.world.plate import PlateMotion

RATE = 3.4907  # 33 1/3 rpm
SLOWING = -0.06  # rad/s²


@pytest.fixture(scope="module")
def slowing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("slowing") / "slowing.mp4"
    film(path, PlateMotion(RATE, drift_rad_s2=SLOWING), small_scene(), fps=15.0, seconds=20.0)
    return path


def test_a_plate_that_slows_down_gives_rate_against_time_and_no_rate(
    slowing: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("rate", slowing) == 4
    seen = capsys.readouterr()
    assert "does not turn steadily" in seen.err
    head, *rows = seen.out.splitlines()
    assert "not constant" in head
    assert "±" not in seen.out
    time_s, rpm = np.array([row.split() for row in rows], float).T
    expected = (RATE + SLOWING * time_s) * 30 / np.pi
    assert np.abs(rpm) == pytest.approx(expected, rel=2e-3)


def test_its_angles_are_in_the_json(slowing: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert pipeline("rate", slowing, "--json") == 4
    found = json.loads(capsys.readouterr().out)["slowing"]
    assert "does not turn steadily" in found["refused"]
    assert "rate_rad_s" not in found
    assert found["repeats"] is None
    time_s = np.array(found["angles"]["time_s"])
    angle = np.array(found["angles"]["angle_rad"])
    expected = RATE * time_s + SLOWING * time_s**2 / 2
    assert np.abs(angle - angle[0]) == pytest.approx(expected - expected[0], abs=0.003)
    assert found["revolutions"] == pytest.approx(np.ptp(expected) / (2 * np.pi), abs=0.02)


def test_a_clip_without_a_plate_that_repeats_is_refused_with_what_it_repeats_after(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A ball that swings; the object is that of every refusal."""
    clip = tmp_path / "swing.avi"
    writer = cv2.VideoWriter(str(clip), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (320, 240))
    for i in range(250):
        image = np.full((240, 320, 3), 90, np.uint8)
        x = round(160 + 90 * np.sin(2 * np.pi * i / 37.3))
        cv2.circle(image, (x, 120), 18, (230, 230, 230), -1, cv2.LINE_AA)
        writer.write(image)
    writer.release()
    assert pipeline("rate", clip, "--json") == 4
    seen = capsys.readouterr()
    refused = json.loads(seen.out)["swing"]
    assert "the picture repeats every 1.49 s" in refused["refused"]
    assert refused["refused"] in " ".join(seen.err.split())
    assert refused["repeats"]["period_s"] == pytest.approx(37.3 / 25, rel=0.005)
    assert refused["history"] is None


@pytest.fixture(scope="module")
def steady(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("steady") / "steady.mp4"
    film(path, PlateMotion(RATE), fps=15.0, seconds=9.0)
    return path


def test_the_overlay_shows_rim_and_mark_in_every_frame_and_replaces_nothing(
    steady: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    overlay = tmp_path / "seen.mp4"
    assert pipeline("rate", steady, "--overlay", overlay) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(overlay)
    drawn, plain = shown_frames(overlay), shown_frames(steady)
    assert len(drawn) == len(plain) == 135
    green = [(image[..., 1].astype(int) - image[..., 2] > 60).sum() for image in drawn]
    assert min(green) > 500  # the rim; the clip has nothing green
    blue = [np.argwhere((image[..., 0].astype(int) - image[..., 2] > 120)[60:]).mean(axis=0)
            for image in drawn]
    assert np.ptp(blue, axis=0).min() > 80  # the hand goes round
    # The clip is tracked by its luma, and shown in its colours.
    drawn_colour, plain_colour = (np.ptp(each[40][60:].astype(int), axis=2)
                                  for each in (drawn, plain))
    coloured = plain_colour > 60  # the label
    assert coloured.sum() > 500
    assert drawn_colour[coloured].mean() > 0.7 * plain_colour[coloured].mean()
    before = overlay.read_bytes()
    assert pipeline("rate", steady, "--overlay", overlay) == 2
    assert pipeline("rate", steady, "--overlay", steady, "--force") == 2
    assert pipeline("rate", steady, "--overlay", tmp_path / "seen.avi") == 2
    assert overlay.read_bytes() == before
    overlay.write_bytes(b"mine")
    assert pipeline("rate", steady, "--overlay", overlay, "--force") == 0
    assert overlay.read_bytes() == before


def test_the_overlay_marks_what_the_rate_leaves_out(
    steady: Path, slowing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A grey border; of a refused clip all around."""
    part, refused = tmp_path / "part.mp4", tmp_path / "refused.mp4"
    assert pipeline("rate", steady, "--from", "2", "--to", "8", "--overlay", part) == 0
    assert [is_bordered(image) for image in shown_frames(part)] == [
        not 2 <= i / 15 <= 8 for i in range(135)]
    assert pipeline("rate", slowing, "--overlay", refused) == 4
    frames = shown_frames(refused)
    assert len(frames) == 300
    assert all(map(is_bordered, frames))
    green = [(image[..., 1].astype(int) - image[..., 2] > 60).sum() for image in frames]
    assert min(green) > 300  # the rim


def is_bordered(image: NDArray[np.uint8]) -> bool:
    """Whether the left and the right edge are of one grey below the text."""
    edges = np.concatenate([image[80:, 1], image[80:, -2]]).astype(int)
    return bool(edges.std() < 6)


def shown_frames(path: Path) -> list[NDArray[np.uint8]]:
    cv2 = pytest.importorskip("cv2")
    capture, images = cv2.VideoCapture(str(path)), []
    while True:
        ok, image = capture.read()
        if not ok:
            return images
        images.append(image)


def test_a_part_and_a_rim_can_be_stated(
    steady: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("rate", steady, "--from", "2", "--to", "8", "--json",
                    "--rim", "231", "183", "143") == 0
    part = json.loads(capsys.readouterr().out)["steady"]
    assert part["revolutions"] == pytest.approx(RATE * 6 / (2 * np.pi), abs=0.1)
    assert part["rate_rad_s"] == pytest.approx(RATE, rel=2e-4)
    assert pipeline("rate", steady, "--from", "8", "--to", "2") == 2
    assert pipeline("rate", steady, "--from", "20") == 4
    assert "a part within the clip" in capsys.readouterr().err


def test_a_camera_s_clip_is_measured_by_the_same_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A film played in real time stands for the camera."""
    played = tmp_path / "played.mp4"
    film(played, PlateMotion(RATE), fps=15.0, seconds=9.0)
    told: list[tuple[str, int, int | None]] = []
    clip = film_clip(played, 6.5, tmp_path / "camera_0.mkv", lambda *done: told.append(done))
    assert {name for name, _, _ in told} == {"camera_0"}
    assert told[-1][2] == 6
    assert pipeline("rate", clip, "--json") == 0
    found = json.loads(capsys.readouterr().out)["camera_0"]
    assert found["rate_rad_s"] == pytest.approx(RATE, abs=4 * found["sd_rad_s"])


def test_a_camera_that_is_not_there_is_a_device_s_failure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("rate", "--camera", "63", "--seconds", "1") == 6
    assert "camera 63 cannot be opened" in capsys.readouterr().err
    with pytest.raises(DeviceError, match="cannot be opened"):
        film_clip(tmp_path / "none.mp4", 1.0, tmp_path / "clip.mkv", lambda *_: None)


@pytest.mark.parametrize("typed", [
    (), ("--camera", "0", "clip.mp4"), ("clip.mp4", "--keep", "kept.mkv"),
    ("--camera", "0", "--keep", "kept.mp4"),
])
def test_a_clip_or_a_camera_and_not_both(
    typed: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert pipeline("rate", *typed) == 2
    assert "camera" in capsys.readouterr().err
