"""What turns is separated from what comes and goes in place."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vision.rendered_clips import Render
from vision.errors import RateRefused
from vision.geometry import PlateOverride
from vision.plate.low_orders import ORDERS
from vision.plate.rotation import CoarseRotation, RotationSearch
from vision.plate.second_rate import left_by, turns_itself
from vision.tracking.track import track_phase

FloatArray = NDArray[np.float64]

RINGS, AZIMUTHS, FRAMES, FPS = 6, 128, 150, 15.0
WEIGHT = np.linspace(0.2, 1.0, RINGS).astype(np.float32)
TIME = np.arange(FRAMES) / FPS
PLATE = -3.5 * TIME  # rad


def pattern(rng: np.random.Generator) -> FloatArray:
    """A random pattern, smooth along the rings, of about a grey step."""
    order = np.arange(AZIMUTHS // 2 + 1)
    spectrum = rng.normal(size=(RINGS, len(order))) + 1j * rng.normal(size=(RINGS, len(order)))
    spectrum *= np.exp(-order / 5)
    spectrum[:, 0] = 0
    strip = np.fft.irfft(spectrum, AZIMUTHS, axis=1)
    return np.asarray(strip / strip.std())


def turned(strip: FloatArray, angle_rad: FloatArray) -> FloatArray:
    shift = np.exp(-1j * np.outer(angle_rad, np.arange(AZIMUTHS // 2 + 1)))
    return np.fft.irfft(np.fft.rfft(strip, axis=1) * shift[:, None, :], AZIMUTHS, axis=2)


def spin(strips: FloatArray) -> CoarseRotation:
    spectra = np.fft.rfft(strips, axis=2)[:, :, 1 : ORDERS + 1] / AZIMUTHS
    return RotationSearch(TIME).about(spectra.transpose(2, 1, 0).astype(np.complex64), WEIGHT)


def in_place(kind: str, rng: np.random.Generator) -> FloatArray:
    """Amplitudes of patterns that do not move, shape (frames, patterns)."""
    if kind == "a lamp that flickers":
        flicker = np.sin(2 * np.pi * rng.uniform(0.1, 7) * TIME + rng.uniform(0, 6))
        return np.asarray(flicker)[:, None]
    if kind == "a light that is turned up":
        return (TIME / TIME[-1])[:, None]
    if kind == "blocks that an encoder renews":
        steps = rng.integers(0, FRAMES, 30)
        return np.asarray(np.arange(FRAMES)[:, None] >= steps, float)
    return rng.normal(size=(FRAMES, FRAMES))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    "kind",
    ["a lamp that flickers", "a light that is turned up", "blocks that an encoder renews", "noise"],
)
def test_what_comes_and_goes_in_place_does_not_turn(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    amplitude = in_place(kind, rng)
    patterns = np.array([pattern(rng) for _ in range(amplitude.shape[1])])
    rotation = spin(np.einsum("fp,pra->fra", amplitude, patterns))
    assert rotation.coherence < 0.15


@pytest.mark.parametrize("rate_rad_s", [0.6, 3.5, -8.2, 40.0])
def test_a_plate_turns_though_a_lamp_flickers_as_strongly(rate_rad_s: float) -> None:
    rng = np.random.default_rng(1)
    plate, glare = pattern(rng), pattern(rng)
    flicker = np.sqrt(2) * np.sin(2 * np.pi * 1.7 * TIME)
    rotation = spin(turned(plate, rate_rad_s * TIME) + flicker[:, None, None] * glare)
    assert rotation.coherence == pytest.approx(0.5, abs=0.1)
    assert rotation.angle_rad[-1] / TIME[-1] == pytest.approx(rate_rad_s, abs=0.1)


@pytest.mark.parametrize("seed", range(8))
def test_two_equal_marks_turn_slowly_and_not_by_half_a_turn_more_per_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    half = pattern(rng)
    plate = half + np.roll(half, AZIMUTHS // 2, axis=1)
    strips = turned(plate, 3.5 * TIME) + 0.3 * rng.standard_normal((FRAMES, RINGS, AZIMUTHS))
    assert spin(strips).angle_rad[-1] / TIME[-1] == pytest.approx(3.5, abs=0.1)


def test_frames_that_are_all_alike_do_not_turn() -> None:
    """What is left after their mean is taken off is rounding."""
    strips = np.repeat(30 * pattern(np.random.default_rng(2))[None], FRAMES, axis=0)
    assert spin(strips).coherence < 1e-3


def test_a_rim_given_beside_the_plate_is_refused_as_one_that_does_not_turn(render: Render) -> None:
    from tests.world.film import Recorder, Scene
    from tests.world.plate import PlateMotion

    scene = Scene()
    path, _ = render(PlateMotion(3.5), scene, seconds=8, recorder=Recorder(crf=30))
    beside = [(40, 40, 30), (440, 50, 25), (45, 320, 35), (430, 310, 40), (30, 180, 18)]
    for x, y, radius in beside:
        apart = np.hypot(x - scene.centre_px[0], y - scene.centre_px[1])
        assert apart > 1.1 * scene.radius_px + radius
        with pytest.raises(RateRefused, match="nothing in the frame turns about a fixed axis"):
            track_phase(path, plate=PlateOverride(centre_px=(x, y), radius_px=radius))


def beside_a_plate(strips: FloatArray, plate_rad: FloatArray) -> tuple[bool, float]:
    """Whether a second thing turns, and its rate, rad/s."""
    spectra = np.fft.rfft(strips, axis=2)[:, :, 1 : ORDERS + 1].transpose(2, 1, 0)
    rest, share = left_by((spectra / strips.shape[2]).astype(np.complex64), plate_rad)
    rotation = RotationSearch(TIME).about(rest, WEIGHT)
    rotation = replace(rotation, coherence=share * rotation.coherence)
    lasts_s = float(np.ptp(TIME))
    return (turns_itself(rotation, lasts_s, plate_rad),
            float(rotation.angle_rad[-1]) / lasts_s)


def noise(rng: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    return 0.2 * rng.standard_normal(shape)


@pytest.mark.parametrize("rate_rad_s", [-4.7, -2.6, 3.5, 0.9])
def test_a_faint_second_pattern_is_told_with_its_rate(rate_rad_s: float) -> None:
    """A third as strong as the plate, on rings of its own; the table stands."""
    rng = np.random.default_rng(3)
    label, record = pattern(rng), pattern(rng)
    label[3:], record[:3] = 0, 0
    strips = turned(record, PLATE) + turned(label, rate_rad_s * TIME) / 3 + 5 * pattern(rng)
    found, rate = beside_a_plate(strips + noise(rng, strips.shape), PLATE)
    assert found
    assert rate == pytest.approx(rate_rad_s, rel=0.03)


@pytest.mark.parametrize("seed", range(6))
def test_one_plate_has_no_second_rate(seed: int) -> None:
    """Seen with its axis off, which mixes neighbouring orders, and with angles that err."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    skewed = 1 + 0.2 * np.cos(around - rng.uniform(0, 6))
    strips = turned(pattern(rng), PLATE) * skewed + pattern(rng)
    erring = PLATE + 0.02 * np.sin(2 * PLATE)
    assert not beside_a_plate(strips + noise(rng, strips.shape), erring)[0]


def test_a_sheen_on_an_uneven_record_is_no_second_thing() -> None:
    """It shimmers twice per turn: order 3 has waves of two thirds of the plate's rate."""
    rng = np.random.default_rng(5)
    around = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    shimmer = turned(np.tile(np.cos(2 * around), (RINGS, 1)), PLATE)
    strips = turned(pattern(rng), PLATE) + (1 + np.cos(around)) * shimmer
    assert not beside_a_plate(strips + noise(rng, strips.shape), PLATE)[0]


def test_a_light_that_flickers_is_no_second_thing() -> None:
    rng = np.random.default_rng(4)
    strips = turned(pattern(rng), PLATE)
    strips += np.sin(7 * TIME)[:, None, None] * pattern(rng) + noise(rng, strips.shape)
    assert not beside_a_plate(strips, PLATE)[0]


def test_a_hand_that_turns_and_turns_back_is_no_second_thing() -> None:
    rng = np.random.default_rng(4)
    there_and_back = np.where(TIME < 6, 3 * TIME, 18 - 2 * (TIME - 6))
    strips = turned(pattern(rng), PLATE) + turned(pattern(rng), there_and_back)
    assert not beside_a_plate(strips + noise(rng, strips.shape), PLATE)[0]
