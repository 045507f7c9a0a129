"""From phase tracks to rates: known answers, honest uncertainty, refusals. No frames."""

import re
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest

from tests.chance import spread_bounds
from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.rate.least_squares import correlation_time, least_squares
from vision.rate.measure import measure_rate
from vision.rate.steady_part import ClipPart
from vision.rate.timebase import Timebase


def test_measuring_a_rate_does_not_load_opencv_or_scipy() -> None:
    code = "import sys, vision.rate.measure; sys.exit(bool({'cv2', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("rpm", [16.667, -33.333, 45.0, -78.26])
def test_rate_and_direction_are_those_of_the_plate(rpm: float) -> None:
    time, angle = steady(rpm)
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    assert rate.direction == ("ccw" if rpm > 0 else "cw")
    assert abs(rate.rate_rad_s - abs(rpm) * RPM) < 4 * rate.sd_rad_s
    assert rate.sd_rad_s / rate.rate_rad_s < 3e-6


def test_a_large_wave_of_a_plate_seen_in_arcs_does_not_bend_the_line() -> None:
    """A mark that leaves the frame, a view that is off by 5°: the waves are placed by the line."""
    rate_rad_s = 16.72 * RPM
    time = np.arange(377) / 25.0
    true = rate_rad_s * time
    angle = true + np.radians(5) * np.sin(true) + NOISE * np.random.default_rng(2).normal(size=377)
    angle[np.cos(true - 2.4) > 0.5] = np.nan
    track = phase_track(time, np.nan_to_num(angle))
    track.phase_rad[np.isnan(angle)] = np.nan
    rate = measure_rate(track, timebase=CLOCK)
    assert abs(rate.rate_rad_s / rate_rad_s - 1) < 15e-6
    assert abs(rate.rate_rad_s - rate_rad_s) < 3 * rate.sd_rad_s


def test_an_off_centre_view_does_not_make_a_steady_plate_unsteady() -> None:
    """Unequal halves of a turn, of a plate cut by an edge: the time of a turn is that of both."""
    time = np.arange(600) / 30.0
    true = 44.6 * RPM * time
    rate = measure_rate(
        phase_track(time, true + 0.16 * np.cos(true), noise_rad=NOISE), timebase=CLOCK)
    assert abs(rate.rate_rad_s / (44.6 * RPM) - 1) < 15e-6
    assert np.ptp(rate.history.rate_rad_s) < 1e-3 * rate.rate_rad_s


@pytest.mark.parametrize("correlation", [0.0, 0.7])
def test_the_stated_sd_is_that_of_repeated_measurements(correlation: float) -> None:
    time, angle = steady(16.9)
    pulls = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        noise = NOISE * rng.standard_normal(len(time) + 50)
        for i in range(1, len(noise)):
            noise[i] += correlation * noise[i - 1]
        rate = measure_rate(phase_track(time, angle + noise[50:]), timebase=CLOCK)
        pulls.append((rate.rate_rad_s - 16.9 * RPM) / rate.sd_rad_s)
    low, high = spread_bounds(len(pulls) - 1)
    assert low < np.std(pulls, ddof=1) < high
    assert abs(np.mean(pulls)) < 4 / np.sqrt(len(pulls))


def test_correlation_time_of_an_autoregression_is_that_of_theory() -> None:
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(20_000)
    for i in range(1, len(noise)):
        noise[i] += 0.6 * noise[i - 1]
    assert correlation_time(noise) == pytest.approx((1 + 0.6) / (1 - 0.6), rel=0.15)
    assert correlation_time(rng.standard_normal(20_000)) == pytest.approx(1.0, abs=0.1)


def test_dependent_columns_are_an_error_not_an_answer() -> None:
    x = np.stack([np.ones(50), np.arange(50.0), 2 * np.arange(50.0)], axis=1)
    with pytest.raises(np.linalg.LinAlgError, match="dependent"):
        least_squares(x, np.arange(50.0))


