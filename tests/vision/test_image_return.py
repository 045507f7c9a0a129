"""A picture that is itself again after some time, on arrays: dots that turn, flicker and noise."""

from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from vision.errors import EqualReturns, NoPlate, OnlyShifts
from vision.image_return import BLOCK, image_return
from vision.plate.periodic import PeriodicFit
from vision.plate.pixel_motion import Turning, turning
from vision.tracking.small_clip import SmallClip
from vision.video.reader import NO_CHROMA, Frame

FRAME_S = 1 / 25
FRAMES = 250


def turning_dots(
    rpm: float, *, way: int = 1, squeeze: float = 0.4, fold: int = 1, noise: float = 2.0
) -> NDArray[np.uint8]:
    """Blurred dots on a disc seen from the side, shape (f, 96, 128)."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:96, :128]
    radius, azimuth = rng.uniform(8, 40, 6), rng.uniform(0, 2 * np.pi, 6)
    frames = np.full((FRAMES, 96, 128), 90.0)
    for part in range(fold):
        for r, a in zip(radius, azimuth, strict=True):
            at = a + 2 * np.pi * (way * rpm / 60 * FRAME_S * np.arange(FRAMES) + part / fold)
            column, row = 64 + r * np.cos(at), 48 - squeeze * r * np.sin(at)
            away = (x - column[:, None, None]) ** 2 + ((y - row[:, None, None]) / squeeze) ** 2
            frames += 80 * np.exp(-away / 40)
    frames += noise * rng.standard_normal(frames.shape)
    return np.clip(np.rint(frames), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("rpm", [33.05, 44.83, 61.7])
def test_a_picture_that_turns_returns_after_a_turn(rpm: float) -> None:
    returned = image_return(turning_dots(rpm), FRAME_S)
    assert returned is not None
    assert abs(60 / returned.period_s - rpm) < 2 * returned.sd_s / returned.period_s * rpm
    assert returned.sd_s / returned.period_s < 0.003


@pytest.mark.parametrize(("contrast", "seed"), [(0, 0), (10, 0), (10, 1)])
def test_a_label_smaller_than_a_block_returns_in_finer_ones(contrast: int, seed: int) -> None:
    """Some pixels of a plate far away, among blocks that an encoder renews."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:96, :128]
    angle = 2 * np.pi * 33.05 / 60 * FRAME_S * np.arange(FRAMES)[:, None, None]
    away = (x - 70.3 - 1.6 * np.cos(angle)) ** 2 + (y - 41.6 - 1.6 * np.sin(angle)) ** 2
    renewed = 1.5 * rng.standard_normal((FRAMES, 24, 32)).repeat(4, axis=1).repeat(4, axis=2)
    noise = 0.3 * rng.standard_normal(away.shape)
    shown = np.rint(90 + contrast * np.exp(-away / 2) + renewed + noise).astype(np.uint8)
    small = SmallClip(cast(Any, SimpleNamespace(frames_stated=FRAMES, reduction=1)))
    frames = [Frame(i * FRAME_S, image, NO_CHROMA) for i, image in enumerate(shown)]
    for _ in small.followed([frames]):
        pass
    small.choose()
    assert image_return(shown, FRAME_S, (BLOCK,)) is None
    if contrast:
        assert small.returns is not None
        assert 60 / small.returns.period_s == pytest.approx(33.05, rel=0.005)
    else:
        assert small.returns is None


def test_a_lamp_that_flickers_and_noise_do_not_return() -> None:
    rng = np.random.default_rng(6)
    lamp = 1 + 0.3 * np.sin(np.arange(FRAMES) * 0.9)
    table = rng.uniform(60, 160, (96, 128))
    frames = lamp[:, None, None] * table + 2 * rng.standard_normal((FRAMES, 96, 128))
    assert image_return(np.rint(frames).astype(np.uint8), FRAME_S) is None


