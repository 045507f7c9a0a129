"""Evenings that something disturbs which no model has, and how far off their parameters are."""

from dataclasses import replace

import numpy as np

from calib.assess import assess
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import GRAVITY, SPECS, base_theta, made_poses, read_through
from tests.fitting import pose_sets
from tests.set_trials import design_of, disturbed
from tests.world.session import simulate

WORLDS = ("clean", "coarse", "correlated", "wander", "bad pose", "all")
POSES, POSE_S, WANDER_S = 22, 30.0, 600.0
WANDER_SD, OFF_SD = 2.0, 12.0  #: of a bias, and of a bad pose, in sds of a pose mean
MODEL = Model.of(BASE)
GROUPS = ("misalignment_rad", "bias_counts", "scale_counts_per_unit")


def disturbed_poses(world: str, seed: int) -> tuple[PoseSet, FloatArray]:
    """Poses of one evening and the theta (9,) of it, a bias that wanders at its mean."""
    rng = np.random.default_rng([seed, 771])
    up = rng.standard_normal((26, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    poses = replace(
        made_poses("accelerometer", (0.0,), seed=seed, corners=True),
        reading=GRAVITY * up, force=GRAVITY * up, time_s=POSE_S * np.arange(26),
        columns={"temperature_c": 30 + 0.05 * rng.standard_normal(26)},
    ).take(np.arange(POSES))
    theta = base_theta(MODEL, "accelerometer") * rng.uniform(0.5, 1.5, 9)
    read = read_through(poses, MODEL, theta)
    more = np.zeros((POSES, 3))
    if world in ("wander", "all"):
        apart_s = np.abs(poses.time_s[:, None] - poses.time_s)
        root = np.linalg.cholesky(np.exp(-apart_s / WANDER_S))
        more = WANDER_SD * read.sd * (root @ rng.standard_normal((POSES, 3)))
        theta[:3] += more.mean(axis=0)
    reading = read.reading + more + read.sd * rng.standard_normal((POSES, 3))
    if world in ("bad pose", "all"):
        off, k = rng.standard_normal(3), rng.integers(POSES)
        reading[k] += OFF_SD * read.sd[k] * off / np.linalg.norm(off)
    return replace(read, reading=reading), theta


def deviations(world: str, seed: int) -> FloatArray:
    """(estimate - truth)/sd of nine parameters by the fit alone and by the average, (2, 9)."""
    if world in ("coarse", "correlated"):
        session = simulate(disturbed(design_of("hand", seed), world), seed)
        poses, _, (spec, _) = pose_sets(session)
        truth = np.concatenate([getattr(session.accelerometer, group) for group in GROUPS])
        return np.array([
            (np.concatenate([getattr(each.parameters, group) for group in GROUPS]) - truth)
            / np.concatenate(each.parameters.sd) for each in both(poses, spec)])
    poses, theta = disturbed_poses(world, seed)
    return np.array([(each.fit.theta - theta) / np.sqrt(np.diag(each.fit.cov))
                     for each in both(poses, SPECS["accelerometer"])])


def both(poses: PoseSet, spec: TriadSpec) -> tuple[TriadCalibration, TriadCalibration]:
    """The calibration by the fit alone, and as it is assessed."""
    return (calibrate_triad(fit(poses, MODEL), spec), assess(poses, MODEL, spec).calibration)
