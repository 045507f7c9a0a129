"""Poses of known attitude: a cube on a level plate, judged against the truth of simulated ones."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.poses.pose_set import pose_set
from calib.poses.runs.pose_run import PoseRun, laid_down
from calib.poses.runs.reference_runs import gravity_run, turning_run
from tests.fitting import averaged, plate_rate, spec_of
from tests.world.cube import SD_DEG, evening
from tests.world.imu import Triad
from tests.world.session import Session
from tests.world.truth import parameters

SEEDS = 20


def run_of(session: Session, triad: str) -> tuple[PoseRun, Triad]:
    """The run of one triad and what the simulated sensor has."""
    sensor, site = session.design.sensor, session.design.site
    specs = tuple(spec_of(one, one.full_scale) for one in (sensor.accelerometer, sensor.gyroscope))
    still, plate = session.runs
    if triad == "accelerometer":
        means = averaged(still, specs, 0.0)
        return gravity_run("stopped", means, site.gravity_m_s2, 0.0), sensor.accelerometer
    stated = session.rates["17rpm"]
    means = averaged(plate, specs, abs(stated.rate_rad_s))
    latitude = float(np.radians(site.latitude_deg))
    return turning_run(means, plate_rate("17rpm", stated), latitude), sensor.gyroscope


def calibrated(
    seed: int, triad: str, sd_deg: float | None = SD_DEG, times: int = 1, true_deg: float = SD_DEG
) -> tuple[TriadCalibration, Triad]:
    run, truth = run_of(evening(seed, times, true_deg), triad)
    run = laid_down(run, None if sd_deg is None else np.radians(sd_deg))
    poses = pose_set(triad, [run], 0.0)
    return calibrate_triad(fit(poses, Model.of(BASE)), spec_of(truth, truth.full_scale)), truth


def deviations(found: TriadCalibration, truth: Triad) -> np.ndarray:
    """(estimate - truth) / sd of the nine parameters."""
    true, got = parameters(truth), found.parameters
    return np.concatenate([
        (value - right) / sd for value, right, sd in zip(
            (got.misalignment_rad, got.bias_counts, got.scale_counts_per_unit),
            (true.misalignment_rad, true.bias_counts, true.scale_counts_per_unit),
            got.sd, strict=True)])


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_six_faces_of_a_cube_calibrate_a_triad_with_honest_sds(triad: str) -> None:
    z = np.array([deviations(*calibrated(seed, triad)) for seed in range(SEEDS)])
    assert 0.75 < np.sqrt((z**2).mean()) < 1.25
    assert np.abs(z).max() < 4.5


def test_without_the_attitudes_six_faces_are_refused() -> None:
    with pytest.raises(Undetermined):
        calibrated(0, "accelerometer", None)


def test_poses_without_attitudes_of_a_session_that_has_them_are_refused_too() -> None:
    """A run on the stopped plate, which a misfit has fitted by itself."""
    run, _ = run_of(evening(0), "gyroscope")
    poses = pose_set("gyroscope", [laid_down(run, np.radians(SD_DEG))], 0.0)
    assert poses.up is not None
    bare = replace(poses, up=np.full_like(poses.up, np.nan))
    with pytest.raises(Undetermined):
        fit(bare, Model.of(BASE))


def test_a_plate_that_turns_clockwise_is_as_good() -> None:
    run, truth = run_of(evening(0), "gyroscope")
    spin = -np.abs(run.spin_rad_s)
    backwards = replace(run, spin_rad_s=spin, means=[
        replace(mean, gyroscope=replace(mean.gyroscope, mean=-mean.gyroscope.mean))
        for mean in run.means])
    poses = pose_set("gyroscope", [laid_down(backwards, np.radians(SD_DEG))], 0.0)
    found = calibrate_triad(fit(poses, Model.of(BASE)), spec_of(truth, truth.full_scale))
    forwards, _ = calibrated(0, "gyroscope")
    assert found.parameters.misalignment_rad == pytest.approx(
        forwards.parameters.misalignment_rad, abs=1e-4)


def test_a_pose_between_faces_and_edges_is_refused_by_its_name() -> None:
    run, _ = run_of(evening(0), "accelerometer")
    askew = [replace(mean, accelerometer=replace(
        mean.accelerometer, mean=np.array([9.0, 3.5, 0.0]))) for mean in run.means[:1]]
    with pytest.raises(Undetermined, match="° from the nearest face or edge"):
        laid_down(replace(run, means=[*askew, *run.means[1:]]), np.radians(SD_DEG))


def test_a_case_that_stands_worse_than_stated_is_a_misfit() -> None:
    found, _ = calibrated(1, "accelerometer", 0.05, times=3, true_deg=1.0)
    assert found.widening > 3.0
