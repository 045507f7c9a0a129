"""Clips that are shown turned or mirrored: geometry and sense of rotation as displayed."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vision.phase_track import PhaseTrack
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase
from vision.video.orientation import Orientation, stated_orientation
from vision.video.reader import ClipReader, Luma

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.vision.rendered_clips import Render, small_scene
from tests.world.film import Recorder
from tests.world.plate import PlateMotion

RPM = 2 * np.pi / 60
MOTION = PlateMotion(33.3 * RPM)
SCENE = small_scene()

#: What is done to a frame for display -> (a, b, c, d): x' = a x + c y, y' = b x + d y, y down.
MATRIX = {
    "as stored": (1, 0, 0, 1),
    "turned clockwise": (0, 1, -1, 0),
    "turned by half": (-1, 0, 0, -1),
    "turned counter-clockwise": (0, -1, 1, 0),
    "left and right swapped": (-1, 0, 0, 1),
    "up and down swapped": (1, 0, 0, -1),
    "transposed": (0, 1, 1, 0),
    "transposed and turned by half": (0, -1, -1, 0),
}
SHOWN: dict[str, Callable[[NDArray[Any]], NDArray[Any]]] = {
    "as stored": lambda p: p,
    "turned clockwise": lambda p: np.rot90(p, -1),
    "turned by half": lambda p: np.rot90(p, 2),
    "turned counter-clockwise": lambda p: np.rot90(p),
    "left and right swapped": np.fliplr,
    "up and down swapped": np.flipud,
    "transposed": lambda p: p.swapaxes(0, 1),
    "transposed and turned by half": lambda p: np.rot90(p.swapaxes(0, 1), 2),
}


@pytest.fixture(scope="module")
def clip(render: Render) -> Path:
    return render(MOTION, SCENE, seconds=8)[0]


@pytest.fixture(scope="module")
def stored(clip: Path) -> PhaseTrack:
    return track_phase(clip)


def with_matrix(mp4: bytes, box: bytes, matrix: tuple[int, int, int, int], offset: int) -> bytes:
    """An MP4 file with another matrix in a header (ISO 14496-12, 8.2.2 and 8.3.2).

    (a b u, c d v, x y w) by rows, the last column in 2.30 and the others in 16.16 fixed point; the
    shift brings the frame back into view.
    """
    a, b, c, d = matrix
    h, w = SCENE.height_px, SCENE.width_px
    x, y = w * (a < 0) + h * (c < 0), w * (b < 0) + h * (d < 0)
    values = (a << 16, b << 16, 0, c << 16, d << 16, 0, x << 16, y << 16, 1 << 30)
    at = mp4.index(box) + len(box) + offset
    return mp4[:at] + struct.pack(">9i", *values) + mp4[at + 36 :]


def shown(mp4: bytes, how: str) -> bytes:
    return with_matrix(mp4, b"tkhd", MATRIX[how], 40)


def first_frame(path: Path) -> Luma:
    with ClipReader(path) as reader:
        return next(iter(reader))[0].luma


@pytest.mark.parametrize("how", MATRIX)
def test_a_clip_is_seen_as_it_is_shown(how: str, clip: Path, tmp_path: Path) -> None:
    """A phone writes the frames as its sensor lies, and how to show them."""
    path = tmp_path / "phone.mp4"
    path.write_bytes(shown(clip.read_bytes(), how))
    assert np.array_equal(first_frame(path), SHOWN[how](first_frame(clip)))


@pytest.mark.parametrize("how", ["turned clockwise", "up and down swapped", "transposed"])
def test_a_clip_is_measured_as_it_is_shown(
    how: str, clip: Path, stored: PhaseTrack, tmp_path: Path
) -> None:
    path = tmp_path / "phone.mp4"
    path.write_bytes(shown(clip.read_bytes(), how))
    a, b, c, d = MATRIX[how]
    track = track_phase(path)
    assert track.plate.size_px == (stored.plate.size_px if a else stored.plate.size_px[::-1])
    # The mark of the first frame stands at azimuth φ, y upwards: x = cos φ, y = -sin φ.
    before, seen = (each.plate.mark_azimuth_rad + each.phase_rad[0] for each in (stored, track))
    x, y = np.cos(before), -np.sin(before)
    expected = np.arctan2(-(b * x + d * y), a * x + c * y)
    assert abs(np.angle(np.exp(1j * (seen - expected)))) < 0.03

    mirrored = a * d - b * c < 0
    rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    assert rate.direction == ("cw" if mirrored else "ccw")
    assert abs(rate.rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4
    assert [w for w in rate.warnings if "displayed mirrored" in w] == list(rate.warnings)
    assert len(rate.warnings) == mirrored


def test_the_matrix_of_the_movie_comes_after_that_of_the_track(clip: Path, tmp_path: Path) -> None:
    path = tmp_path / "both.mp4"
    movie = with_matrix(clip.read_bytes(), b"mvhd", MATRIX["left and right swapped"], 36)
    path.write_bytes(shown(movie, "turned clockwise"))
    clockwise = SHOWN["turned clockwise"](first_frame(clip))
    assert np.array_equal(first_frame(path), np.fliplr(clockwise))


def test_a_large_header_is_read_and_a_skewed_or_broken_one_is_left_to_the_decoder(
    clip: Path, tmp_path: Path
) -> None:
    whole, path = shown(clip.read_bytes(), "transposed"), tmp_path / "other.mp4"

    def orientation(content: bytes) -> Orientation | None:
        path.write_bytes(content)
        return stated_orientation(path)

    assert orientation(whole) == Orientation(transposed=True)
    # A box of media with a 64-bit size before the headers, as long recordings have it.
    long = struct.pack(">I4sQ", 1, b"mdat", 16 + 5) + b"video"
    at = whole.index(b"moov") - 4
    assert orientation(long + whole[at:]) == Orientation(transposed=True)
    assert orientation(with_matrix(whole, b"tkhd", (1, 1, -1, 1), 40)) is None
    for cut in (b"moov", b"mvhd", b"tkhd", b"hdlr"):
        end = whole.index(cut) + 10
        assert orientation(whole[:end]) is None
        path.write_bytes(whole[:end] + bytes(20))
        stated_orientation(path)
    assert orientation(b"") is None
    assert orientation(b"\x1aE\xdf\xa3" + bytes(range(256))) is None


def test_a_clip_that_is_no_mp4_has_no_stated_orientation(render: Render) -> None:
    path, _ = render(MOTION, seconds=1, suffix=".mkv", recorder=Recorder())
    assert stated_orientation(path) is None


@pytest.mark.parametrize("how", MATRIX)
def test_an_orientation_shows_a_frame_of_any_kind_as_its_matrix_says(how: str) -> None:
    rng = np.random.default_rng(0)
    a, b, c, d = MATRIX[how]
    orientation = Orientation(not a, a + c < 0, b + d < 0)
    assert orientation.mirrored == (a * d - b * c < 0)
    for shape in ((4, 6), (4, 6, 3)):
        image = rng.integers(0, 255, shape, np.uint8)
        assert np.array_equal(orientation.displayed(image), SHOWN[how](image))
