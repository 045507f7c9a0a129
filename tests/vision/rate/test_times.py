"""Times that are wrong in two ways at once: of the recorder, the clock, the camera, the plate."""

from collections import Counter

import numpy as np
import pytest

from tests.vision.cut_label import cut_label
from tests.vision.mixed_tracks import mixed_track, verdict
from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.geometry import FloatArray
from vision.rate.angle_levels import angle_levels
from vision.rate.measure import RateMeasurement, measure_rate
from vision.rate.unwrap import continuous_angle

RATE = 33.3 * RPM


def measured(time: FloatArray, angle: FloatArray, **changes: object) -> RateMeasurement:
    return measure_rate(phase_track(time, angle, noise_rad=NOISE, **changes), timebase=CLOCK)


def off(rate: RateMeasurement) -> float:
    return (rate.rate_rad_s - RATE) / rate.sd_rad_s


@pytest.mark.parametrize("frames", [0.4, 1.5, -2.3])
def test_a_step_of_the_clock_is_no_dropped_frame(frames: float) -> None:
    """The nearest whole number of frames was put back, and the rate was 4 sds off."""
    time, _ = steady(33.3, seconds=20, fps=30)
    past = time > 8
    stands = max(frames, 0) / 30
    stamp = time + (stands - frames / 30) * past
    rate = measured(stamp, RATE * (time + stands * past))
    assert rate.frames.dropped == 0
    assert abs(off(rate)) < 3
    assert rate.sd_rad_s < 3e-5 * RATE
    (text,) = rate.warnings
    assert f"steps by {-1e3 * frames / 30:+.0f} ms at {stamp[past][0]:.1f} s" in text


@pytest.mark.parametrize("seed", range(4))
def test_frames_that_a_slow_camera_lost_are_counted_by_its_own_frames(seed: int) -> None:
    """Where the recorder drops a frame that it would have repeated, the angle shows nothing."""
    rng = np.random.default_rng([seed, 5])
    time, _ = steady(33.3, seconds=25, fps=30)
    camera_s = 1 / (30 * rng.uniform(0.6, 0.95))
    number = np.floor(time / camera_s + rng.random())
    kept = rng.random(len(time)) > 0.008
    kept[[0, -1]] = True
    again = np.diff(number[kept], prepend=-1) == 0
    rate = measured(time[: kept.sum()], RATE * camera_s * number[kept], duplicate=again)
    assert rate.frames.dropped == np.sum(np.diff(number[kept]) > 1)
    assert abs(off(rate)) < 3
    assert "the camera took" in rate.warnings[0]


@pytest.mark.parametrize("seed", range(4))
def test_frames_are_dropped_and_a_label_jumps_in_one_clip(seed: int) -> None:
    """Either all jumps were dropped frames or none was."""
    rng = np.random.default_rng(seed)
    time, angle = steady(33.3, seconds=40.0, fps=30)
    kept = np.ones(len(time), bool)
    apart = np.cos(angle[60:-60:9] - 3.4) < 0.5
    kept[rng.choice(np.arange(60, len(time) - 60, 9)[apart], 4, replace=False)] = False
    error = cut_label(angle, jump_rad=0.6 * RATE / 30, over_rad=0.1, rng=rng)
    rate = measured(time[: kept.sum()], (angle + error)[kept])
    assert rate.frames.dropped == 4
    assert abs(off(rate)) < 4


def test_dropped_frames_are_seen_in_noise_of_a_fifth_of_a_frame_time() -> None:
    """Where a single step does not show them, the frames before and after it do."""
    time, angle = steady(16.7, seconds=20, fps=24)
    kept = np.ones(len(time), bool)
    kept[[100, 300, 301]] = False
    track = phase_track(time[: kept.sum()], angle[kept], noise_rad=0.2 * 16.7 * RPM / 24)
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.frames.dropped == 3
    assert abs(rate.rate_rad_s / (16.7 * RPM) - 1) < 3 * rate.sd_rad_s / rate.rate_rad_s


def test_angles_are_more_probable_at_their_own_times() -> None:
    time, angle = steady(33.3, seconds=20, fps=30)
    late = time + np.random.default_rng(0).uniform(0, 0.5 / 30, len(time))
    ours, others = (
        angle_levels(continuous_angle(phase_track(each, angle, noise_rad=NOISE), each, RATE))
        for each in (time, late - late[0])
    )
    assert ours.log_probability > others.log_probability + len(time)
    assert len(ours.jumps) == 0


def test_two_defects_at_once_are_measured_or_told() -> None:
    """Tracks of which 4 could be measured and were refused, and 3 were beyond four sds."""
    count = Counter(verdict(mixed_track((20, i)))[0] for i in range(50))
    assert count["beyond, unsaid"] == count["unsteady, unsaid"] == 0
    assert count["within 2"] + count["unsteady, said"] > 47
