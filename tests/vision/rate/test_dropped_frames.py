"""Frames that a recorder dropped without a word, and angles that only look like it."""

import re

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.vision.cut_label import cut_label
from tests.vision.motor_tracks import motor_track
from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import BoolArray
from vision.rate.angle_levels import angle_levels
from vision.rate.dropped_frames import DroppedFrames, confirmed_shares, dropped_frames
from vision.rate.measure import RateMeasurement, measure_rate
from vision.rate.unwrap import continuous_angle, rate_history, rough_rate

RATE = 33.3 * RPM
STEP = RATE / 15  #: from frame to frame


def measured(time: FloatArray, angle: FloatArray, **changes: object) -> RateMeasurement:
    return measure_rate(phase_track(time, angle, noise_rad=NOISE, **changes), timebase=CLOCK)


def judged(
    time: FloatArray, angle: FloatArray, rate: float = RATE, **changes: object
) -> DroppedFrames:
    track = phase_track(time, angle, noise_rad=NOISE, **changes)
    return dropped_frames(continuous_angle(track, track.time_s, rate))


def squeezed(
    time: FloatArray, angle: FloatArray, keep: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """The kept frames, stamped as if none were missing."""
    return time[: keep.sum()], angle[keep]


@pytest.mark.parametrize("shown", [(0.5,), (0.3, 0.7)])
def test_a_jump_that_an_encoder_spreads_over_some_frames_is_counted(
    shown: tuple[float, ...],
) -> None:
    """The frames after the gap show the plate on its way."""
    time, angle = steady(33.3, fps=30)
    gone = np.arange(60, len(time) - 60, 90)
    keep = np.ones(len(time), bool)
    keep[gone] = False
    for later, part in enumerate(shown, start=1):
        angle[gone + later] -= (1 - part) * RATE / 30
    rate = measured(*squeezed(time, angle, keep))
    assert rate.frames.dropped == len(gone)
    assert abs(rate.rate_rad_s / RATE - 1) < 2e-5


def test_some_frames_far_ahead_do_not_make_an_even_plate_unsteady() -> None:
    time, angle = steady(100.7, seconds=15, fps=120)
    angle[140:146] += np.radians([20, 26, 21, 14, 17, 7])
    rate = measured(time, angle)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s / (100.7 * RPM) - 1) < 1e-5
    assert np.ptp(rate_history(rate.history.angle).rate_rad_s) < 1e-3 * rate.rate_rad_s


def test_frames_that_are_mismeasured_do_not_make_an_even_plate_unsteady() -> None:
    """Eleven of these 40 were refused, or measured in a part, or had a change of the rate."""
    told = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        time, angle = steady(20.3, seconds=20.0, fps=10)
        for at in rng.integers(5, 188, 4):
            away = int(rng.integers(2, 7))
            angle[at : at + away] += rng.choice([-1, 1]) * rng.uniform(0.5, 2.2) * 20.3 * RPM / 10
        try:
            told += bool(measured(time, angle).warnings)
        except RateRefused:
            told += 1
    assert told <= 2


def test_two_frames_in_seven_that_are_mismeasured_do_not_make_the_angle_wander() -> None:
    """The clip was refused: by the scatter of all frames they looked like the others."""
    time, angle = steady(78.0, seconds=3.3, fps=25)
    for at, away in ((5, 1.7), (17, -2.0), (29, 1.2), (41, 2.1), (53, -1.5), (65, 1.9)):
        angle[at : at + 4] += away * 78.0 * RPM / 25
    rate = measured(time, angle)
    assert rate.frames.used == len(time) - 24
    assert abs(rate.rate_rad_s - 78.0 * RPM) < 3 * rate.sd_rad_s < 3e-5 * rate.rate_rad_s


def test_small_odds_in_many_frames_of_a_run_up_add_up_to_no_dropped_one() -> None:
    """They did in 13 of 60, within the turns that are steady."""
    counted = 0
    for seed in range(20):
        track = motor_track(np.random.default_rng([seed, 78])).track
        angle = continuous_angle(track, track.time_s, rough_rate(track, track.time_s))
        counted += dropped_frames(angle).count
    assert counted == 0