def test_less_than_two_turns_do_not_return() -> None:
    assert image_return(turning_dots(9.0), FRAME_S) is None


@pytest.mark.parametrize("way", [1, -1])
def test_pixels_from_the_side_tell_the_rate_the_sense_and_the_view(way: int) -> None:
    rpm = 33.05
    frames = turning_dots(rpm, way=way)
    returned = image_return(frames, FRAME_S)
    assert returned is not None
    time = FRAME_S * np.arange(FRAMES)
    mask = frames.std(axis=0) > 6
    fit = PeriodicFit(frames[:, mask], time, returned.period_s, returned.sd_s)
    turns = turning(fit.coefficients, mask)
    slope = np.polynomial.Polynomial.fit(time, fit.pixels().angle_rad, 1).convert().coef[1]
    assert slope * 30 / np.pi == pytest.approx(rpm, rel=50e-6)
    assert turns is not None
    assert turns.way == way
    assert turns.view.centre_px == pytest.approx((64, 48), abs=2)
    assert np.cos(turns.view.tilt_rad) == pytest.approx(0.4, abs=0.08)


@pytest.mark.parametrize("noise", [2.0, 6.0])
def test_a_small_plate_among_pixels_of_noise_tells_sense_and_view(noise: float) -> None:
    """All pixels of the frame, of which nine in ten show noise alone."""
    frames = turning_dots(33.05, noise=noise)
    turns = turned_by(frames, np.ones(frames.shape[1:], bool), 60 / 33.05 / FRAME_S)
    assert turns is not None
    assert turns.way == 1
    assert turns.view.centre_px == pytest.approx((64, 48), abs=1)
    assert turns.view.radius_px == pytest.approx(40, abs=6)
    assert np.cos(turns.view.tilt_rad) == pytest.approx(0.4, abs=0.08)


def test_a_picture_that_returns_twice_per_turn_gives_no_sense_of_a_turn() -> None:
    """Its rate would be twice that of the plate."""
    frames = turning_dots(20.3, fold=2)
    returned = image_return(frames, FRAME_S)
    assert returned is not None
    mask = frames.std(axis=0) > 6
    time = FRAME_S * np.arange(FRAMES)
    fit = PeriodicFit(frames[:, mask], time, returned.period_s, returned.sd_s)
    assert 60 / returned.period_s == pytest.approx(2 * 20.3, rel=0.01)
    with pytest.raises(EqualReturns, match=r"moves by about 0\.[45]\d of a turn"):
        turning(fit.coefficients, mask)


def test_traffic_both_ways_turns_about_no_axis() -> None:
    """Its flow has a curl, as that of a plate has."""
    y, x = np.mgrid[:96, :128]
    time = np.arange(FRAMES)[:, None, None]
    lanes = sum(80 * np.exp(-(((x - way * 2 * time + 35) % 70 - 35) ** 2 + (y - row) ** 2) / 90)
                for way, row in ((1, 30), (-1, 62)))
    with pytest.raises(OnlyShifts, match="about no common axis"):
        turned_by(90 + lanes, np.abs(y - 46) < 34, 35.0)


def test_what_goes_to_and_fro_is_no_turning_plate() -> None:
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:96, :128]
    column = 64 + 30 * np.sin(2 * np.pi * np.arange(FRAMES) / 37.3)
    frames = 90 + 80 * np.exp(-((x - column[:, None, None]) ** 2 + (y - 48) ** 2) / 60)
    frames = np.rint(frames + 2 * rng.standard_normal(frames.shape)).astype(np.uint8)
    returned = image_return(frames, FRAME_S)
    assert returned is not None
    mask = frames.std(axis=0) > 6
    fit = PeriodicFit(frames[:, mask], FRAME_S * np.arange(FRAMES), returned.period_s,
                      returned.sd_s)
    with pytest.raises(NoPlate, match=r"to and fro, or comes and goes \((9\d|100)% of"):
        turning(fit.coefficients, mask)


