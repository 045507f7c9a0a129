"""The frames of both triads against each other, of poses that lie beside the spindle."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.fit.least_squares.solver import fit
from calib.fit.triad.frame_alignment import FrameRotation, rotation_between_frames
from calib.poses.imu_log import FloatArray
from tests.calib.made_poses import (
    FAST,
    GRAVITY,
    MODEL,
    SLOW,
    base_theta,
    made_poses,
    read_through,
    with_noise,
)

ANGLES = np.array([0.011, -0.007, 0.004])
LEVER_M = np.array([0.012, -0.008, 0.02])
PLACEMENT_M = 0.002
FORCE_SD = 2e-3
SEEDS = range(25)


def aligned(
    seed: int, speeds: tuple[float, ...] = (SLOW, -SLOW, FAST, 0.0), is_table: bool = False
) -> FrameRotation:
    """The estimate from forces that lean towards the spindle by ``Ω² × distance``.

    A table of means does not tell the vibration.
    """
    rng = np.random.default_rng([seed, 3])
    poses = made_poses("gyroscope", speeds, seed=seed)
    up = poses.force / GRAVITY  # the axis of the plate, in the gyroscope's frame
    away = LEVER_M + PLACEMENT_M * rng.standard_normal(up.shape)
    away -= (away * up).sum(axis=1, keepdims=True) * up
    force = (poses.force - poses.spin_rad_s[:, None] ** 2 * away) @ (
        Rotation.from_rotvec(ANGLES).as_matrix().T)
    force += FORCE_SD * rng.standard_normal(force.shape)
    read = with_noise(read_through(poses, MODEL, base_theta(MODEL, "gyroscope")), rng)
    vibration = np.full(force.shape, np.nan if is_table else 100 * FORCE_SD**2)
    found = rotation_between_frames(fit(replace(read, force=force, vibration=vibration), MODEL))
    assert found is not None
    return found


@pytest.mark.parametrize("is_table", [False, True])
def test_the_angles_err_as_their_sds_say_and_the_lever_comes_back(is_table: bool) -> None:
    every = [aligned(seed, is_table=is_table) for seed in SEEDS]
    pulls: FloatArray = np.array([(one.angles_rad - ANGLES) / one.sd_rad for one in every])
    assert 0.8 < np.sqrt(np.mean(pulls**2)) < 1.2  # of 75, a counting error of 0.08
    levers = np.array([one.lever_m for one in every])
    assert np.abs(levers.mean(axis=0) - LEVER_M).max() < PLACEMENT_M / 2


def test_frames_far_from_parallel_are_found() -> None:
    """A quarter turn is no small angle."""
    poses = made_poses("gyroscope", (SLOW, FAST))
    turn = Rotation.from_rotvec([0.0, 0.0, np.pi / 2])
    found = rotation_between_frames(fit(replace(poses, force=turn.apply(poses.force)), MODEL))
    assert found is not None
    assert np.allclose(found.angles_rad, turn.as_rotvec(), atol=1e-9)


def test_poses_at_rest_show_nothing() -> None:
    poses = made_poses("gyroscope", (SLOW, 0.0))
    force = np.where(poses.spin_rad_s[:, None] == 0, poses.force, np.nan)
    assert rotation_between_frames(fit(replace(poses, force=force), MODEL)) is None