@pytest.mark.parametrize("over_rad", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("seconds", [20.0, 40.0])
def test_a_label_that_shows_little_at_one_angle_drops_no_frames(
    over_rad: float, seconds: float
) -> None:
    """It jumps by a frame time once per turn; with that time put back it was 3.7 % too slow."""
    time, angle = steady(33.3, seconds=seconds)
    error = cut_label(angle, jump_rad=STEP, over_rad=over_rad, rng=np.random.default_rng(1))
    rate = measured(time, angle + error)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s - RATE) < 3 * rate.uncertainty.image_rad_s
    assert rate.uncertainty.image_rad_s < 1e-3 * RATE


def test_the_jumps_of_a_label_are_said_with_their_plate_angle() -> None:
    time, angle = steady(33.3, seconds=40.0)
    error = cut_label(angle, jump_rad=STEP, over_rad=0.1, at_rad=np.radians(200))
    (text,) = [each for each in measured(time, angle + error).warnings if "jumps" in each]
    assert re.search(r"jumps by 23.2 frame time\(s\) in all, at about 2[01]\d° of", text)
    assert "No frame is missing" in text


@pytest.mark.parametrize("seed", range(8))
def test_dropped_frames_on_such_a_label_are_counted_all_the_same(seed: int) -> None:
    """The error repeats with the plate's angle; the dropped frames do not."""
    rng = np.random.default_rng(seed)
    time, angle = steady(33.3, seconds=40.0, fps=30)
    keep = rng.random(len(time)) > 0.01
    keep[:12] = keep[-12:] = True
    error = cut_label(angle, jump_rad=0.15 * RATE / 30, rng=rng)
    rate = measured(*squeezed(time, angle + error, keep))
    assert rate.frames.dropped == (~keep).sum()
    assert abs(rate.rate_rad_s - RATE) < 4 * rate.uncertainty.image_rad_s


@pytest.mark.parametrize("seconds", [4.0, 12.0, 40.0])
def test_the_angles_confirm_what_was_dropped_and_nothing_else(seconds: float) -> None:
    pulls = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        time, angle = steady(33.3, seconds=seconds, fps=30)
        keep = np.ones(len(time), bool)
        keep[rng.choice(np.arange(12, len(time) - 12, 8), 3, replace=False)] = False
        track = phase_track(*squeezed(time, angle, keep), noise_rad=2e-3, seed=seed)
        stamped = continuous_angle(track, track.time_s, RATE)
        at = angle_levels(stamped).jumps
        share, cov = confirmed_shares(stamped, at, np.ones(len(at)))
        sd = np.sqrt(np.diag(cov))
        pulls += list((share - 1) / sd)
        assert sd.min() < 0.2
        even = phase_track(*steady(33.3, seconds=seconds, fps=30), noise_rad=2e-3, seed=seed)
        angle_of_even = continuous_angle(even, even.time_s, RATE)
        share, cov = confirmed_shares(angle_of_even, at, np.ones(len(at)))
        assert np.abs(share / np.sqrt(np.diag(cov))).max() < 5
    assert np.sqrt(np.mean(np.square(pulls))) < 2


def test_dropping_in_step_with_the_plate_cannot_be_separated_and_is_no_dropped_frame() -> None:
    """One frame each turn of 27, always at the same plate angle."""
    time, angle = steady(33.333, seconds=40.0)
    keep = np.ones(len(time), bool)
    keep[20::27] = False
    found = judged(*squeezed(time, angle, keep))
    assert found.probability.max() < 1e-3


def test_where_neither_can_be_excluded_the_sd_covers_both() -> None:
    """Two turns with a jump in each are too few for a test of their plate angles."""
    time, angle = steady(33.3, seconds=4.0)
    error = cut_label(angle, jump_rad=STEP, over_rad=0.05, at_rad=4.0)
    unsure = judged(time, angle + error).probability
    assert unsure.min() > 0.05
    assert unsure.max() < 0.95
    rate = measured(time, angle + error)
    assert any("cannot determine whether frames were dropped or" in text for text in rate.warnings)
    assert abs(rate.rate_rad_s - RATE) < 2 * rate.uncertainty.image_rad_s
    # Seven jumps at one angle are no chance.
    time, angle = steady(33.3, seconds=12.0)
    error = cut_label(angle, jump_rad=STEP, over_rad=0.05, at_rad=4.0)
    assert judged(time, angle + error).probability.max() < 0.05
    rate = measured(time, angle + error)
    assert abs(rate.rate_rad_s - RATE) < 2 * rate.uncertainty.image_rad_s