def test_a_wave_once_per_turn_does_not_bias_the_rate_of_a_partial_turn() -> None:
    time, angle = steady(16.667, seconds=15.0)  # 4.2 turns
    rate = measure_rate(
        phase_track(time, angle + 0.02 * np.cos(angle - 0.7), noise_rad=NOISE), timebase=CLOCK
    )
    assert abs(rate.rate_rad_s / (16.667 * RPM) - 1) < 20e-6
    plain = np.polyfit(time, angle + 0.02 * np.cos(angle - 0.7), 1)[0]
    assert abs(plain / (16.667 * RPM) - 1) > 100e-6  # what the line alone would have said


def test_a_film_whose_encoder_changes_its_prediction_keeps_its_rate() -> None:
    """Runs of frames predicted from the one before lag; others do not."""
    time, angle = steady(16.9)
    coding = np.tile(np.frombuffer(b"BBBP", np.uint8), len(time) // 4)
    coding[600:] = ord("P")
    lagging = angle - 1.5e-3 * (np.arange(len(time)) > 600)
    pulls = []
    for seed in range(20):
        track = phase_track(time, lagging, noise_rad=NOISE, seed=seed, coding=coding)
        rate = measure_rate(track, timebase=CLOCK)
        pulls.append((rate.rate_rad_s - 16.9 * RPM) / rate.sd_rad_s)
        assert rate.diagnosis.verdict == "nothing_missing"
    low, high = spread_bounds(len(pulls) - 1)
    assert low < np.std(pulls, ddof=1) < high
    assert abs(np.mean(pulls)) < 4 / np.sqrt(len(pulls))
    untold = measure_rate(phase_track(time, lagging, noise_rad=NOISE), timebase=CLOCK)
    assert abs(untold.rate_rad_s / (16.9 * RPM) - 1) > 10e-6


def test_a_film_of_one_kind_of_prediction_has_no_lag_to_fit() -> None:
    time, angle = steady(16.9)
    for letters in (b"P", b"I", b"?"):
        coding = np.full(len(time), letters[0], np.uint8)
        one = measure_rate(phase_track(time, angle, noise_rad=NOISE, coding=coding), timebase=CLOCK)
        both = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
        assert one.rate_rad_s == pytest.approx(both.rate_rad_s, rel=1e-9)
        assert one.sd_rad_s == pytest.approx(both.sd_rad_s, rel=1e-3)


def test_the_time_base_enters_the_sd_and_nothing_else() -> None:
    time, angle = steady()
    track = phase_track(time, angle, noise_rad=NOISE)
    with_clock = measure_rate(track, timebase=Timebase(ppm=100.0))
    without = measure_rate(track, timebase=CLOCK)
    assert with_clock.rate_rad_s == without.rate_rad_s
    assert with_clock.uncertainty.timebase_rad_s == pytest.approx(1e-4 * without.rate_rad_s)
    assert with_clock.sd_rad_s == pytest.approx(
        np.hypot(without.uncertainty.image_rad_s, with_clock.uncertainty.timebase_rad_s)
    )


def test_a_constant_frame_rate_replaces_the_stamps() -> None:
    time, angle = steady(33.3, fps=29.97)
    track = phase_track(time * 29.97 / 240, angle, noise_rad=NOISE)
    rate = measure_rate(track, timebase=Timebase(source="constant", fps=29.97, ppm=0.0))
    assert rate.rate_rad_s == pytest.approx(33.3 * RPM, rel=1e-5)


def test_a_retimed_clip_is_recognised_by_the_nominal_rate() -> None:
    time, angle = steady(33.3, seconds=30, fps=240)
    track = phase_track(time * 240 / 29.97, angle, noise_rad=NOISE)
    rate = measure_rate(track, timebase=CLOCK, nominal_rpm=33.333)
    assert any("240" in text and "29.97" in text for text in rate.warnings)


def test_stamps_that_stand_still_are_refused() -> None:
    time, angle = steady()
    with pytest.raises(RateRefused, match=r"time stamps.*constant"):
        measure_rate(phase_track(np.zeros_like(time), angle), timebase=CLOCK)
    with pytest.raises(RateRefused, match="90000"):
        measure_rate(phase_track(np.arange(len(time)) / 90_000, angle), timebase=CLOCK)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (lambda t: 3.49 * t - 0.01 * t**2, "does not turn steadily"),
        (lambda t: 3.49 * 20 * (1 - np.exp(-t / 20)), "slows down"),
        (lambda t: 3.49 * (t + 15 * (np.exp(-t / 15) - 1)), "still running up"),
    ],
)
def test_a_rate_that_is_not_constant_is_refused_with_its_history(
    how: Callable[[FloatArray], FloatArray], words: str
) -> None:
    time, _ = steady(seconds=60)
    with pytest.raises(RateRefused, match=words) as refused:
        measure_rate(phase_track(time, how(time), noise_rad=NOISE), timebase=CLOCK)
    history = refused.value.history
    assert history is not None
    slope = np.gradient(how(time), time)
    middle = slice(1, -1)
    expected = np.interp(history.time_s, time, slope)
    assert history.rate_rad_s[middle] == pytest.approx(expected[middle], rel=0.05)
    assert history.revolutions == pytest.approx(np.ptp(how(time)) / (2 * np.pi), abs=0.01)
    first, last = history.rate_rad_s[[0, -1]] / RPM
    assert f"from {first:.2f} to {last:.2f} rpm" in str(refused.value)


