"""Floor and yaw: what a second heading and a drive add to the still log."""

import math

import numpy as np
import pytest

from calib.errors import Undetermined
from calib.mounting.heading import FirstPush
from calib.mounting.mounting import MountingLogs, mounting_from_logs
from calib.mounting.still_reading import log_conditions
from tests.calib.mounting.simulated_reading import (
    TRIAD,
    G,
    Mounted,
    calibration,
    drive,
    floor,
    vehicle_to_sensor,
)
from tests.chance import fewest_hits, spread_bounds


def test_yaw_slope_and_angles_lie_within_their_sds_on_simulated_drives() -> None:
    rng = np.random.default_rng(5)
    yaws, angles, slopes = [], [], []
    for k in range(60):
        roll, pitch, yaw = rng.uniform([-3.1, -1.4, -3.1], [3.1, 1.4, 3.1])
        mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", roll, pitch, yaw))
        rise = rng.uniform(-0.05, 0.05, 2)
        turned = math.pi + math.radians(3.0) * rng.standard_normal()
        push: FirstPush = "forward" if k % 2 else "backward"
        found = mounting_from_logs(
            MountingLogs(
                [mounted.still(30, k, floor(*rise))],
                reverse=[mounted.still(30, 500 + k, floor(*rise, turned))],
                drive=[mounted.log(drive(60, k, 1.0 if push == "forward" else -1.0), k)],
                first_push=push,
            ),
            calibration(k % 20),
            G,
            order="xyz",
        )
        assert found.yaw is not None
        assert found.slope is not None
        yaws.append(math.remainder(found.yaw.yaw_rad - yaw, 2 * math.pi) / found.yaw.sd_rad)
        off = [math.remainder(found.roll_rad - roll, 2 * math.pi), found.pitch_rad - pitch]
        angles.append(off / found.sd_rad)
        slopes.append((found.slope.rise_rad - np.sin(rise)) / found.slope.sd_rad)
    for scores in (yaws, angles, slopes):
        size = np.size(scores)
        assert (np.abs(scores) < 1.96).sum() >= fewest_hits(size, 0.95, chance=0.01)
        low, high = spread_bounds(size - 1)
        assert low < np.std(scores, ddof=1) < high


def test_the_driver_tells_the_sign_of_the_yaw() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2, 0.5))
    still, moving = [mounted.still(30, 1)], [mounted.log(drive(60, 1), 1)]
    ahead = mounting_from_logs(MountingLogs(still, drive=moving), calibration(), G)
    wrong = mounting_from_logs(
        MountingLogs(still, drive=moving, first_push="backward"), calibration(), G
    )
    assert ahead.yaw is not None
    assert wrong.yaw is not None
    assert ahead.yaw.yaw_rad == pytest.approx(0.5, abs=0.1)
    turned = abs(math.remainder(wrong.yaw.yaw_rad - ahead.yaw.yaw_rad, 2 * math.pi))
    assert turned == pytest.approx(math.pi)


def test_speeding_up_alone_tells_the_sign_too() -> None:
    """Half the drive is one push: less its mean, standing still would look like braking."""
    push = drive(30, 3, shake_m_s2=0.3)
    push[:, 0] = 0.3 * np.random.default_rng(1).standard_normal(3000)
    push[1400:, 0] += 1.5
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2, 2.0))
    found = mounting_from_logs(
        MountingLogs([mounted.still(30, 1)], drive=[mounted.log(push, 1)]), calibration(), G
    )
    assert found.yaw is not None
    assert found.yaw.yaw_rad == pytest.approx(2.0, abs=0.15)


def test_calibration_and_mounting_apply_as_one() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("yxz", -0.6, 0.9, 1.2))
    found = mounting_from_logs(
        MountingLogs([mounted.still(30, 1)], drive=[mounted.log(drive(60, 1), 1)]), calibration(), G
    )
    felt = np.array([1.0, -2.0, 9.0])
    log = mounted.log(np.tile(felt, (3000, 1)), 9)
    at = log_conditions(log, calibration().spec.nominal(log.accelerometer), calibration().end_s)
    # The yaw is known to about a degree, which turns (1, -2) by 0.04 m/s².
    in_vehicle = found.turn(calibration().correct(at))
    assert in_vehicle.mean(axis=0) == pytest.approx(felt, abs=0.15)


def test_drives_without_a_clear_direction_are_refused() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    still = [mounted.still(30, 1)]
    with pytest.raises(Undetermined, match="at least 20 s"):
        mounting_from_logs(
            MountingLogs(still, drive=[mounted.log(drive(12, 1), 1)]), calibration(), G
        )
    with pytest.raises(Undetermined, match="without bends"):
        mounting_from_logs(
            MountingLogs(still, drive=[mounted.log(drive(60, 1, sway_m_s2=1.5), 1)]),
            calibration(),
            G,
        )
    with pytest.raises(Undetermined, match="marked acceleration"):
        mounting_from_logs(MountingLogs(still, drive=[mounted.still(60, 7)]), calibration(), G)


def test_a_vehicle_that_stands_has_no_direction_however_its_engine_shakes_it() -> None:
    """All along one axis, so that hardly anything is across."""
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    shaken = np.tile([0.0, 0.0, G], (6000, 1))
    shaken[:, 0] += np.random.default_rng(2).standard_normal(6000)
    logs = MountingLogs([mounted.still(30, 1)], drive=[mounted.log(shaken, 7)])
    with pytest.raises(Undetermined, match=r"at least 0\.3 m/s² along"):
        mounting_from_logs(logs, calibration(), G)


def test_the_reverse_heading_tells_the_floor_from_the_mounting() -> None:
    """13.00° on a lamp of nominally 15°: 2° of table would do it, and one log cannot tell."""
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", math.radians(30), math.radians(15)))
    rise = math.radians(-2.0), math.radians(0.5)
    ahead, back = floor(*rise), floor(*rise, math.pi)
    alone = mounting_from_logs(MountingLogs([mounted.still(30, 1, ahead)]), calibration(), G)
    assert abs(math.degrees(alone.pitch_rad) - 15) > 1.5
    assert alone.slope is None
    both = mounting_from_logs(
        MountingLogs([mounted.still(30, 1, ahead)], reverse=[mounted.still(30, 2, back)]),
        calibration(),
        G,
    )
    assert both.slope is not None
    off = np.array([both.roll_rad, both.pitch_rad]) - np.radians([30, 15])
    assert (np.abs(off) < 3 * both.sd_rad).all()
    assert (np.abs(both.slope.rise_rad - np.sin(rise)) < 3 * both.slope.sd_rad).all()


def test_a_remounted_sensor_is_not_a_reverse_heading() -> None:
    first = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2)).still(30, 1)
    second = Mounted(TRIAD, vehicle_to_sensor("xyz", 1.1, 0.2)).still(30, 2)
    with pytest.raises(Undetermined, match="remounted"):
        mounting_from_logs(MountingLogs([first], reverse=[second]), calibration(), G)