@pytest.mark.parametrize("slower", [0.62, 0.8, 0.9])
def test_a_camera_slower_than_its_clip_drops_nothing(slower: float) -> None:
    """Its recorder repeats frames to keep time; with time put back, the plate was 30 % slower."""
    time, _ = steady(33.3, seconds=40.0, fps=30)
    taken = np.floor(time * 30 * slower + 1e-6) / slower / 30
    again = np.diff(taken, prepend=-1) == 0
    rate = measured(time, 0.7 + RATE * taken, duplicate=again)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s / RATE - 1) < 1e-4


def test_a_gap_without_angles_is_no_jump_where_a_view_that_is_off_bends_the_arcs() -> None:
    """A mark that leaves the frame for a third of each turn, and 2° of error at either end."""
    rate_rad_s = 16.69 * RPM
    time = np.arange(378) / 25.0
    true = 0.3 + rate_rad_s * time
    aside = np.angle(np.exp(1j * (true - 4.4)))
    track = phase_track(time, true - 0.0426 * aside, noise_rad=NOISE)  # four frame times a turn
    track.phase_rad[np.abs(aside) > 2.05] = np.nan
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert not any("jumps" in text for text in rate.warnings)
    assert abs(rate.rate_rad_s / rate_rad_s - 1) < 50e-6


def test_other_ways_are_asked_on_the_stamps_though_frames_were_dropped() -> None:
    time, angle = steady(33.3, seconds=40.0)
    keep = np.ones(len(time), bool)
    keep[[100, 240, 241, 420]] = False
    track = phase_track(*squeezed(time, angle, keep), noise_rad=NOISE)
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.dropped == 4
    assert abs(rate.rate_rad_s / RATE - 1) < 1e-5
    count, lag = rate.cross_checks.frame_count, rate.cross_checks.lag
    assert count is not None
    assert lag is not None
    by_stamps = RATE * (1 + 4 / (len(track.time_s) - 1))
    assert abs(count.rate_rad_s - by_stamps) < 2.5 * count.sd_rad_s
    assert lag.rate_rad_s == pytest.approx(by_stamps, rel=0.01)
    assert all("dropped" in text for text in rate.warnings)


def test_silently_dropped_frames_are_counted_exactly_and_repaired() -> None:
    time, angle = steady(33.3)
    keep = np.random.default_rng(2).random(len(time)) > 0.02
    keep[0] = True
    squeezed = time[: keep.sum()]
    rate = measure_rate(phase_track(squeezed, angle[keep], noise_rad=NOISE), timebase=CLOCK)
    last = np.flatnonzero(keep)[-1]
    assert rate.frames.dropped == last + 1 - keep[: last + 1].sum()
    assert abs(rate.rate_rad_s / (33.3 * RPM) - 1) < 5e-6
    assert rate.diagnosis.name == "frame_steps"
    assert any("dropped" in text for text in rate.warnings)


def test_a_wander_that_dropped_frames_could_have_made_is_refused() -> None:
    """As where an encoder blurs the small jumps of a fast camera."""
    time, angle = steady(16.67, seconds=20, fps=240)
    wander = lfilter([1], [1, -0.99], np.random.default_rng(3).standard_normal(len(time)))
    wander *= np.radians(0.3) / wander.std()
    with pytest.raises(RateRefused, match=r"wanders by 0\.\d\d° .* cannot determine whether"):
        measure_rate(phase_track(time, angle + wander, noise_rad=NOISE), timebase=CLOCK)


def test_a_mark_that_is_taken_for_the_other_one_does_not_double_the_rate() -> None:
    """Where two equal marks pass the visible half of a plate, each for half a turn."""
    time, angle = steady(10.0, seconds=14, fps=30)
    track = phase_track(time, -1.04 * np.mod(angle, np.pi), noise_rad=NOISE)
    with pytest.raises(RateRefused, match=r"at 10\.4 rpm, and at 18\.\d rpm in all.*for another"):
        measure_rate(track, timebase=CLOCK)


def test_a_scatter_that_would_hide_dropped_frames_is_said() -> None:
    time, angle = steady(16.67, seconds=20, fps=240)
    rate = measure_rate(phase_track(time, angle, noise_rad=5e-3), timebase=CLOCK)
    assert any("would not be noticed" in text for text in rate.warnings)
    assert abs(rate.rate_rad_s / (16.67 * RPM) - 1) < 3 * rate.sd_rad_s / rate.rate_rad_s
