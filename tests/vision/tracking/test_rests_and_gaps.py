"""Plates that rest, stop or turn back, and frames that are missing: told, never smoothed over."""

import numpy as np
import pytest

from tests.chance import spread_bounds
from tests.vision.phase_tracks import CLOCK, NOISE, RPM, FloatArray, phase_track, steady
from vision.errors import RateRefused
from vision.phase_track import PhaseTrack
from vision.rate.measure import measure_rate
from vision.rate.steady_part import ClipPart

FAST = 33.3 * RPM


def driven(
    *,
    start_s: float = 0.0,
    stop_s: float = np.inf,
    then: float = 0.0,
    ramp_s: float = 1.5,
    seconds: float = 25.0,
) -> tuple[PhaseTrack, FloatArray]:
    """Track of a plate that turns from one time to another, with ramps, then at another rate."""
    fine = np.arange(0, seconds, 1e-3)
    rise = np.clip((fine - start_s) / ramp_s, 0, 1) if start_s else np.ones_like(fine)
    rate = FAST * (rise + (then - 1) * np.clip((fine - stop_s) / ramp_s, 0, 1))
    time = np.arange(round(seconds * 15)) / 15
    angle = 0.7 + np.interp(time, fine, np.concatenate([[0], np.cumsum(rate[:-1]) * 1e-3]))
    alike = np.abs(np.diff(angle, prepend=-9)) < 0.2 * FAST / 15
    return phase_track(time, angle, noise_rad=NOISE, duplicate=alike), angle


@pytest.mark.parametrize(
    ("how", "verdict"),
    [
        ({"start_s": 4.0}, "still running up"),
        ({"stop_s": 16.0}, "slows down"),
        ({"stop_s": 12.0, "then": -1.0}, "changes its direction"),
    ],
)
def test_a_plate_that_rests_or_turns_back_is_refused_with_its_true_history(
    how: dict[str, float], verdict: str
) -> None:
    """At rest the frames repeat; left out, turns were made up for the time between."""
    track, angle = driven(**how)
    with pytest.raises(RateRefused, match=rf"{verdict}.*measure one such part") as refused:
        measure_rate(track, timebase=CLOCK, part=ClipPart(0.0))
    history = refused.value.history
    assert history is not None
    assert history.revolutions == pytest.approx(abs(angle[-1] - angle[0]) / (2 * np.pi), abs=0.02)
    true = np.interp(history.time_s, track.time_s, np.gradient(angle, track.time_s))
    settled = np.abs(np.abs(true) - FAST) < 1e-6 * FAST
    off = np.abs(history.rate_rad_s - true)
    assert np.quantile(off[settled], 0.8) < 2e-3 * FAST
    if "then" not in how:
        assert np.abs(history.rate_rad_s).min() < 0.01 * FAST


@pytest.mark.parametrize("how", [{"start_s": 4.0}, {"stop_s": 16.0}])
def test_between_its_start_and_its_stop_a_plate_is_measured(how: dict[str, float]) -> None:
    track, _ = driven(**how)
    rate = measure_rate(track, timebase=CLOCK)
    assert "turns steadily from" in rate.warnings[0]
    assert abs(rate.rate_rad_s - FAST) < 3 * rate.sd_rad_s < 1e-4 * FAST


def test_frames_delivered_again_are_still_left_out() -> None:
    time, angle = steady(33.3)
    again = np.zeros(len(time), bool)
    again[50::20] = again[51::20] = again[52::20] = True
    held = angle.copy()
    for i in np.flatnonzero(again):
        held[i] = held[i - 1]
    rate = measure_rate(
        phase_track(time, held, noise_rad=NOISE, duplicate=again), timebase=CLOCK
    )
    assert rate.frames.used == (~again).sum()
    assert abs(rate.rate_rad_s / FAST - 1) < 5e-6


@pytest.mark.parametrize("seconds", [60.0, 59.9])  # with an even number of steps, and an odd one
@pytest.mark.parametrize("camera_fps", [12.0, 10.0, 7.5])
def test_a_camera_slower_than_its_clip_gives_its_rate_all_the_same(
    camera_fps: float, seconds: float
) -> None:
    """The recorder shows frames twice to keep time; taken out, the plate was 25 % too fast."""
    time, _ = steady(33.3, seconds=seconds)
    taken = np.floor(time * camera_fps + 1e-6) / camera_fps
    angle = 0.7 + FAST * taken
    again = np.diff(taken, prepend=-1) == 0
    for seen in (again, np.zeros_like(again)):  # with repeats that were noticed, or not
        rate = measure_rate(
            phase_track(time, angle, noise_rad=NOISE, duplicate=seen), timebase=CLOCK
        )
        assert rate.frames.dropped == 0
        assert abs(rate.rate_rad_s - FAST) < 3 * rate.sd_rad_s
        assert rate.sd_rad_s < 3e-4 * FAST


