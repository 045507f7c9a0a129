"""Nine mountings on a plate that leans, simulated sample by sample: both triads against the truth.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from calib.assess import assess
from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.triad.leaning import leaning_of
from calib.fit.validation.leave_one_out import compare, refitted_residual
from calib.poses.runs.ideal_ring import tilted_run
from tests.fitting import averaged, spec_of, tilted_pose_sets
from tests.world.designs import FAST, SLOW, tilted_design, turning_run
from tests.world.hidden import Hidden
from tests.world.imu import MPU_SPREAD, another_unit, mpu6050
from tests.world.make_data import G_SENSITIVITY_DEG_S_PER_G, WOW
from tests.world.plate import PlateMotion
from tests.world.session import Session, simulate
from tests.world.truth import Parameters

PER_SI = np.radians(G_SENSITIVITY_DEG_S_PER_G) / 9.80665
HIDDEN = (Hidden("g_sensitivity", "gyroscope", PER_SI),)
SEEDS = range(4)


@lru_cache
def evening(seed: int, tilt_deg: float = 20.0, rate: float = SLOW) -> Session:
    """A unit of its own, an ordinary g-sensitivity, an ordinary drive."""
    unit = another_unit(mpu6050(), MPU_SPREAD, np.random.default_rng([8, seed]))
    design = tilted_design(tilt_deg, unit, PlateMotion(rate, wow=WOW))
    return simulate(replace(design, sample_rate_hz=25.0), 800 + seed, HIDDEN)


@lru_cache
def both(seed: int, rate: float = SLOW) -> tuple[TriadCalibration, TriadCalibration]:
    """The accelerometer and the gyroscope, the latter with its g-sensitivity."""
    accelerometer, gyroscope, specs = tilted_pose_sets(evening(seed, rate=rate))
    return (calibrate_triad(fit(accelerometer, Model.of(BASE)), specs[0]),
            calibrate_triad(fit(gyroscope, Model.of([*BASE, "g_sensitivity"])), specs[1]))


def deviations(found: TriadCalibration, truth: Parameters) -> np.ndarray:
    """(estimate - truth)/sd of the nine parameters, (3, 3)."""
    names = ("misalignment_rad", "bias_counts", "scale_counts_per_unit")
    return np.array([getattr(found.parameters, name) - getattr(truth, name)
                     for name in names]) / found.parameters.sd


def test_both_triads_come_out_with_honest_sds() -> None:
    z = np.array([[deviations(both(seed)[0], evening(seed).accelerometer),
                   deviations(both(seed)[1], evening(seed).gyroscope)] for seed in SEEDS])
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.4
    assert np.abs(z).max() < 4
    chi2 = [each.fit.chi2 / each.fit.dof for seed in SEEDS for each in both(seed)]
    assert 0.7 < np.mean(chi2) < 1.3


def test_they_are_as_good_as_an_evening_of_36_poses_within_a_few_times() -> None:
    accelerometer, gyroscope = both(0)
    relative = accelerometer.parameters.sd[2] / accelerometer.parameters.scale_counts_per_unit
    assert relative.max() < 5e-4
    assert accelerometer.parameters.sd[0].max() < 1e-3
    assert gyroscope.parameters.sd[0].max() < 1e-3


def test_the_tilt_is_measured_and_a_clockwise_plate_is_as_good() -> None:
    accelerometer, gyroscope = both(0, -SLOW)
    (tilt,) = leaning_of(accelerometer.fit).tilt_rad.values()
    assert np.degrees(tilt) == pytest.approx(20.0, abs=0.05)
    z = np.array([deviations(accelerometer, evening(0, rate=-SLOW).accelerometer),
                  deviations(gyroscope, evening(0, rate=-SLOW).gyroscope)])
    assert np.sqrt(np.mean(z**2)) < 1.7


def test_a_wrong_gravity_is_pure_scale_whatever_the_tilts() -> None:
    """Two speeds with different tilt: the waves have their part of gravity as the means have."""
    design = tilted_design(15.0)
    first = design.runs[0]
    second = turning_run("33rpm", PlateMotion(FAST), first.directions)
    second = replace(second, tilt_rad=(0.09, 0.0))
    session = simulate(replace(design, runs=(first, second), sample_rate_hz=50.0), 3)
    poses, _, specs = tilted_pose_sets(session)
    found = assess(poses, Model.of(BASE), specs[0])
    assert found.diagnosis.verdict == "nothing_missing"
    assert {"reference_scale", "reference_offset"} <= set(found.diagnosis.blind)
    stated = poses.reference
    assert poses.ring is not None
    wrong = replace(poses, reference=replace(stated, magnitude=1.01 * stated.magnitude),
                    ring=replace(poses.ring, gravity_m_s2=1.01 * poses.ring.gravity_m_s2))
    sound, scaled = fit(poses, Model.of(BASE)), fit(wrong, Model.of(BASE))
    assert scaled.chi2 == pytest.approx(sound.chi2, rel=0.03)


def test_leaving_a_pose_out_takes_its_waves_too() -> None:
    """Every row of a pose, wherever it stands, against a refit without that pose."""
    whole = both(0)[0].fit
    left_out, compared = refitted_residual(whole), compare(whole)
    for k in range(len(whole.poses)):
        others = [i for i in range(len(whole.poses)) if i != k]
        without = fit(whole.poses.take(others), whole.model)
        rows = whole.equations.rows(without.theta, without.eta, {})
        mine = np.flatnonzero(whole.equations.row_pose == k)
        assert len(mine) == 10
        assert left_out[mine] == pytest.approx(rows.residual[mine], rel=0.02, abs=0.03)
        of_pose = compared.poses[k]
        assert of_pose.left_out / of_pose.sd == pytest.approx(
            np.sqrt(np.mean(rows.residual[mine] ** 2)), rel=0.02, abs=0.03)


def test_a_level_plate_is_refused_with_what_to_put_under_it() -> None:
    session = evening(0, 0.5)
    sensor = session.design.sensor
    specs = (spec_of(sensor.accelerometer, sensor.accelerometer.full_scale),
             spec_of(sensor.gyroscope, sensor.gyroscope.full_scale))
    means = averaged(session.runs[0], specs, SLOW)
    with pytest.raises(Undetermined, match=r"a tilt of 0\.5° was found\. Put 5 cm under one side"):
        tilted_run("17rpm", means, 9.80267, 0.0)
