"""Rates that the frames cannot tell apart are listed, and what chooses among them is named."""

import numpy as np
import pytest

from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.errors import RateRefused
from vision.rate.measure import measure_rate
from vision.rate.unwrap import stamped_in_pairs


def test_the_alias_set_is_listed_and_the_nominal_rate_chooses() -> None:
    time, angle = steady(600.0)
    track = phase_track(time, angle, noise_rad=NOISE)
    with pytest.raises(RateRefused, match=r"may turn at 300, 600, .*no record player turns as"):
        measure_rate(track, timebase=CLOCK)
    told = measure_rate(track, timebase=CLOCK, nominal_rpm=600)
    assert told.direction == "ccw"
    assert told.rate_rad_s == pytest.approx(600 * RPM, rel=1e-5)
    assert "nominal" in told.aliases.reason
    others = told.aliases.rates_rad_s[1:]
    assert -300 * RPM in [pytest.approx(alias, rel=1e-5) for alias in others]


def test_uneven_stamps_exclude_the_aliases() -> None:
    time, _ = steady(600.0)
    time = time + np.random.default_rng(0).uniform(-0.01, 0.01, len(time))
    track = phase_track(time - time[0], 600 * RPM * time, noise_rad=NOISE)
    # The smallest alias does not fit these stamps, so it is not offered.
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.rate_rad_s == pytest.approx(600 * RPM, rel=1e-4)


@pytest.mark.parametrize(("rpm", "fps", "late_s"), [(-78.26, 15.0, 2e-3), (-47.7, 12.0, 0.02049),
                                                    (26.6, 30.0, 0.01082), (25.0, 15.0, 0.02209)])
def test_stamps_in_pairs_exclude_no_rate(rpm: float, fps: float, late_s: float) -> None:
    """Two frames at once: an alias fitted such stamps better, and the plate was at 2778 rpm."""
    time, angle = steady(rpm, fps=fps, seconds=12.0)
    pairs = time.copy()
    pairs[1::2] = time[::2] + late_s
    rate = measure_rate(phase_track(np.round(pairs, 3), angle, noise_rad=NOISE), timebase=CLOCK)
    assert abs(rate.rate_rad_s - abs(rpm) * RPM) < 3 * rate.sd_rad_s
    assert len(rate.aliases.rates_rad_s) > 1


def test_frames_of_which_every_third_is_lost_are_not_stamped_in_pairs() -> None:
    time, angle = steady(33.3, fps=30.0, seconds=20.0)
    there = np.arange(len(time)) % 3 != 2
    track = phase_track(time[there], angle[there], noise_rad=NOISE)
    assert not stamped_in_pairs(track, time[there])
    even = phase_track(time[: there.sum()], angle[: there.sum()], noise_rad=NOISE)
    assert stamped_in_pairs(even, time[there])


def test_a_plate_with_two_equal_marks_is_followed_over_whole_turns() -> None:
    time, angle = steady(33.3)
    ambiguous = np.mod(angle, np.pi)  # what a two-fold symmetric image determines
    track = phase_track(time, ambiguous, symmetry=2, mark_azimuth_rad=np.nan)
    rate = measure_rate(track, timebase=CLOCK, nominal_rpm=33)
    assert rate.rate_rad_s == pytest.approx(33.3 * RPM, rel=1e-6)


@pytest.mark.parametrize(("symmetry", "fps", "doubtful"), [(1, 15, False), (3, 30, True),
                                                            (1, 1, True)])
def test_of_rates_among_which_nothing_chooses_none_is_stated(
    symmetry: int, fps: float, doubtful: bool
) -> None:
    """Three blades at 1237 rpm, or a plate at one frame per second, look like a slow plate."""
    rpm = {15: 33.3, 30: 1237.0, 1: 33.3}[fps]
    time, angle = steady(rpm, fps=fps, seconds=10.0 if fps > 1 else 60.0)
    track = phase_track(time, np.mod(angle, 2 * np.pi / symmetry), symmetry=symmetry,
                        mark_azimuth_rad=np.nan)
    if doubtful:
        with pytest.raises(RateRefused, match="gives the same frames at each"):
            measure_rate(track, timebase=CLOCK)
    else:
        assert "no record player" in measure_rate(track, timebase=CLOCK).aliases.reason
    told = measure_rate(track, timebase=CLOCK, nominal_rpm=round(rpm))
    assert told.rate_rad_s == pytest.approx(rpm * RPM, rel=1e-4)


def test_locked_frame_counts_keep_their_frame_of_uncertainty() -> None:
    time, angle = steady(33.333 * 1.0005)  # 27 frames per turn, all counts equal
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    count = rate.cross_checks.frame_count
    assert count is not None
    assert count.rate_rad_s == pytest.approx(2 * np.pi * 15 / 27, rel=1e-12)
    frames = 27 * (int(rate.revolutions) - 1)
    assert count.sd_rad_s == pytest.approx(count.rate_rad_s / np.sqrt(6) / frames, rel=0.04)
    assert abs(count.rate_rad_s - rate.rate_rad_s) < 2.5 * count.sd_rad_s


def test_a_plate_of_many_parts_turns_once_per_return_of_its_label() -> None:
    """Strobe dots alone leave the smallest rate; print on the label returns after a turn."""
    rpm, parts = 17.3, 90
    time, angle = steady(rpm, fps=25, seconds=20.0)
    dots = np.mod(angle, 2 * np.pi / parts)
    label = phase_track(time, angle).thumbnail
    track = phase_track(time, dots, symmetry=parts, mark_azimuth_rad=np.nan, thumbnail=label)
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.rate_rad_s == pytest.approx(rpm * RPM, rel=1e-5)
    assert "picture returns" in rate.aliases.reason
    told = measure_rate(track, timebase=CLOCK, nominal_rpm=round(rpm))
    assert told.rate_rad_s == pytest.approx(rate.rate_rad_s, rel=1e-9)
