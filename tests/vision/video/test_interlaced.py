"""Clips of alternate fields, as camcorders write them, flagged as such or not."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vision.phase_tracks import CLOCK
from tests.vision.rendered_clips import Render, small_scene
from tests.world.plate import PlateMotion
from vision.errors import UnreadableVideo
from vision.plate.fields import interlacing
from vision.rate.measure import measure_rate
from vision.tracking.track import track_phase
from vision.video.reader import NO_CHROMA, ClipReader, Frame

av = pytest.importorskip("av", reason="rendering clips needs PyAV")

MOTION = PlateMotion(33.3 * 2 * np.pi / 60)


@pytest.fixture(scope="module")
def fields(render: Render) -> Path:
    """A clip of 50 frames per second, each of which becomes a field."""
    return render(MOTION, small_scene(exposure_s=1 / 200), seconds=5, fps=50)[0]


def woven(source: Path, target: Path, *, flagged: bool, first: int = 0) -> Path:
    """Two frames to one: the rows of the first, from ``first`` on, and those of the second."""
    with av.open(str(source)) as old, av.open(str(target), "w") as new:
        stream = new.add_stream("libx264", rate=25)
        images = [frame.to_ndarray(format="gray") for frame in old.decode(video=0)]
        stream.height, stream.width = images[0].shape
        stream.pix_fmt = "yuv420p"
        stream.options = {"preset": "ultrafast", **({"x264-params": "tff=1"} if flagged else {})}
        for i, (one, other) in enumerate(zip(images[::2], images[1::2], strict=True)):
            both = other.copy()
            both[first::2] = one[first::2]
            frame = av.VideoFrame.from_ndarray(both, format="gray").reformat(format="yuv420p")
            frame.pts, frame.time_base = i, Fraction(1, 25)
            new.mux(stream.encode(frame))
        new.mux(stream.encode())
    return target


@pytest.mark.parametrize(("flagged", "first"), [(False, 0), (False, 1), (True, 0)])
def test_the_fields_of_an_interlaced_clip_are_frames_of_their_own(
    flagged: bool, first: int, fields: Path, tmp_path: Path
) -> None:
    """OpenCV hands back frames of nothing where the file says that it is interlaced."""
    track = track_phase(woven(fields, tmp_path / "woven.mp4", flagged=flagged, first=first))
    assert len(track.time_s) == 250
    assert any("the clip is interlaced" in note for note in track.notes)
    rate = measure_rate(track, timebase=CLOCK)
    error = abs(rate.rate_rad_s / MOTION.rate_rad_s - 1)
    assert error < 3 * rate.sd_rad_s / rate.rate_rad_s < 200e-6


def test_a_clip_of_whole_frames_is_left_alone(fields: Path) -> None:
    with ClipReader(fields) as clip:
        frames = next(iter(clip))
    assert interlacing(frames) is None
    noise = np.random.default_rng(1).integers(0, 255, (16, 120, 160)).astype(np.uint8)
    assert interlacing([Frame(i / 25, image, NO_CHROMA) for i, image in enumerate(noise)]) is None
    held = np.repeat(noise[:1] // 2, 16, axis=0)  # an encoder holds thin print, and renews it
    held[:, 20:100:4, 50:110] = 150 + 6 * np.arange(16)[:, None, None]
    assert interlacing([Frame(i / 60, image, NO_CHROMA) for i, image in enumerate(held)]) is None


@pytest.mark.parametrize("first", [0, 1])
def test_fine_print_that_moves_slowly_is_seen_in_fields_by_where_its_teeth_go(first: int) -> None:
    """Rows that differ as much as the teeth, and half a pixel from field to field."""
    print_ = np.random.default_rng(0).standard_normal((240, 400))
    print_ = (np.roll(print_, 1, axis=0) + 2 * print_ + np.roll(print_, -1, axis=0)) / 4
    k = np.fft.rfftfreq(400)
    smooth = np.fft.rfft(print_) * np.exp(-((k / 0.04) ** 2) / 2)

    def shown(shift_px: float) -> NDArray[np.uint8]:
        moved = np.fft.irfft(smooth * np.exp(-2j * np.pi * k * shift_px), 400)
        return np.rint(np.clip(120 + 150 * moved, 0, 255)).astype(np.uint8)

    whole = [Frame(i / 25, shown(i), NO_CHROMA) for i in range(16)]
    woven = []
    for i in range(16):
        luma = shown(i + 0.5)
        luma[first::2] = shown(i)[first::2]
        woven.append(Frame(i / 25, luma, NO_CHROMA))
    assert interlacing(whole) is None
    fields = interlacing(woven)
    assert fields is not None
    assert fields.later_s == pytest.approx(0.02)
    assert fields.first_row == first


def test_without_the_other_decoder_an_interlaced_clip_says_what_to_type(
    fields: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = woven(fields, tmp_path / "woven.mp4", flagged=True)

    def missing(*_: object, **__: object) -> None:
        raise ModuleNotFoundError("av")

    monkeypatch.setattr("vision.video.reader.AvCapture.__init__", missing)
    monkeypatch.setattr("vision.video.reader.BLACK", 255.0)  # what the decoder hands back varies
    with pytest.raises(UnreadableVideo, match=r"interlaced.*pip install '.*\[fields\]'"):
        track_phase(path)
