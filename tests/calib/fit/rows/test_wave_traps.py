"""What goes round with the plate and is no gravity: nothing is named, and figures stay honest."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from calib.assess import AssessedTriad, assess
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.leaning_poses import PER_SI
from tests.fitting import pose_sets, spec_of, tilted_pose_sets
from tests.world.bench import Design, Run
from tests.world.designs import FAST, SLOW, paper_design, tilted_design, turning_run
from tests.world.hidden import Hidden
from tests.world.imu import mpu6050
from tests.world.make_data import WOW
from tests.world.plate import PlateMotion
from tests.world.session import simulate
from tests.world.truth import g_sensitivity_seen

Rocking = Callable[[FloatArray, FloatArray], FloatArray]
WITH_G = Model.of([*BASE, "g_sensitivity"])
LEAN = (float(np.radians(10.0)), 0.0)
BACK = (-LEAN[0], 0.0)
#: of a part that feels a motor's field in its own way, rad/s per unit
MAGNETIC = np.array([[0.8, -0.3, 0.5], [0.2, -0.9, 0.4], [-0.6, 0.1, 0.7]])


def evening(runs: tuple[Run, ...] = (), **table: Any) -> Design:
    design = paper_design(mpu6050(), PlateMotion(SLOW, wow=WOW))
    of_table = {"tilt_rad": LEAN, **table}
    return replace(design, turntable=replace(design.turntable, **of_table), sample_rate_hz=25.0,
                   runs=(design.runs[0], *(runs or design.runs[1:])))


def assessed(design: Design, hide: bool = False, seed: int = 3) -> tuple[PoseSet, AssessedTriad]:
    hidden = (Hidden("g_sensitivity", "gyroscope", PER_SI),) if hide else ()
    _, poses, specs = pose_sets(simulate(design, seed, hidden))
    return poses, assess(poses, Model.of(BASE), specs[1])


def deviations(poses: PoseSet, hide: bool) -> FloatArray:
    fitted = fit(poses, WITH_G)
    where = fitted.model.slices()["g_sensitivity"]
    truth = g_sensitivity_seen(mpu6050(), PER_SI * hide).ravel()
    return np.asarray((fitted.theta[where] - truth) / np.sqrt(np.diag(fitted.cov)[where]))


def in_the_room(size: Callable[[FloatArray], FloatArray]) -> Rocking:
    """A small rotation about one line of the room, by the angle of the plate."""
    def rocking(angle: FloatArray, _: FloatArray) -> FloatArray:
        turned = np.stack([np.cos(angle), -np.sin(angle), np.zeros_like(angle)], axis=-1)
        return np.asarray(size(angle)[..., None] * turned)
    return rocking


def slid(angle: FloatArray, time_s: FloatArray) -> FloatArray:
    """Two degrees about the spindle in the fourth pose, after nine seconds."""
    rotation = np.zeros((*angle.shape, 3))
    rotation[3, :, 2] = np.radians(2.0) * (time_s[3] > 9.0)
    return rotation


@pytest.mark.parametrize("rocking", [
    in_the_room(lambda angle: np.full_like(angle, 0.01)),
    in_the_room(lambda angle: 0.005 * np.cos(angle)),
    slid,
], ids=["gives way under gravity", "nods once", "slides"])
def test_a_case_that_moves_with_the_plate_names_nothing(rocking: Rocking) -> None:
    poses, found = assessed(evening(rocking=rocking))
    assert found.diagnosis.names == ()
    assert np.sqrt(np.mean(deviations(poses, hide=False) ** 2)) < 2


def tugged(size: float) -> Rocking:
    return in_the_room(lambda angle: size * np.exp(2 * (np.cos(angle - 1.0) - 1)))


def nods_twice(size: float) -> Rocking:
    return in_the_room(lambda angle: size * np.cos(2 * angle))


@pytest.mark.parametrize(("rocking", "times"), [(tugged(1e-3), 2.0), (nods_twice(5e-4), 4.3)],
                         ids=["tugs a little", "nods a little"])
def test_sds_of_waves_contain_what_fits_neither_gravity_nor_the_room(
    rocking: Rocking, times: float
) -> None:
    poses, found = assessed(evening(rocking=rocking))
    assert found.diagnosis.names == ()
    assert np.sqrt(np.mean(deviations(poses, hide=False) ** 2)) > 1.5
    used = found.calibration.fit.poses
    assert f"The sds of these waves are {times:g} times their noise" in used.notes[-1]
    assert np.sqrt(np.mean(deviations(used, hide=False) ** 2)) < 1.5


@pytest.mark.parametrize("rocking", [
    tugged(5e-3), tugged(1e-2), nods_twice(5e-3),
], ids=["tugs", "tugs hard", "nods"])
def test_waves_that_show_more_of_a_cable_than_of_gravity_are_left_out(rocking: Rocking) -> None:
    for hide in (False, True):
        _, found = assessed(evening(rocking=rocking), hide)
        assert found.diagnosis.names == ()
        assert found.calibration.fit.poses.ring is None
        assert "These waves are left out" in found.calibration.fit.poses.notes[-1]
        assert found.prediction is not None
        assert "g_sensitivity" in found.prediction.unseen


def test_waves_that_alone_check_a_fit_are_kept_with_their_misfit() -> None:
    design = tilted_design(20.0, mpu6050(), PlateMotion(SLOW, wow=WOW))
    table = replace(design.turntable, rocking=tugged(1e-2))
    session = simulate(replace(design, turntable=table, sample_rate_hz=50.0), 3, ())
    _, poses, specs = tilted_pose_sets(session)
    found = assess(poses, Model.of(BASE), specs[1])
    used = found.calibration.fit.poses
    assert used.ring is not None
    assert "times their noise" in used.notes[-1]
    assert found.diagnosis.names == ()
    assert np.sqrt(np.mean(deviations(used, hide=False) ** 2)) < 1.5


def nine_mountings(
    rate: float = SLOW, hidden: tuple[Hidden, ...] = (), **table: Any
) -> PoseSet:
    """The accelerometer's poses on a plate that leans by 20°, out of the middle."""
    wow = ((1.0, 6e-3, 0.7), (2.0, 2e-3, 2.1))
    design = tilted_design(20.0, mpu6050(), PlateMotion(rate, wow=wow))
    design = replace(design, turntable=replace(design.turntable, offset_m=(0.07, 0.0), **table),
                     sample_rate_hz=50.0)
    return tilted_pose_sets(simulate(design, 3, hidden))[0]


