"""From a simulated evening to fitted triads, by the same calls that the pipeline makes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.fit.least_squares.angrisano import fit_paper
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.triad.leaning import leaning_of, with_axes
from calib.poses.averaging.drift_within import average_poses
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.data_sheet import Encoding, TriadSpec
from calib.poses.imu_log import TRIADS, ImuLog
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.reference import PlateRate
from calib.poses.runs.ideal_ring import NOT_FITTED, tilted_run
from calib.poses.runs.reference_runs import gravity_run, stopped_run, turning_run
from tests.world.imu import Sensor, Triad
from tests.world.session import RunLog, Session, StatedRate


def spec_of(triad: Triad, full_scale: float) -> TriadSpec:
    """The data sheet of a simulated triad."""
    encoding: Encoding = "offset-binary" if triad.offset_binary else "twos-complement"
    return TriadSpec(full_scale, triad.bits, encoding)


def averaged(run: RunLog, specs: tuple[TriadSpec, TriadSpec], rate: float) -> list[PoseMean]:
    """Pose means of one run."""
    logs = [
        ImuLog(
            pose.label,
            pose.time_s,
            pose.accelerometer.astype(float),
            pose.gyroscope.astype(float),
            pose.columns,
        )
        for pose in run.poses
    ]
    return average_poses(logs, dict(zip(TRIADS, specs, strict=True)), [rate] * len(logs))


def plate_rate(name: str, stated: StatedRate) -> PlateRate:
    """A stated rate as the vision stage would hand it on."""
    rate, sd = np.array([abs(stated.rate_rad_s)]), np.array([stated.own_sd_rad_s])
    return PlateRate(name, rate, sd, stated.clock_relative)


@dataclass(frozen=True, eq=False)
class Calibrated:
    """Both triads of one evening."""

    accelerometer: TriadCalibration
    gyroscope: TriadCalibration


def _fit(poses: PoseSet, names: Sequence[str], spec: TriadSpec, solver: str) -> Fit:
    if solver == "paper":
        return fit_paper(poses, Model.of(names), spec)
    return fit(poses, Model.of(names))


def specs_of(sensor: Sensor) -> tuple[TriadSpec, TriadSpec]:
    """The data sheets of both triads."""
    return (spec_of(sensor.accelerometer, sensor.accelerometer.full_scale),
            spec_of(sensor.gyroscope, sensor.gyroscope.full_scale))


def pose_sets(
    *sessions: Session, triad: str = "gyroscope"
) -> tuple[PoseSet, PoseSet, tuple[TriadSpec, TriadSpec]]:
    """The accelerometer's and the gyro's poses of sessions with one unit, and their data sheets.

    Where the ``triad`` that is asked for is the accelerometer, its poses stand for the gyro's. A
    run called ``clips`` has a clip, and so a rate of its own, for each pose.
    """
    specs = specs_of(sessions[0].design.sensor)
    gravity_runs, gyro_runs = [], []
    for design, run, stated in (
        (session.design, run, session.rates.get(run.run.name))
        for session in sessions for run in session.runs
    ):
        name, latitude = run.run.name, float(np.radians(design.site.latitude_deg))
        if stated is None:
            means = averaged(run, specs, 0.0)
            gravity_runs.append(gravity_run(name, means, design.site.gravity_m_s2, 0.0))
            if design.rests_count_for_gyroscope:
                gyro_runs.append(stopped_run(name, means, latitude))
        elif triad == "gyroscope":
            means, rate = averaged(run, specs, abs(stated.rate_rad_s)), plate_rate(name, stated)
            each = len(means) if name == "clips" else 1
            gyro_runs.append(turning_run(
                means, replace(rate, rate_rad_s=np.tile(rate.rate_rad_s, each),
                               sd_rad_s=np.tile(rate.sd_rad_s, each)), latitude))
    accelerometer = pose_set("accelerometer", gravity_runs, 0.0)
    if triad == "accelerometer":
        return accelerometer, accelerometer, specs
    base = calibrate_triad(fit(accelerometer, Model.of(BASE)), specs[0])
    gyroscope = pose_set("gyroscope", gyro_runs, 0.0, base.correct) if gyro_runs else accelerometer
    return accelerometer, gyroscope, specs


def tilted_pose_sets(session: Session) -> tuple[PoseSet, PoseSet, tuple[TriadSpec, TriadSpec]]:
    """The poses of both triads of an evening on a plate that leans, and their data sheets.

    The tilt is fitted and the accelerometer calibrated first, as the pipeline does it.
    """
    site, specs = session.design.site, specs_of(session.design.sensor)
    means = [averaged(run, specs, abs(session.rates[run.run.name].rate_rad_s))
             for run in session.runs]
    leaning = NOT_FITTED
    for _ in range(3):
        poses = pose_set("accelerometer", [
            tilted_run(run.run.name, each, site.gravity_m_s2, 0.0, leaning)
            for run, each in zip(session.runs, means, strict=True)], 0.0)
        fitted = fit(poses, Model.of(BASE))
        leaning = leaning_of(fitted)
    base = calibrate_triad(fitted, specs[0])
    latitude = float(np.radians(site.latitude_deg))
    gyroscope = pose_set("gyroscope", [
        turning_run(each, plate_rate(run.run.name, session.rates[run.run.name]), latitude)
        for run, each in zip(session.runs, means, strict=True)], 0.0, base.correct)
    return poses, with_axes(gyroscope, base.fit), specs


def calibrated(
    session: Session, names: Sequence[str] = BASE, solver: str = "default"
) -> Calibrated:
    """Both triads fitted with the model ``names``."""
    accelerometer, gyroscope, specs = pose_sets(session)
    return Calibrated(
        calibrate_triad(_fit(accelerometer, names, specs[0], solver), specs[0]),
        calibrate_triad(_fit(gyroscope, names, specs[1], solver), specs[1]),
    )