def test_what_shifts_at_an_even_speed_does_not_return_without_what_is_slow() -> None:
    """Less its mean over two seconds a slow shift seems to return twice; a slow plate does."""
    rng = np.random.default_rng(3)
    wide = cv2.GaussianBlur(rng.standard_normal((96, 512)), (0, 0), 9)
    at = np.arange(FRAMES) * 0.6
    shifts = [cv2.warpAffine(wide, np.array([[1, 0, -x], [0, 1, 0]]), (128, 96)) for x in at]
    frames = 90 + 25 * np.array(shifts) / wide.std()
    frames += rng.standard_normal(frames.shape)
    assert image_return(np.rint(np.clip(frames, 0, 255)).astype(np.uint8), FRAME_S) is None
    assert image_return(turning_dots(16.0), FRAME_S) is not None


def test_blades_in_step_with_the_frames_are_no_plate_that_turns_slowly() -> None:
    """Three at 844 rpm and 25 frames per second return after 77 frames, as a plate at 19 rpm."""
    y, x = np.mgrid[:96, :128]
    turned = 844 / 60 * 2 * np.pi * FRAME_S * np.arange(FRAMES)[:, None, None]
    blade = np.cos(3 * (np.arctan2(48 - y, x - 64) - turned)) > np.cos(0.9)
    some = np.random.default_rng(1).random((96, 128)) < 0.7  # those with most information
    with pytest.raises(EqualReturns, match="waves once and twice per return are 0%"):
        turned_by(90 + 100 * blade, (np.hypot(x - 64, y - 48) < 45) & some, 77.0)


def test_what_passes_by_in_one_direction_is_no_plate() -> None:
    """Boxes on a belt, alike; the rim of a plate far below the frame passes too, but turns."""
    y, x = np.mgrid[:96, :128]
    time = np.arange(FRAMES)
    along = (x - 2.1 * time[:, None, None]) % 70 - 35
    belt = np.exp(-(along**2 + (y - 48) ** 2) / 90)
    mask = np.abs(y - 48) < 14
    with pytest.raises(OnlyShifts, match=r"passes by in one direction .* turning 0% more"):
        turned_by(90 + 80 * belt, mask, 70 / 2.1)
    angle = 2 * np.pi * time[:, None, None] / 60
    rim = sum(np.exp(-((x - 64 - 90 * np.sin(a)) ** 2 + (y - 130 + 90 * np.cos(a)) ** 2) / 90)
              for a in (angle + b for b in (0.0, 0.9, 2.3, 4.1)))
    turned = turned_by(90 + 80 * rim, np.abs(np.hypot(x - 64, y - 130) - 90) < 10, 60.0)
    assert turned is not None
    assert turned.way == -1


def test_what_passes_by_beside_pixels_that_pulse_hides_no_plate() -> None:
    """An encoder renews each place in its own step of six frames; a shift explains a part of it."""
    rng = np.random.default_rng(14)
    y, x = np.mgrid[:96, :128]
    time = np.arange(FRAMES)
    pulse = 4 * rng.standard_normal((6, 96, 128))[time % 6]
    waves = np.sin(2 * np.pi * ((x - 4 * time[:, None, None]) / 24 + np.zeros_like(y)))
    mask = np.abs(y - 48) < 30
    for height, most in ((25, True), (10, False)):
        shown = 90 + height * waves + pulse
        if most:
            with pytest.raises(OnlyShifts, match=r"one shift explains [6-9]\d%"):
                turned_by(shown, mask, 6.0)
        else:
            assert turned_by(shown, mask, 6.0) is None


def turned_by(
    frames: NDArray[np.number], mask: NDArray[np.bool_], period: float
) -> Turning | None:
    shown = np.rint(frames[:, mask]).astype(np.uint8)
    time = FRAME_S * np.arange(FRAMES)
    return turning(PeriodicFit(shown, time, period * FRAME_S, 0.001).coefficients, mask)


