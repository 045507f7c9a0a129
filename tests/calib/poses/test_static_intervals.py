"""Static intervals of long logs: by hand, on a gimbal, on a table, whatever the unit and noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib.errors import Undetermined
from calib.poses.checks.pose_checks import check_still
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.rests.attitude_fit import MODELS, best_threshold, prediction_error
from calib.poses.rests.static_intervals import StaticIntervals, find_still, quiet_level
from calib.poses.rests.still_search import StillSearch
from calib.poses.samples.running_sums import RunningSums
from tests.calib.poses.hand_turned_logs import KINDS, count, made
from tests.world.hand_turned import (
    GRAVITY_M_S2,
    OFFSET_M_S2,
    HandTurned,
    Stop,
    by_hand,
    on_gimbal,
    turn_through,
)

SI = TriadSpec(np.inf, 0, "si")
BOTH = {"accelerometer": SI, "gyroscope": SI}


def as_log(made_log: HandTurned) -> ImuLog:
    return ImuLog("log", made_log.time_s, made_log.force_m_s2, made_log.rate_rad_s)


def search(made_log: HandTurned, **overruled: float) -> StaticIntervals:
    return find_still(as_log(made_log), BOTH, search=StillSearch(**overruled))


@pytest.mark.parametrize("kind", KINDS)
def test_rests_are_found_and_movements_are_not(kind: str) -> None:
    """Of stops that tremble very differently the search may leave the worst to a listed reason."""
    counts = np.array([count(made(kind, seed)) for seed in (11, 12)]).sum(axis=0)
    assert counts[0] >= 0.85 * counts[1]
    assert counts[2] == 0


def test_each_rest_is_one_pose_that_lies_inside_it() -> None:
    made_log = turn_through(by_hand(21), 21)
    poses = search(made_log).logs
    assert len(poses) == len(made_log.rests)
    for pose, (start, end) in zip(poses, made_log.rests, strict=True):
        assert start - 0.06 <= pose.time_s[0]
        assert pose.time_s[-1] <= end + 0.06
        assert pose.time_s[-1] - pose.time_s[0] >= 0.7 * (end - start) - 0.1


def test_a_stop_is_named_by_the_seconds_since_its_log_began_whatever_the_clock() -> None:
    log = as_log(turn_through(on_gimbal(4), 25))
    since_1970 = replace(log, time_s=log.time_s + 1535632635.0)
    labels = [[pose.label for pose in find_still(each, BOTH).logs] for each in (log, since_1970)]
    assert labels[0] == labels[1]
    assert labels[0][0].startswith("log 0.")


def test_a_long_rest_on_a_table_does_not_set_the_level() -> None:
    """The hand trembles by 16 times the sensor's own noise."""
    stops = [Stop(300.0), *by_hand(22, tremor_m_s2=0.08)]
    rests, there, wrong = count(turn_through(stops, 22, noise_m_s2=0.005))
    assert (wrong, there) == (0, 25)
    assert rests >= 23


def test_the_stops_calibrate_the_sensor() -> None:
    made_log = turn_through(by_hand(23, tremor_m_s2=0.02), 23)
    means = np.array([pose.accelerometer.mean(axis=0) for pose in search(made_log).logs])
    assert prediction_error(means, GRAVITY_M_S2) < 3e-3
    assert prediction_error(means + 0.05 * np.sign(means), GRAVITY_M_S2) > 3e-3


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_the_unit_of_the_log_does_not_matter(triad: str) -> None:
    log = as_log(turn_through(by_hand(24), 24))
    specs = BOTH
    small = TriadSpec(np.inf, 0, "si", si_per_unit=250.0)
    spans = []
    for each, scaled in ((log, specs), (replace(log, **{triad: getattr(log, triad) / 250}),
                                        {**specs, triad: small})):
        found = find_still(each, scaled)
        spans.append([(pose.time_s[0], pose.time_s[-1]) for pose in found.logs])
    assert spans[0] == spans[1]


def test_stops_that_are_left_out_are_listed_with_the_reason() -> None:
    steady = [Stop(3.0, 0.01) for _ in range(20)]
    shaken = [*steady[:10], Stop(2.0, 0.15), *steady[10:], Stop(4.0, drift_deg_s=2.0)]
    made_log = turn_through(shaken, 25)
    found = search(made_log, threshold=3.0)
    assert len(found.logs) == 20
    reasons = [why for _, why in found.skipped]
    assert any(why.startswith("noisier than") for why in reasons)
    assert any(why.startswith("moved slowly") for why in reasons)
    start, end = made_log.rests[10]
    (span,) = [span for span, why in found.skipped if why.startswith("noisier")]
    first, last = map(float, span.removesuffix(" s").split("-"))
    assert start - 0.3 < first < last < end + 0.3


