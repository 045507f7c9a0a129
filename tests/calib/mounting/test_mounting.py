"""The mounting of a sensor from a still log: every orientation, honest sds."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.mounting.levelling import ORDERS, Order
from calib.mounting.mounting import MountingLogs, mounting_from_logs
from calib.poses.averaging.mean_noise import variance_of_mean
from tests.calib.mounting.simulated_reading import (
    RATE_HZ,
    TRIAD,
    G,
    Mounted,
    angles_off,
    any_mounting,
    calibration,
    vehicle_to_sensor,
)
from tests.world.imu import gauss_markov, mti

FloatArray = NDArray[np.float64]


@pytest.mark.parametrize("order", [*ORDERS, None])
def test_angles_are_within_a_hundredth_of_a_degree_over_the_whole_sphere(
    order: Order | None,
) -> None:
    """With a tenth of the sensor's noise, in its calibration and in 30 s of log."""
    quiet = mti().with_noise(0.1).accelerometer
    rng = np.random.default_rng(3)
    worst, tried = 0.0, 0
    while tried < 60:
        rotation = any_mounting(rng)
        if order is not None and abs(rotation[ORDERS.index(order), 2]) > 0.95:
            continue  # next to the lock of a forced order an angle means little
        log = Mounted(quiet, rotation).still(30.0, tried)
        found = mounting_from_logs(MountingLogs([log]), calibration(1, 0.1), G, order=order)
        worst, tried = max(worst, float(np.abs(angles_off(found, rotation)).max())), tried + 1
    assert math.degrees(worst) < 0.01


def test_the_stated_sds_cover_the_truth_as_they_say() -> None:
    """Calibration error and noise together; 30 calibrations, 2 mountings each, log of 30 s."""
    rng = np.random.default_rng(4)
    scores = []
    for seed in range(30):
        for k in range(2):
            rotation = any_mounting(rng)
            log = Mounted(TRIAD, rotation).still(30.0, 100 * seed + k)
            found = mounting_from_logs(MountingLogs([log]), calibration(seed), G)
            scores.append(angles_off(found, rotation) / found.sd_rad)
    # 120 scores, four of one calibration: ±4.5 % is two sds of the share.
    assert np.mean(np.abs(scores) < 1.96) == pytest.approx(0.95, abs=0.045)
    assert np.std(scores) == pytest.approx(1.0, abs=0.14)


def test_without_the_calibrations_covariance_the_sd_would_be_too_small() -> None:
    rotation = vehicle_to_sensor("xyz", 0.4, 0.5)
    log = Mounted(TRIAD, rotation).still(600.0, 1)
    sd = mounting_from_logs(MountingLogs([log]), calibration(), G).sd_rad
    exact = replace(calibration(), fit=replace(calibration().fit, cov=np.zeros((9, 9))))
    assert (sd > 3 * mounting_from_logs(MountingLogs([log]), exact, G).sd_rad).all()


def test_compensation_turns_the_reading_upright_and_leaves_its_length() -> None:
    rotation = vehicle_to_sensor("xyz", math.radians(30.65), math.radians(13.0))
    found = mounting_from_logs(
        MountingLogs([Mounted(TRIAD, rotation).still(30.0, 1)]), calibration(), G
    )
    assert found.order == "xyz"
    assert found.after[:2] == pytest.approx([0, 0], abs=1e-12)
    assert found.after[2] == pytest.approx(np.linalg.norm(found.before), rel=1e-14)
    assert found.before == pytest.approx(G * rotation[:, 2], abs=0.01)
    assert found.rotation @ found.after == pytest.approx(found.before)


def test_several_still_logs_count_as_one_longer_log() -> None:
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", 0.2, 0.1))
    one = mounting_from_logs(MountingLogs([mounted.still(30, 1)]), calibration(0, 0.1), G)
    four = mounting_from_logs(
        MountingLogs([mounted.still(30, i) for i in range(4)]), calibration(0, 0.1), G
    )
    assert four.samples == 4 * one.samples
    assert four.sd_rad[0] < 0.7 * one.sd_rad[0]


def test_the_variance_of_a_mean_holds_for_coloured_noise() -> None:
    rng = np.random.default_rng(6)
    time = np.arange(3000)[None] / RATE_HZ
    means, stated = [], []
    for _ in range(300):
        values = gauss_markov(time, 1.0, 0.5, rng)[0] + 3.0 * rng.standard_normal((3000, 3))
        means.append(values.mean(axis=0))
        stated.append(variance_of_mean(values))
    # Student's factor of 24 degrees of freedom widens by 24/22; the lowest frequencies miss a bit.
    assert np.mean(stated) / np.var(means) == pytest.approx(1.05, abs=0.12)


def with_error(effect: str, error: FloatArray) -> TriadCalibration:
    """The calibration of poses that read ``error`` (18, 3) too much, with an effect for that."""
    poses, spec = calibration().fit.poses, calibration().spec
    poses = replace(poses, reading=poses.reading + error)
    return calibrate_triad(fit(poses, Model.of(["bias", "scale", "misalignment", effect])), spec)


def test_a_bias_that_drifts_counts_as_at_the_end_of_the_session() -> None:
    """The biases drift by 0.7 to 1.4 m/s² in an hour, of which the session has a tenth."""
    time_s = calibration().fit.poses.time_s
    per_s = np.array([1.4, -1.0, 0.7]) / 3600
    drifting = with_error("bias_drift", time_s[:, None] * per_s)
    rotation = vehicle_to_sensor("xyz", 0.4, 0.5)
    log = Mounted(TRIAD, rotation).still(30.0, 1)
    counts = per_s * time_s.max() / calibration().spec.nominal_scale
    later = replace(log, accelerometer=log.accelerometer + counts)
    steady = mounting_from_logs(MountingLogs([log]), calibration(), G)
    found = mounting_from_logs(MountingLogs([later]), drifting, G)
    assert np.abs(angles_off(found, rotation) / found.sd_rad).max() < 2
    assert (found.sd_rad > 2 * steady.sd_rad).all()
    assert "no still log tells bias_drift of the accelerometer's model" in found.notes[0]
    assert "sds of the angles contain what the poses of the session differ by" in found.notes[0]


def test_what_the_pose_before_leaves_in_an_axis_is_in_the_sds() -> None:
    force = calibration().fit.rows.vector
    before = np.vstack([np.zeros(3), force[:-1]])
    left = 0.05 * np.tanh(before / (0.3 * G))
    rotation = vehicle_to_sensor("xyz", 0.4, 0.5)
    log = Mounted(TRIAD, rotation).still(30.0, 1)
    found = mounting_from_logs(MountingLogs([log]), with_error("hysteresis", left), G)
    assert np.abs(angles_off(found, rotation) / found.sd_rad).max() < 2
    assert found.sd_rad == pytest.approx([0.05 / G, 0.05 / G], rel=0.5)
