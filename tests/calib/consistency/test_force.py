"""The specific force on the turning plate against gravity, on arrays."""

from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.force import force_notes, require_gravity
from calib.earth import STANDARD_GRAVITY_M_S2
from calib.errors import Contradiction
from calib.fit.least_squares.solver import fit
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.numbers import RPM
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import (
    FAST,
    GRAVITY,
    MODEL,
    SLOW,
    SPECS,
    base_theta,
    made_poses,
    noisy,
    read_through,
)


@pytest.fixture(scope="module")
def accelerometer() -> TriadCalibration:
    poses = noisy(made_poses("accelerometer", (0.0,)), 1)
    return calibrate_triad(fit(poses, MODEL), SPECS["accelerometer"])


def on_the_plate(matrix: FloatArray, run: str = "run 1") -> PoseSet:
    """Poses of the gyroscope whose accelerometer reads through ``matrix`` in one run."""
    poses = made_poses("gyroscope", (SLOW, FAST))
    of_force = replace(made_poses("accelerometer", (SLOW, FAST)), reading=poses.force)
    nominal = read_through(of_force, MODEL, base_theta(MODEL, "accelerometer")).reading
    member = np.array(poses.run) == run
    nominal[member] = nominal[member] @ matrix.T
    return replace(poses, other_reading=nominal)


def test_a_calibrated_accelerometer_reads_gravity_in_every_run(
    accelerometer: TriadCalibration,
) -> None:
    require_gravity(on_the_plate(np.eye(3)), accelerometer, GRAVITY)
    assert force_notes(on_the_plate(np.eye(3)), accelerometer, GRAVITY) == (None, None)


def test_a_drift_by_a_per_cent_is_no_contradiction(accelerometer: TriadCalibration) -> None:
    require_gravity(on_the_plate(1.01 * np.eye(3)), accelerometer, GRAVITY)


@pytest.mark.parametrize(("gain", "is_told"), [
    (1.0, False), (1.003, False), (1.04, True), (0.985, True), (0.96, True),
])
def test_poses_at_rest_of_another_unit_are_told(
    accelerometer: TriadCalibration, gain: float, is_told: bool
) -> None:
    poses = on_the_plate(gain * np.eye(3))
    _, told = force_notes(poses, accelerometer, GRAVITY)
    assert (told is not None) == is_told
    assert "another unit" in (told or "another unit")
    assert ("as on a plate that leans" in (told or "")) == (gain < 1 and is_told)
    few = poses.take([20, 21])  # too few to say
    assert force_notes(few, accelerometer, GRAVITY) == (None, None)


@pytest.mark.parametrize(("matrix", "words"), [
    (0.5 * np.eye(3), "run 1: .*It fits if the readings are halved"),
    (np.eye(3) / STANDARD_GRAVITY_M_S2, "run 1: .*It fits if the readings are in g instead"),
    (1.37 * np.eye(3), r"run 1: .*square\)\. Its logs .*of another sensor, range, unit"),
    (np.cos(np.radians(20)) * np.eye(3), "run 1: .*on a plate that leans by 20°: if it does, log "
     "each for at least 3 whole turns.*Else its logs .*of another sensor"),
    (np.diag([0.97, 0.9, 0.95]), r"run 1: .*square\)\. Its logs .*of another sensor"),
])
def test_another_range_or_unit_is_named(
    accelerometer: TriadCalibration, matrix: FloatArray, words: str
) -> None:
    with pytest.raises(Contradiction, match=words):
        require_gravity(on_the_plate(matrix), accelerometer, GRAVITY)


def test_exchanged_axes_show_by_what_the_calibration_tells_of_them() -> None:
    """Lengths show an exchange through bias and scale alone: here 6 % of a gain, 3 m/s² of bias."""
    theta = base_theta(MODEL, "accelerometer")
    theta[:3] = [3.0, -2.0, 0.5]
    poses = made_poses("accelerometer", (0.0,))
    calibration = calibrate_triad(fit(read_through(poses, MODEL, theta), MODEL),
                                  SPECS["accelerometer"])
    on_plate = made_poses("gyroscope", (SLOW, FAST))
    of_force = replace(made_poses("accelerometer", (SLOW, FAST)), reading=on_plate.force)
    nominal = read_through(of_force, MODEL, theta).reading
    require_gravity(replace(on_plate, other_reading=nominal), calibration, GRAVITY)
    with pytest.raises(Contradiction, match="x and y are exchanged"):
        require_gravity(replace(on_plate, other_reading=nominal[:, [1, 0, 2]]), calibration,
                        GRAVITY)


def at_78_rpm(offset_m: float) -> PoseSet:
    """Poses whose accelerometer feels the centripetal part of ``offset_m`` off the spindle."""
    spin = 78.26 * RPM
    poses = made_poses("gyroscope", (spin,))
    across = np.cross(poses.force, [0.3, 0.2, 1.0])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    of_force = replace(made_poses("accelerometer", (spin,)),
                       reading=poses.force + spin**2 * offset_m * across)
    nominal = read_through(of_force, MODEL, base_theta(MODEL, "accelerometer")).reading
    return replace(poses, other_reading=nominal)


def test_what_turns_at_the_rim_of_a_record_is_no_contradiction(
    accelerometer: TriadCalibration,
) -> None:
    require_gravity(at_78_rpm(0.14), accelerometer, GRAVITY)
    with pytest.raises(Contradiction, match="the calibrated accelerometer reads 28"):
        require_gravity(at_78_rpm(0.4), accelerometer, GRAVITY)


def test_two_odd_poses_are_bad_poses_and_no_other_sensor(accelerometer: TriadCalibration) -> None:
    require_gravity(on_the_plate(0.5 * np.eye(3)).take([-1, -2]), accelerometer, GRAVITY)


def test_a_calibration_that_knows_little_contradicts_nothing_and_says_so() -> None:
    loose = made_poses("accelerometer", (0.0,))
    loose = noisy(replace(loose, sd=100 * loose.sd), 1)
    calibration = calibrate_triad(fit(loose, MODEL), SPECS["accelerometer"])
    poses = on_the_plate(0.9 * np.eye(3))
    require_gravity(poses, calibration, GRAVITY)
    said, _ = force_notes(poses, calibration, GRAVITY)
    assert "determines the specific force to" in (said or "")