def test_the_user_overrules_the_search() -> None:
    made_log = turn_through([Stop(3.0, 0.01), Stop(0.9, 0.01), *on_gimbal(12)], 26)
    free = search(made_log)
    assert len(free.logs) == 14
    longer = search(made_log, seconds=2.0)
    assert all(pose.time_s[-1] - pose.time_s[0] > 1.5 for pose in longer.logs)
    assert len(longer.logs) == 13
    assert search(made_log, threshold=3.0).threshold == pytest.approx(3.0)


def test_a_log_that_never_rests_is_told_so() -> None:
    moving = turn_through([Stop(0.02)] * 60, 27)
    with pytest.raises(Undetermined, match=r"the sensor never rests.*lie untouched"):
        search(moving)


def test_a_sensor_that_keeps_turning_slowly_has_no_stop() -> None:
    turning = turn_through([Stop(60.0, drift_deg_s=8.0)], 28)
    with pytest.raises(Undetermined, match=r"none of its quiet stretches is a pose.*moved slowly"):
        search(turning)


def test_swings_of_metres_per_second_squared_are_no_rest_whatever_the_search_says() -> None:
    """Forty shaken stops would outvote eight quiet ones."""
    stops = [Stop(2.0, 0.6)] * 40 + [Stop(2.0)] * 8
    made_log = turn_through(stops, 29)
    first_quiet = made_log.rests[40][0]
    assert all(pose.time_s[0] > first_quiet - 0.2 for pose in search(made_log).logs)


def test_a_log_of_a_second_is_refused() -> None:
    with pytest.raises(Undetermined, match="too few to look for still poses"):
        search(turn_through([Stop(0.7)], 30))


def test_on_a_turning_plate_the_gyroscope_decides_and_stops_are_none_of_its_poses() -> None:
    """Eight attitudes of the case at 2 rad/s, with the plate stopped after every second one."""
    rng = np.random.default_rng(31)
    parts, steady = [], 0
    for i in range(16):
        axis = rng.standard_normal(3)
        rate = 2.0 * axis / np.linalg.norm(axis)
        ramp = np.linspace(0, 1, 100)[:, None]
        parts += [ramp * rate, np.tile(rate, (1000, 1)), ramp[::-1] * rate]
        steady += 1
        if i % 2:
            parts.append(np.zeros((400, 3)))
    gyroscope = np.concatenate(parts) + 0.003 * rng.standard_normal((sum(map(len, parts)), 3))
    log = ImuLog("log", np.arange(len(gyroscope)) / 100, np.full_like(gyroscope, np.nan), gyroscope)
    found = find_still(log, {"gyroscope": SI}, rate_rad_s=-2.0)
    assert found.triad == "gyroscope"
    assert len(found.logs) == steady
    assert {why for _, why in found.skipped} == {"the plate stood still"}
    with pytest.raises(Undetermined, match=r"none of its quiet stretches.*range or unit"):
        find_still(log, {"gyroscope": TriadSpec(np.inf, 0, "si", np.radians(1))}, rate_rad_s=2.0)


def test_a_stop_ends_before_the_plate_begins_to_turn_under_it() -> None:
    """Stops of a second before and after each turn: gravity does not show a turn about the
    vertical, and the window that is still holds its first tenths of a second."""
    rng, parts = np.random.default_rng(32), []
    speeds_up = 1.75 * (1 - np.cos(np.linspace(0, np.pi, 200)))
    for axis in rng.standard_normal((12, 3)):
        up = axis / np.linalg.norm(axis)
        parts += [(up, np.concatenate([np.zeros(100), speeds_up, np.full(500, 3.5),
                                       speeds_up[::-1], np.zeros(100)]))]
    force = np.concatenate([np.tile(9.8 * up, (len(rate), 1)) for up, rate in parts])
    turn = np.concatenate([rate[:, None] * up for up, rate in parts])
    log = ImuLog("log", np.arange(len(turn)) / 100, force + 0.01 * rng.standard_normal(turn.shape),
                 turn + 0.002 * rng.standard_normal(turn.shape))
    still = [pose for pose in find_still(log, BOTH).logs
             if np.linalg.norm(pose.gyroscope.mean(axis=0)) < 1]
    assert len(still) == 24
    bias = np.array([pose.gyroscope.mean(axis=0) for pose in still])
    assert np.sqrt(np.mean(bias**2)) < 2 * 0.002 / np.sqrt(70)  # thrice as much with the ends


# --- the parts -----------------------------------------------------------------------------------