@pytest.mark.parametrize("seed", range(3))
def test_a_turn_of_a_part_of_a_frame_more_is_not_taken_for_three_turns(seed: int) -> None:
    """A narrow mark returns better after the three turns that are a whole number of frames."""
    rng = np.random.default_rng(seed)
    turn = 33.63  # frames
    away = 2 * np.pi * np.arange(FRAMES)[:, None] / turn - rng.uniform(0, 2 * np.pi, 40)
    seen = 60 + 120 * np.exp(-((np.angle(np.exp(1j * away)) / 0.12) ** 2))
    seen += 2 * rng.standard_normal(seen.shape)
    returned = image_return(np.rint(seen).astype(np.uint8)[:, :, None], FRAME_S, (1,))
    assert returned is not None
    assert returned.period_s / FRAME_S == pytest.approx(turn, rel=0.005)


@pytest.mark.parametrize(("rpm", "fps", "separated"), [
    (33.3055, 15, False), (45.02, 15, False), (33.3055, 25, False), (33.0, 15, True)])
def test_an_angle_that_leans_to_whole_frames_per_turn_says_so(
    rpm: float, fps: float, *, separated: bool
) -> None:
    """Narrow marks in the same places in every turn: the rate erred by forty of its sds."""
    rng = np.random.default_rng(1)
    time = np.arange(20 * fps) / fps
    turned, marks = 2 * np.pi * rpm / 60 * time, rng.uniform(0, 2 * np.pi, 8)
    light = rng.uniform(20, 80, 8)
    seen = turned[:, None] + rng.uniform(0, 2 * np.pi, 400)  # every pixel in its place
    off = [np.angle(np.exp(1j * (seen - mark))) for mark in marks]
    values = 100 + sum(k * np.exp(-(x / 0.08) ** 4) for k, x in zip(light, off, strict=True))
    values = np.clip(values + 3 * rng.standard_normal(values.shape), 0, 255).astype(np.uint8)
    pixels = PeriodicFit(values, time, 60.03 / rpm, 0.12 / rpm).pixels()
    slope = np.polynomial.Polynomial.fit(time, pixels.angle_rad, 1).convert().coef[1]
    error_frames = (slope * 30 / np.pi / rpm - 1) * len(time)
    if separated:
        assert abs(error_frames) < 0.02
        assert pixels.leaning_frames < 0.03
    else:
        assert 0.02 < abs(error_frames) < 2.5 * pixels.leaning_frames
        assert pixels.leaning_frames < 0.29  # of a frame time, evenly spread


def test_a_light_that_blinks_passes_by_nowhere() -> None:
    """All pixels brighten together: nothing of how they change is left, and nothing explains it."""
    rng = np.random.default_rng(9)
    table = rng.uniform(60, 160, (96, 128))
    blink = 1 + 0.1 * (np.arange(FRAMES) % 37 < 18)
    frames = blink[:, None, None] * table
    mask = np.ones(table.shape, bool)
    frames = np.rint(frames).astype(np.uint8)
    fit = PeriodicFit(frames[:, mask], FRAME_S * np.arange(FRAMES), 37 * FRAME_S, 0.01)
    fit.coefficients[1:] = 0  # as where they do not stand out from noise
    assert turning(fit.coefficients, mask) is None


def test_a_film_without_a_peak_near_its_best_period_does_not_return() -> None:
    """There is no mean of no returns."""
    rng = np.random.default_rng(534)
    turned = 2 * np.pi * np.arange(44) / rng.uniform(16, 24)
    shape = np.stack([np.cos(turned), np.sin(turned), np.cos(3 * turned)], axis=1)
    waves = rng.uniform(0, 1, 3) * shape
    film = waves @ rng.normal(0, 40, (3, 256)) + rng.normal(128, 20, (44, 256))
    small = film.clip(0, 255).astype(np.uint8).reshape(44, 16, 16)
    assert image_return(small, FRAME_S) is None