def accelerometer_of(poses: PoseSet) -> AssessedTriad:
    sensor = mpu6050().accelerometer
    return assess(poses, Model.of(BASE), spec_of(sensor, sensor.full_scale))


def test_wow_makes_waves_of_a_case_beside_the_spindle_and_they_are_known() -> None:
    poses = nine_mountings(FAST)
    fitted = fit(poses, Model.of(BASE))
    assert fitted.chi2 / fitted.dof < 1.3
    assert accelerometer_of(poses).calibration.fit.poses.notes == ()
    assert poses.ring is not None
    unaware = replace(poses, ring=replace(poses.ring, wow=np.zeros_like(poses.ring.wow)))
    fitted = fit(unaware, Model.of(BASE))
    assert fitted.chi2 / fitted.dof > 1.8


def test_what_comes_twice_per_turn_is_left_out_where_a_cable_tugs() -> None:
    found = accelerometer_of(nine_mountings(rocking=tugged(5e-3)))
    used = found.calibration.fit.poses
    assert used.ring is not None
    assert used.ring.twice.size == 0
    assert "What comes twice per turn is left out" in used.notes[-1]
    assert found.diagnosis.verdict == "nothing_missing"
    assert found.calibration.fit.chi2 / found.calibration.fit.dof < 1.5


def test_an_effect_of_attitude_is_no_cable() -> None:
    size = np.array([1.0, -0.7, 0.5]) * 5e-4  # twice that of an MPU-6050, per m/s²
    poses = nine_mountings(hidden=(Hidden("quadratic", "accelerometer", size),))
    found = accelerometer_of(poses)
    assert found.calibration.fit.poses.notes == ()
    assert found.diagnosis.names == ("quadratic",)