@pytest.mark.parametrize("way", ["too little", "unsteadily"])
def test_what_turning_hardly_explains_is_not_called_the_plate(way: str) -> None:
    """Someone who walks by turns, for a template, by some angle; the share is stated."""
    time, _ = steady(seconds=10)
    turned = 0.1 * time if way == "too little" else 2.0 * time - 0.05 * time**2
    for share, is_plate in ((0.24, False), (0.8, True)):
        track = phase_track(time, turned, noise_rad=NOISE, explained=share)
        with pytest.raises(RateRefused) as refused:
            measure_rate(track, timebase=CLOCK)
        does = "makes" if way == "too little" else "does not turn steadily"
        assert (f"taken for the plate {does}" in str(refused.value)) == is_plate
        assert (f"rotation explains 24% alone, {does}" in str(refused.value)) != is_plate
        assert ("film for a minute" in str(refused.value)) == (is_plate and way == "too little")


def test_of_a_clip_with_a_run_up_the_steady_part_is_measured_and_named() -> None:
    time, _ = steady(seconds=60)
    track = phase_track(time, 3.49 * (time + 1.5 * (np.exp(-time / 1.5) - 1)), noise_rad=NOISE)
    rate = measure_rate(track, timebase=CLOCK)
    assert re.search(r"steadily from \d+\.\d s to 5\d\.\d s of 59\.9 s", rate.warnings[0])
    assert abs(rate.rate_rad_s / 3.49 - 1) < 10e-6
    with pytest.raises(RateRefused, match=r"steady from \d+\.\d s to 5\d\.\d s \(\+33"):
        measure_rate(track, timebase=CLOCK, part=ClipPart(0.0))
    chosen = measure_rate(track, timebase=CLOCK, part=ClipPart(20.0, 50.0))
    assert chosen.warnings == ()
    assert chosen.history.angle.time_s[[0, -1]] == pytest.approx([20.0, 50.0])
    with pytest.raises(RateRefused, match="a part within the clip"):
        measure_rate(track, timebase=CLOCK, part=ClipPart(70.0))


def test_two_steady_parts_of_different_rates_are_both_named_and_none_is_chosen() -> None:
    time, _ = steady(seconds=40)
    angle = 3.49 * time + 1.22 * np.maximum(time - 20, 0)
    with pytest.raises(RateRefused, match=r"\+33\.33 rpm\) and from .*\+44\.98 rpm"):
        measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)


def test_a_plate_that_coasts_has_no_steady_part() -> None:
    """Over some turns its rate changes by less than a belt's."""
    time, _ = steady(seconds=40)
    angle = 3.49 * 100 * (1 - np.exp(-time / 100))
    with pytest.raises(RateRefused, match="Let the plate settle"):
        measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)


