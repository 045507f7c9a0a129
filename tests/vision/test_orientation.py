"""Films that are shown turned or mirrored: geometry and sense of rotation as displayed."""

import struct

import numpy as np
import pytest

from vision.orientation import Orientation, stated_orientation
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase
from vision.video import ClipReader

pytest.importorskip("av", reason="rendering clips needs PyAV")

from tests.world.film import Recorder, Scene
from tests.world.plate import PlateMotion

RPM = 2 * np.pi / 60
MOTION = PlateMotion(33.3 * RPM)
SCENE = Scene()

#: What is done to a picture for display -> (a, b, c, d): x' = a x + c y, y' = b x + d y, y down.
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
SHOWN = {
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
def clip(render):
    return render(MOTION, SCENE, seconds=8)[0]


@pytest.fixture(scope="module")
def stored(clip):
    return track_phase(clip)


def with_matrix(mp4, box, matrix, offset):
    """An MP4 file with another matrix in a header (ISO 14496-12, 8.2.2 and 8.3.2).

    (a b u, c d v, x y w) by rows, the last column in 2.30 and the others in 16.16 fixed point; the
    shift brings the picture back into view.
    """
    a, b, c, d = matrix
    h, w = SCENE.height_px, SCENE.width_px
    x, y = w * (a < 0) + h * (c < 0), w * (b < 0) + h * (d < 0)
    values = (a << 16, b << 16, 0, c << 16, d << 16, 0, x << 16, y << 16, 1 << 30)
    at = mp4.index(box) + len(box) + offset
    return mp4[:at] + struct.pack(">9i", *values) + mp4[at + 36 :]


def shown(mp4, how):
    return with_matrix(mp4, b"tkhd", MATRIX[how], 40)


def first_picture(path):
    with ClipReader(path) as film:
        return next(iter(film))[0].luma


@pytest.mark.parametrize("how", MATRIX)
def test_a_film_is_seen_and_measured_as_it_is_shown(how, clip, stored, tmp_path):
    """A phone writes the pictures as its sensor lies, and how to show them."""
    path = tmp_path / "phone.mp4"
    path.write_bytes(shown(clip.read_bytes(), how))
    assert np.array_equal(first_picture(path), SHOWN[how](first_picture(clip)))

    a, b, c, d = MATRIX[how]
    track = track_phase(path)
    assert track.plate.size_px == (stored.size_px if a else stored.size_px[::-1])
    # The deck's mark stands at azimuth φ, y upwards: x = cos φ, y = -sin φ.
    x, y = np.cos(stored.deck_mark_rad), -np.sin(stored.deck_mark_rad)
    expected = np.arctan2(-(b * x + d * y), a * x + c * y)
    assert abs(np.angle(np.exp(1j * (track.plate.fixed_mark_azimuth_rad - expected)))) < 0.03

    mirrored = a * d - b * c < 0
    rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    assert rate.direction == ("cw" if mirrored else "ccw")
    assert abs(rate.rate_rad_s / MOTION.rate_rad_s - 1) < 1e-4
    assert [w for w in rate.warnings if "shown mirrored" in w] == list(rate.warnings)
    assert len(rate.warnings) == mirrored


def test_the_matrix_of_the_movie_comes_after_that_of_the_track(clip, tmp_path):
    path = tmp_path / "both.mp4"
    movie = with_matrix(clip.read_bytes(), b"mvhd", MATRIX["left and right swapped"], 36)
    path.write_bytes(shown(movie, "turned clockwise"))
    clockwise = SHOWN["turned clockwise"](first_picture(clip))
    assert np.array_equal(first_picture(path), np.fliplr(clockwise))


def test_a_large_header_is_read_and_a_skewed_or_broken_one_is_left_to_the_decoder(clip, tmp_path):
    whole, path = shown(clip.read_bytes(), "transposed"), tmp_path / "other.mp4"

    def orientation(content):
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


def test_a_film_that_is_no_mp4_has_no_stated_orientation(render):
    path, _ = render(MOTION, seconds=1, suffix=".mkv", recorder=Recorder())
    assert stated_orientation(path) is None


@pytest.mark.parametrize("how", MATRIX)
def test_an_orientation_shows_a_picture_of_any_kind_as_its_matrix_says(how):
    rng = np.random.default_rng(0)
    a, b, c, d = MATRIX[how]
    orientation = Orientation(not a, a + c < 0, b + d < 0)
    assert orientation.mirrored == (a * d - b * c < 0)
    for shape in ((4, 6), (4, 6, 3)):
        picture = rng.integers(0, 255, shape, np.uint8)
        assert np.array_equal(orientation.displayed(picture), SHOWN[how](picture))