def test_only_the_waves_of_the_run_that_is_disturbed_are_left_out() -> None:
    def rocking(angle: FloatArray, time_s: FloatArray) -> FloatArray:
        fast = np.ptp(angle, axis=1) > 1.5 * SLOW * np.ptp(time_s, axis=1)
        return np.asarray(tugged(1e-2)(angle, time_s) * fast[:, None, None])

    runs = (run_at(SLOW, LEAN, "17rpm"), run_at(FAST, LEAN, "33rpm"))
    _, found = assessed(evening(runs=runs, rocking=rocking), hide=True)
    used = found.calibration.fit.poses
    assert used.ring is not None
    assert {used.run[place] for place in used.ring.place} == {"17rpm"}
    assert [note.split(":")[0] for note in used.notes] == ["33rpm"]
    assert found.diagnosis.names == ("g_sensitivity",)


@pytest.mark.parametrize("tilt_deg", [0.3, 0.7, 1.0, 1.4])
def test_a_plate_that_hardly_leans_names_nothing(tilt_deg: float) -> None:
    for hide in (False, True):
        _, found = assessed(evening(tilt_rad=(float(np.radians(tilt_deg)), 0.0)), hide)
        assert found.diagnosis.names == ()
        assert found.prediction is not None
        assert "g_sensitivity" in found.prediction.unseen


def test_four_turns_are_enough() -> None:
    design = evening()
    short = replace(design.runs[1], seconds=4.1 * 2 * np.pi / SLOW)
    poses, found = assessed(replace(design, runs=(design.runs[0], short)), hide=True)
    assert found.diagnosis.names == ("g_sensitivity",)
    assert np.sqrt(np.mean(deviations(poses, hide=True) ** 2)) < 2


def run_at(rate: float, tilt: tuple[float, float], name: str) -> Run:
    first = evening().runs[1]
    return replace(turning_run(name, PlateMotion(rate, wow=WOW), first.directions), tilt_rad=tilt)


@pytest.mark.parametrize("tilt", [LEAN, (0.0, float(np.radians(4.0))), (0.0, 0.005)],
                         ids=["alike", "less, another way", "level"])
def test_two_speeds_may_lean_in_two_ways(tilt: tuple[float, float]) -> None:
    design = evening(runs=(run_at(SLOW, LEAN, "17rpm"), run_at(FAST, tilt, "33rpm")))
    poses, found = assessed(design, hide=True)
    assert found.diagnosis.names == ("g_sensitivity",)
    assert np.sqrt(np.mean(deviations(poses, hide=True) ** 2)) < 2
    _, found = assessed(design)
    assert found.diagnosis.names == ()


def test_a_field_across_the_lean_is_no_cable() -> None:
    for hide in (False, True):
        _, found = assessed(evening(magnet=(2e-3, 5e-4), magnetic=MAGNETIC), hide)
        used = found.calibration.fit.poses
        assert "does not follow gravity" in used.notes[-1]
        assert "stays in the room, as a field does" in used.notes[-1]
        assert found.diagnosis.names == ()


@pytest.mark.parametrize("magnet", [(3e-4, 3e-4), (-1e-3, 2e-4)])
def test_a_rate_that_stays_in_the_room_is_said_and_names_nothing(
    magnet: tuple[float, float]
) -> None:
    _, found = assessed(evening(magnet=magnet))
    used = found.calibration.fit.poses
    assert "times as large as the Earth's horizontal one" in used.notes[-1]
    assert found.diagnosis.verdict == "nothing_missing"
    assert np.abs(deviations(used, hide=False)).max() < 3
    _, found = assessed(evening(magnet=magnet), hide=True)
    assert found.diagnosis.names == ("g_sensitivity",)
    assert np.abs(deviations(found.calibration.fit.poses, hide=True)).max() < 3


def test_a_field_of_the_motor_looks_like_gravity_until_the_player_leans_the_other_way() -> None:
    """A field of 0.03 °/s that lies along the lean."""
    motor = {"magnet": (0.0, 5e-4), "magnetic": MAGNETIC}
    _, found = assessed(evening(**motor))
    assert found.diagnosis.names == ("g_sensitivity",)
    assert "with the other side of the record player raised" in found.diagnosis.explanation.text
    both = (run_at(SLOW, LEAN, "17rpm"), run_at(SLOW, BACK, "back"))
    poses, found = assessed(evening(runs=both, **motor))
    assert "g_sensitivity" not in found.diagnosis.names
    assert np.abs(deviations(poses, hide=False)).max() < 6  # of one tilt more than 20
    poses, found = assessed(evening(runs=both), hide=True)
    assert found.diagnosis.names == ("g_sensitivity",)
    assert "raised" not in found.diagnosis.explanation.text
