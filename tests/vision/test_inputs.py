"""Files that are no good clip of a plate: a right answer or a clear refusal, never a traceback."""

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from vision.drawing import png
from vision.errors import RateRefused, UnreadableVideo
from vision.geometry import PlateOverride
from vision.rate.measure import RateMeasurement, measure_rate
from vision.tracking.track import track_phase

av = pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.edited_clips import Image, again  # noqa: E402
from tests.vision.phase_tracks import CLOCK  # noqa: E402
from tests.vision.rendered_clips import Render, small_scene  # noqa: E402
from tests.world.film import Recorder  # noqa: E402
from tests.world.plate import PlateMotion  # noqa: E402

RPM = 2 * np.pi / 60
MOTION = PlateMotion(33.3 * RPM)
SCENE = small_scene()


@pytest.fixture(scope="module")
def clip(render: Render) -> Path:
    return render(MOTION, SCENE, seconds=8)[0]


def test_a_name_with_colons_is_a_file_and_no_protocol(
    clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "12:30:00.mp4").symlink_to(clip)
    monkeypatch.chdir(tmp_path)
    assert track_phase(Path("12:30:00.mp4")).time_s.size > 100


INDEX_FIRST = {"movflags": "faststart"}
PEAK = """if True:
    import sys
    from vision.rate.measure import RateMeasurement, measure_rate
    from vision.rate.timebase import Timebase
    from vision.tracking.track import track_phase
    rate = measure_rate(track_phase(sys.argv[1]), timebase=Timebase())
    peak_kb = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
    print(rate.rate_rad_s, int(peak_kb.split()[1]) / 1e3)
"""


def rate_of(path: Path, **how: Any) -> RateMeasurement:
    return measure_rate(track_phase(path, **how), timebase=CLOCK)


def test_a_missing_file_says_so(tmp_path: Path) -> None:
    with pytest.raises(UnreadableVideo, match=r"nowhere\.mp4: there is no such file"):
        track_phase(tmp_path / "nowhere.mp4")


def test_an_empty_file_says_so(tmp_path: Path) -> None:
    (tmp_path / "empty.mp4").touch()
    with pytest.raises(UnreadableVideo, match="empty"):
        track_phase(tmp_path / "empty.mp4")


def test_a_folder_is_no_clip(tmp_path: Path) -> None:
    with pytest.raises(UnreadableVideo, match="is no file; a clip is expected"):
        track_phase(tmp_path)


def test_a_text_file_is_no_clip(tmp_path: Path) -> None:
    (tmp_path / "notes.mp4").write_text("not a clip " * 100)
    with pytest.raises(UnreadableVideo, match="no video stream"):
        track_phase(tmp_path / "notes.mp4")