def test_less_than_a_turn_is_refused() -> None:
    time, angle = steady(16.667, seconds=3)
    with pytest.raises(RateRefused, match=r"0\.8\d of a turn"):
        measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    swing = 1.26 * np.sin(2 * np.pi * time / 2.3)  # it ends near where it began
    with pytest.raises(RateRefused, match=r"to and fro within 0\.40 of a turn.*Let it turn"):
        measure_rate(phase_track(time, swing, noise_rad=NOISE), timebase=CLOCK)


def test_frames_dropped_with_true_stamps_cost_no_accuracy() -> None:
    time, angle = steady(78.26)
    keep = np.random.default_rng(1).random(len(time)) > 0.3
    rate = measure_rate(phase_track(time[keep], angle[keep], noise_rad=NOISE), timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert abs(rate.rate_rad_s / (78.26 * RPM) - 1) < 5e-6


def test_stamps_that_come_late_by_milliseconds_are_named_with_what_else_scatters() -> None:
    time, angle = steady(78.26)
    late = time + 3e-3 * np.random.default_rng(5).standard_normal(len(time))
    rate = measure_rate(phase_track(late, angle, noise_rad=NOISE), timebase=CLOCK)
    assert abs(rate.rate_rad_s / (78.26 * RPM) - 1) < 3 * rate.sd_rad_s / rate.rate_rad_s
    (said,) = [text for text in rate.warnings if "scatters" in text]
    assert "by 1.4°" in said
    assert "late by 3 ms" in said
    in_time = measure_rate(phase_track(time, angle, noise_rad=NOISE), timebase=CLOCK)
    assert not any("scatters" in text for text in in_time.warnings)


def test_a_kind_of_frame_that_is_mismeasured_throughout_has_no_lag_of_its_own() -> None:
    time, angle = steady(33.3)
    coding = np.full(len(time), ord("I"), np.uint8)
    key = np.arange(60, len(time), 150)
    coding[key] = ord("P")
    angle[key] += np.tile([0.05, -0.05], len(key))[: len(key)]
    rate = measure_rate(phase_track(time, angle, noise_rad=NOISE, coding=coding), timebase=CLOCK)
    assert not rate.fit.used[key].any()
    assert abs(rate.rate_rad_s / (33.3 * RPM) - 1) < 5e-6


@pytest.mark.parametrize("frame_times", [(1.0,), (-0.75,), (-1.0, -0.98), (2.0, 0.5, 0.2)])
def test_frames_that_are_mismeasured_are_no_dropped_ones(
    frame_times: tuple[float, ...],
) -> None:
    """The angle leaves its line by whole frame times, and comes back at once or bit by bit."""
    time, angle = steady(33.3)
    bent = angle.copy()
    bent[400 : 400 + len(frame_times)] += 33.3 * RPM / 15 * np.array(frame_times)
    rate = measure_rate(phase_track(time, bent, noise_rad=NOISE), timebase=CLOCK)
    assert rate.frames.dropped == 0
    assert not rate.fit.used[400]
    assert abs(rate.rate_rad_s / (33.3 * RPM) - 1) < 5e-6


def test_a_return_that_is_none_of_the_plate_says_nothing() -> None:
    """The picture of one plate told two in 39 of 2000 tracks; frames show a label that slips."""
    time, angle = steady(33.3)
    other = phase_track(*steady(33.3 * 1.02))
    track = phase_track(time, angle, noise_rad=NOISE, thumbnail=other.thumbnail)
    rate = measure_rate(track, timebase=CLOCK)
    assert rate.cross_checks.lag is None
    assert rate.warnings == ()


def test_a_term_that_does_not_exist_is_named() -> None:
    with pytest.raises(ValueError, match="no term is named 'wobble'"):
        measure_rate(phase_track(*steady()), timebase=CLOCK, model=["constant_rate", "wobble"])