def test_the_quiet_level_is_that_of_the_noise_even_when_movement_takes_half_the_log() -> None:
    rng = np.random.default_rng(3)
    still = rng.standard_normal((4000, 3))
    moving = 30 * rng.standard_normal((4000, 3))
    level = quiet_level(RunningSums.of(np.vstack([still, moving])).window_variance(100))
    assert level == pytest.approx(3.0, rel=0.15)


def sphere(n: int, seed: int) -> np.ndarray:
    up = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(GRAVITY_M_S2 * up / np.linalg.norm(up, axis=1, keepdims=True))


def test_the_score_is_the_error_that_a_calibration_makes() -> None:
    """Fitted to noisy rests by another route, the magnitude errs in new directions by the score."""
    rng = np.random.default_rng(4)
    sd, errors, scores = 0.01, [], []
    fresh = sphere(400, 5)
    for _ in range(40):
        true = sphere(24, int(rng.integers(1 << 30)))
        seen = true + OFFSET_M_S2 + sd * rng.standard_normal(true.shape)
        scores.append(prediction_error(seen, GRAVITY_M_S2))
        unit = true / GRAVITY_M_S2
        design = np.einsum("ni,nj->nij", unit, seen)
        upper = np.column_stack([design[:, 0], design[:, 1, 1:], design[:, 2, 2], unit])
        theta = np.linalg.lstsq(upper, np.full(24, GRAVITY_M_S2))[0]
        matrix = np.zeros((3, 3))
        matrix[np.triu_indices(3)] = theta[:6]
        corrected = (fresh + OFFSET_M_S2) @ matrix.T + theta[6:]
        errors.append(np.linalg.norm(corrected, axis=1) - GRAVITY_M_S2)
    assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(np.std(errors), rel=0.25)


def test_the_best_threshold_has_many_rests_and_no_movement() -> None:
    rng = np.random.default_rng(6)
    rests = sphere(30, 7) + 2e-3 * rng.standard_normal((30, 3))
    with_movement = np.vstack([rests, 1.05 * sphere(4, 8)])
    assert best_threshold([rests[:13], rests, with_movement], GRAVITY_M_S2) == 1
    assert best_threshold([rests[:3]], GRAVITY_M_S2) is None


def test_rests_that_do_not_determine_the_model_score_nothing() -> None:
    one_plane = np.vstack([sphere(30, 9)[:, :2].T, np.zeros(30)]).T
    assert prediction_error(one_plane, GRAVITY_M_S2) > 1.0
    assert prediction_error(sphere(11, 9), GRAVITY_M_S2) == np.inf
    assert prediction_error(sphere(11, 9), GRAVITY_M_S2, MODELS[1]) < 1e-9


def test_of_a_rest_that_settles_the_part_that_lies_still_is_the_pose() -> None:
    """A stop on a gimbal gives way by 0.2 m/s² for its first second and then lies still."""
    made_log = turn_through(on_gimbal(27), 27)
    start, end = max(made_log.rests, key=lambda rest: rest[1] - rest[0])
    since = made_log.time_s - start
    giving_way = np.where(since >= 0, 0.2 * np.maximum(0.0, 1 - since), 0.2) * (
        (made_log.time_s >= start - 0.1) & (made_log.time_s <= end))
    force = made_log.force_m_s2 + giving_way[:, None] * np.array([0.0, 1.0, 0.0])
    found = find_still(ImuLog("log", made_log.time_s, force, made_log.rate_rad_s), BOTH)
    [settled] = [log for log in found.logs if start < log.time_s.mean() < end]
    check_still("settled", "accelerometer", settled.accelerometer, np.zeros(3),
                found.largest_shift)
    assert settled.time_s[0] > start + 0.3
    assert np.ptp(settled.time_s) > 0.4 * (end - start)


@pytest.mark.parametrize(("rest_s", "kept"), [(6.0, False), (2.0, True)])
@pytest.mark.parametrize("beside", [True, False], ids=["with a gyroscope", "without"])
def test_a_slow_moment_between_long_rests_is_neither_a_pose_nor_reported(
    rest_s: float, kept: bool, beside: bool
) -> None:
    """A hand that moves slowly for half a second; among short stops it is one of them."""
    stops = [Stop(0.6, drift_deg_s=3.0) if i % 5 == 4 else Stop(rest_s) for i in range(20)]
    log = turn_through(stops, 31)
    specs = BOTH if beside else {"accelerometer": SI}
    rests = find_still(as_log(log), specs)
    lengths = [pose.time_s[-1] - pose.time_s[0] for pose in rests.logs]
    assert sum(length > 1 for length in lengths) == 16
    assert (min(lengths) < 1 or bool(rests.skipped)) == kept
    stated = find_still(as_log(log), specs, search=StillSearch(seconds=0.5))
    assert len(stated.logs) + len(stated.skipped) > 16