def test_a_file_cut_short_is_refused_or_measured_with_a_note(clip: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mp4"
    cut.write_bytes(clip.read_bytes()[: clip.stat().st_size // 2])  # the index was at the end
    with pytest.raises(UnreadableVideo, match="no video stream"):
        track_phase(cut)
    matroska = again(clip, tmp_path / "whole.mkv")
    cut = tmp_path / "cut.mkv"
    cut.write_bytes(matroska.read_bytes()[: int(0.6 * matroska.stat().st_size)])
    track = track_phase(cut)
    assert abs(measure_rate(track, timebase=CLOCK).rate_rad_s / MOTION.rate_rad_s - 1) < 2e-4
    assert any("cut short" in note for note in track.notes)


def test_a_file_that_ends_before_its_first_frame_says_so(clip: Path, tmp_path: Path) -> None:
    """The recorder wrote the index first, and the copy was broken off."""
    path = tmp_path / "index_only.mp4"
    with av.open(str(clip)) as old, av.open(str(path), "w", options=INDEX_FIRST) as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                new.mux(packet)
    whole = path.read_bytes()
    frames_at = whole.index(b"mdat")
    path.write_bytes(whole[: frames_at + 40])
    with pytest.raises(UnreadableVideo, match="not one frame could be decoded"):
        track_phase(path)
    path.write_bytes(whole[: frames_at + (len(whole) - frames_at) * 6 // 10])
    assert any("cut short" in note for note in track_phase(path).notes)


def test_sound_without_frames_is_no_clip(tmp_path: Path) -> None:
    path = tmp_path / "sound.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=8000)
        frame = av.AudioFrame.from_ndarray(
            np.zeros((1, 8000), np.float32), format="fltp", layout="mono"
        )
        frame.sample_rate = 8000
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    with pytest.raises(UnreadableVideo, match=r"no video stream|not one frame"):
        track_phase(path)


def test_a_still_frame_is_no_clip(clip: Path, tmp_path: Path) -> None:
    capture = cv2.VideoCapture(str(clip))
    cv2.imwrite(str(tmp_path / "still.png"), capture.read()[1])
    with pytest.raises(UnreadableVideo, match=r"1 frame\(s\) found|no video stream"):
        track_phase(tmp_path / "still.png")


def test_one_frame_is_not_enough(render: Render) -> None:
    path, _ = render(MOTION, seconds=1 / 15)
    with pytest.raises(UnreadableVideo, match=r"1 frame\(s\) found"):
        track_phase(path)


@pytest.mark.parametrize("pixel_format", ["gray", "yuvj420p"])
def test_other_pixel_formats_give_the_same_rate(pixel_format: str, render: Render) -> None:
    """The others are those of ``plate/test_channel.py``, whose plate turns in colour alone."""
    path, _ = render(MOTION, SCENE, seconds=6, recorder=Recorder(pixel_format=pixel_format))
    assert abs(rate_of(path).rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4


def test_motion_jpeg_in_avi_gives_the_same_rate(clip: Path, tmp_path: Path) -> None:
    path = again(clip, tmp_path / "webcam.avi", pixel_format="yuvj420p", codec="mjpeg")
    assert set(track_phase(path).coding) == {ord("I")}
    assert abs(rate_of(path).rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4


def test_a_large_clip_is_reduced_and_gives_the_same_rate(render: Render, tmp_path: Path) -> None:
    path = again(render(MOTION, SCENE, seconds=4)[0], tmp_path / "large.mp4", size=(1920, 1440))
    track = track_phase(path)
    assert track.plate.reduction == 2
    assert track.plate.size_px == (1920, 1440)
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(rate.rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4


def test_a_4k_clip_takes_little_more_memory_than_a_small_one(
    render: Render, tmp_path: Path
) -> None:
    if not Path("/proc/self/status").exists():
        pytest.skip("the peak memory of a process is read from /proc")
    wide = (0, 0, 80, 80, cv2.BORDER_REPLICATE)  # to 16:9
    small, _ = render(MOTION, seconds=3)
    large = again(small, tmp_path / "4k.mp4", size=(3840, 2160),
                  change=lambda i, image: np.asarray(cv2.copyMakeBorder(image, *wide), np.uint8))
    peak_mb = {}
    for path in (small, large):
        done = subprocess.run([sys.executable, "-c", PEAK, str(path)], capture_output=True,
                              text=True, check=True)
        rate_rad_s, peak_mb[path] = map(float, done.stdout.split())
        assert abs(rate_rad_s / MOTION.rate_rad_s - 1) < 5e-4
    # The decoder holds a dozen frames of 12 MB; all 45 as they come would be 370 MB of luma.
    assert peak_mb[large] - peak_mb[small] < 200


def test_a_portrait_clip_turns_as_it_is_shown(clip: Path, tmp_path: Path) -> None:
    path = again(clip, tmp_path / "portrait.mp4", change=lambda i, p: np.rot90(p))
    rate = rate_of(path)
    assert rate.direction == "ccw"
    assert abs(rate.rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4


def test_two_plates_in_view_are_not_mixed(clip: Path, tmp_path: Path) -> None:
    """The second plate turns the other way; one rate or the other, or a refusal."""

    def two(i: int, image: Image) -> Image:
        small = cv2.resize(image[:, ::-1], None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
        canvas = np.full((image.shape[0], image.shape[1] + small.shape[1], 3), 90, np.uint8)
        canvas[:, : image.shape[1]] = image
        canvas[: small.shape[0], image.shape[1] :] = small
        return canvas

    track = track_phase(again(clip, tmp_path / "two.mp4", change=two))
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.direction == "ccw"
    assert abs(rate.rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4
    assert any("two things turn" in text for text in rate.warnings)


def test_the_rim_given_by_hand_is_used(clip: Path) -> None:
    given = PlateOverride(centre_px=(155.3, 120.7), radius_px=96.3)
    assert abs(rate_of(clip, plate=given).rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4
    with pytest.raises(RateRefused, match="turns about a fixed axis"):
        track_phase(clip, plate=PlateOverride(centre_px=(40.0, 40.0), radius_px=26.7))


def test_how_each_frame_is_coded_is_read_from_the_file(clip: Path) -> None:
    with av.open(str(clip)) as container:
        coded = ["?IPB"[int(frame.pict_type)] for frame in container.decode(video=0)]
    assert len(set(coded)) == 3
    assert bytes(track_phase(clip).coding).decode() == "".join(coded)


def test_progress_is_reported_to_the_last_frame(clip: Path) -> None:
    calls = []
    track = track_phase(clip, on_progress=lambda done, stated: calls.append((done, stated)))
    assert calls[-1] == (len(track.time_s), 120)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)


def test_the_work_can_be_ended_at_every_step_also_while_the_plate_is_learned(clip: Path) -> None:
    calls = []
    threads = set(threading.enumerate())  # another test may have left one behind
    track_phase(clip, on_progress=lambda done, stated: calls.append(done))
    learning = calls.count(0)
    assert learning > 10
    for last in (1, learning // 2, learning, learning + 2):
        heard: list[int] = []

        def end(done: int, stated: int | None, heard: list[int] = heard, last: int = last) -> None:
            heard.append(done)
            if len(heard) == last:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            track_phase(clip, on_progress=end)
        assert heard == calls[:last]
        assert set(threading.enumerate()) <= threads


def test_the_annotated_frame_shows_plate_and_centre(clip: Path) -> None:
    shown = cv2.imdecode(track_phase(clip).annotated, cv2.IMREAD_COLOR)
    assert shown is not None
    assert shown.dtype == np.uint8
    assert shown.shape == (240, 320, 3)
    x, y = round(SCENE.centre_px[0]), round(SCENE.centre_px[1])
    blue, _, red = shown[y, x].astype(int)
    assert red > blue + 100


def test_a_png_decodes_to_the_image_within_a_step_of_grey() -> None:
    y, x = np.mgrid[0:40, 0:60]
    image = np.repeat(((x + y) * 2.5).astype(np.uint8)[:, :, None], 3, axis=2)
    image[10:20, 10:20] = (0, 200, 255)
    seen = cv2.imdecode(png(image), cv2.IMREAD_COLOR)
    assert seen is not None
    assert np.abs(seen.astype(int) - image.astype(int)).max() <= 4