def test_frames_are_counted_between_alignments_that_were_seen() -> None:
    """Where frames were left out, the nearest frame is not that of the alignment."""
    time, angle = steady(33.3, seconds=20.0, start_rad=0.0)
    hidden = np.cos(angle + 1.0) > 0.6  # the mark passes the fixed one unseen
    hidden &= time < 12
    track = phase_track(time, angle, noise_rad=NOISE, quality=np.where(hidden, 0.1, 0.99))
    rate = measure_rate(track, timebase=CLOCK)
    count = rate.cross_checks.frame_count
    assert count is not None
    assert abs(count.rate_rad_s - FAST) < 2.5 * count.sd_rad_s
    assert rate.warnings == ()


@pytest.mark.parametrize("rpm", [33.21, 44.83])
def test_a_mark_returns_within_the_sd_of_its_return(rpm: float) -> None:
    """Light that changes hides all but the first returns, and these are read off by a parabola."""
    time, angle = steady(rpm, seconds=20.0)
    across = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    away = np.angle(np.exp(1j * (angle[:, None] - across)))
    gain = np.where(time < 9, 1.0, 0.55)[:, None]
    still = 90 + 60 * np.sin(1.7 * across)
    seen = gain * (still + 100 * np.exp(-0.5 * (away / 0.2) ** 2))
    track = phase_track(time, angle, noise_rad=NOISE, thumbnail=np.rint(seen).astype(np.uint8))
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.cross_checks.lag is not None
    lag = rate.cross_checks.lag
    assert abs(lag.rate_rad_s / (rpm * RPM) - 1) < 3 * lag.sd_s / lag.period_s
    assert rate.warnings == ()


@pytest.mark.parametrize("rpm", [16.71, 33.3, 78.26])
def test_stamps_that_come_early_or_late_are_no_change_of_the_rate(rpm: float) -> None:
    """As of a webcam whose driver stamps the frames when it gets to it."""
    pulls = []
    for seed in range(12):
        time, angle = steady(rpm, seconds=40.0)
        late = np.random.default_rng(seed).normal(0, 6e-3, len(time)).clip(-0.02, 0.02)
        rate = measure_rate(phase_track(time + late, angle, noise_rad=NOISE), timebase=CLOCK)
        assert rate.frames.dropped == 0
        assert not any("changes by" in text for text in rate.warnings)
        pulls.append((rate.rate_rad_s / (rpm * RPM) - 1) * rate.rate_rad_s / rate.sd_rad_s)
    low, high = spread_bounds(len(pulls))
    assert low < np.sqrt(np.mean(np.square(pulls))) < high


def test_a_change_of_the_rate_shows_through_stamps_that_come_early_or_late() -> None:
    time, _ = steady(seconds=40.0)
    angle = FAST * (time - 0.02 * np.maximum(time - 20, 0))
    late = np.random.default_rng(0).normal(0, 6e-3, len(time)).clip(-0.02, 0.02)
    with pytest.raises(RateRefused, match="does not turn steadily"):
        measure_rate(phase_track(time + late, angle, noise_rad=NOISE), timebase=CLOCK)


@pytest.mark.parametrize("fps", [15.0, 30.0])
def test_stamps_in_whole_milliseconds_are_as_good_as_exact_ones(fps: float) -> None:
    """As Matroska and WebM have them: the median step is 0.067 s, and 15 of them are no second."""
    time, angle = steady(33.3, fps=fps)
    kept = np.random.default_rng(1).random(len(time)) > 0.02
    kept[0] = True
    stamps = np.round(time, 3)
    whole = measure_rate(phase_track(stamps, angle, noise_rad=NOISE), timebase=CLOCK)
    assert whole.cross_checks.lag is not None
    assert abs(whole.cross_checks.lag.rate_rad_s / FAST - 1) < 2e-4
    assert whole.warnings == ()
    lossy = phase_track(stamps[: kept.sum()], angle[kept], noise_rad=NOISE)
    rate = measure_rate(lossy, timebase=CLOCK)
    assert rate.frames.dropped > 10
    assert abs(rate.rate_rad_s / FAST - 1) < 10e-6


def test_one_return_of_the_frame_is_no_second_opinion() -> None:
    time, angle = steady(33.3, seconds=3.7)  # two turns, the second cut short
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    assert rate.cross_checks.lag is None


def test_stamps_in_bursts_do_not_make_the_plate_a_hundred_times_as_fast() -> None:
    """Two frames come from the camera at once; most steps between stamps are 2 ms."""
    time, angle = steady(33.3, fps=30.0, seconds=20.0)
    burst = time.copy()
    burst[1::2] = time[::2] + 2e-3
    rate = measure_rate(phase_track(burst, angle, noise_rad=NOISE), timebase=CLOCK)
    assert abs(rate.rate_rad_s - FAST) < 3 * rate.sd_rad_s
    assert rate.sd_rad_s < 1e-3 * FAST
