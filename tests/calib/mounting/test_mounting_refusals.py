"""What the mounting is not measured from, and what the user is told instead."""

import math
from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import find_effect
from calib.errors import Undetermined
from calib.mounting.mounting import MountingLogs, mounting_from_logs
from calib.mounting.still_reading import require_at_rest
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from tests.calib.mounting.simulated_reading import (
    TRIAD,
    G,
    Mounted,
    calibration,
    floor,
    vehicle_to_sensor,
)


def test_gimbal_lock_of_a_forced_order_is_refused() -> None:
    log = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.0, math.radians(89))).still(30, 1)
    with pytest.raises(Undetermined, match="gimbal lock: with the rotation order xyz the pitch"):
        mounting_from_logs(MountingLogs([log]), calibration(), G, order="xyz")
    assert mounting_from_logs(MountingLogs([log]), calibration(), G).order == "yxz"
    log = Mounted(TRIAD, vehicle_to_sensor("yxz", math.radians(89), 0.0)).still(30, 1)
    with pytest.raises(Undetermined, match="the roll is within 3° of 90° at this mounting"):
        mounting_from_logs(MountingLogs([log]), calibration(), G, order="yxz")


def test_a_magnitude_that_is_not_gravity_is_refused() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    force = np.tile([0.0, 0.0, 1.03 * G], (3000, 1))
    with pytest.raises(Undetermined, match=r"magnitude of 10\.09.*\+3\.0 % off"):
        mounting_from_logs(MountingLogs([mounted.log(force, 1)]), calibration(), G)


def test_a_drifted_calibration_widens_the_sds_and_says_so() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    good = mounting_from_logs(MountingLogs([mounted.still(30, 1)]), calibration(), G)
    force = np.tile([0.0, 0.0, 1.006 * G], (3000, 1))
    drifted = mounting_from_logs(MountingLogs([mounted.log(force, 1)]), calibration(), G)
    assert good.notes == ()
    assert "the calibration has drifted" in drifted.notes[0]
    assert drifted.sd_rad == pytest.approx([0.006, 0.006], rel=0.2)


def test_a_short_log_says_that_its_sds_are_lower_bounds() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    found = mounting_from_logs(MountingLogs([mounted.still(3, 1)]), calibration(), G)
    assert found.samples == 300
    assert "sds are lower bounds" in found.notes[0]


def test_logs_of_two_places_are_refused() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    logs = [mounted.still(30, 1), mounted.still(30, 2, floor(0.02, 0.0))]
    with pytest.raises(Undetermined, match="the vehicle was moved between them"):
        mounting_from_logs(MountingLogs(logs), calibration(), G)


def test_short_logs_of_a_noisy_sensor_at_one_place_agree() -> None:
    """Their means differ by 0.03 m/s², as noise of half a second does."""
    random = np.random.default_rng(3)
    slow = np.repeat(0.05 * random.standard_normal((2, 6, 3)), 50, axis=1)
    mounted = Mounted(TRIAD, np.eye(3))
    logs = [mounted.log(np.array([0.0, 0.0, G]) + of_log, 1) for of_log in slow]
    one, other = (log.accelerometer.mean(axis=0) for log in logs)
    assert np.abs(TRIAD.full_scale / 2**15 * (one - other)).max() > 0.04
    assert mounting_from_logs(MountingLogs(logs), calibration(), G).samples == 600


def test_a_gyroscope_that_may_read_its_offset_is_at_rest_and_one_that_reads_more_turns() -> None:
    """20 °/s by its data sheet, 5 °/s beside its reading in poses at rest."""
    def reading(degrees: float) -> ImuLog:
        rate = np.tile([0.0, 0.0, math.radians(degrees)], (100, 1))
        return ImuLog("still", np.arange(100) / 100, np.full((100, 3), np.nan), rate)

    spec = TriadSpec(np.inf, 0, "si")
    require_at_rest([reading(19)], spec, None)
    with pytest.raises(Undetermined, match="was turning"):
        require_at_rest([reading(21)], spec, None)
    at_rest = np.array([0.0, 0.0, math.radians(30)])
    require_at_rest([reading(33)], spec, at_rest)
    with pytest.raises(Undetermined, match="was turning"):
        require_at_rest([reading(37)], spec, at_rest)


def test_a_log_without_accelerometer_or_without_rest_is_refused() -> None:
    with pytest.raises(Undetermined, match="no still log was found"):
        mounting_from_logs(MountingLogs([]), calibration(), G)
    log = Mounted(TRIAD, np.eye(3)).still(30, 1)
    blank = ImuLog(log.label, log.time_s, np.full((3000, 3), np.nan), log.accelerometer)
    with pytest.raises(Undetermined, match="no accelerometer columns"):
        mounting_from_logs(MountingLogs([blank]), calibration(), G)


@pytest.mark.parametrize(("first", "degrees"), [(500, 1.0), (1500, 0.5), (2500, 1.0)])
def test_a_vehicle_that_moves_by_a_degree_or_less_is_refused(first: int, degrees: float) -> None:
    force = np.tile([0.0, 0.0, G], (3000, 1))
    force[first:, 0] = G * math.radians(degrees)
    with pytest.raises(Undetermined, match="moved: accelerometer x"):
        mounting_from_logs(
            MountingLogs([Mounted(TRIAD, np.eye(3)).log(force, 1)]), calibration(), G
        )


def test_a_creeping_vehicle_is_refused() -> None:
    force = np.tile([0.0, 0.0, G], (3000, 1))
    force[:, 1] = np.linspace(0.0, 0.1, 3000)
    with pytest.raises(Undetermined, match="moved: accelerometer y"):
        mounting_from_logs(
            MountingLogs([Mounted(TRIAD, np.eye(3)).log(force, 1)]), calibration(), G
        )


def test_effects_that_the_log_cannot_evaluate_are_named() -> None:
    found = calibration()
    equations = found.fit.equations.extended([find_effect("temperature_bias")])
    theta = np.append(found.fit.theta, [0.001, 0.0, 0.0])
    cov = np.zeros((12, 12))
    cov[:9, :9] = found.fit.cov
    at = replace(found.fit.at, theta=theta)
    warm = replace(found, fit=replace(found.fit, equations=equations, at=at, cov=cov))
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.1, 0.2))
    with pytest.raises(Undetermined, match="model has temperature_bias"):
        mounting_from_logs(MountingLogs([mounted.still(30, 1)]), warm, G)
    still = mounted.still(30, 1)
    logged = replace(still, columns={"temperature_c": np.full(3000, 45.0)})
    plain = mounting_from_logs(MountingLogs([still]), found, G).before
    assert mounting_from_logs(MountingLogs([logged]), warm, G).before - plain == pytest.approx(
        [-0.02, 0, 0], abs=1e-9
    )
