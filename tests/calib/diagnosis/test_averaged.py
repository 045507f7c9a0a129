"""Sds averaged over what is credible hold where the noise by itself does not tell."""

from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.averaged import averaged
from calib.diagnosis.finding import find
from calib.fit.least_squares.solver import fit
from tests.calib.diagnosis.disturbed import deviations, disturbed_poses
from tests.calib.made_poses import GRAVITY, MODEL


@pytest.mark.parametrize("world", ["wander", "bad pose"])
def test_a_disturbance_that_no_model_has_is_in_the_sds(world: str) -> None:
    z = np.array([deviations(world, seed) for seed in range(50_000, 50_010)])
    alone, average = np.sqrt(np.mean(z**2, axis=(0, 2)))
    assert alone > 1.1 * average
    assert 0.75 < average < 1.2


def test_sound_poses_keep_the_sds_of_their_noise() -> None:
    z = np.array([deviations("clean", seed) for seed in range(12)])
    sds = z[:, 0] / z[:, 1]  # of the average over those by the noise alone
    assert 0.99 <= np.median(sds) < 1.1


def test_what_is_held_of_a_bad_pose_is_what_the_parameters_move_by_without_it() -> None:
    """One pose two hundred sds off, to first order, against a fit without it."""
    poses, _ = disturbed_poses("clean", 5)
    reading = poses.reading.copy()
    reading[7] *= 1 + 200 * poses.sd[7, 0] / GRAVITY
    base = fit(replace(poses, reading=reading), MODEL)
    moved = base.theta - fit(poses.take(np.arange(len(poses)) != 7), MODEL).theta
    held = averaged(find(base).posterior).held
    large = np.abs(moved) > 5 * np.sqrt(np.diag(base.cov))
    assert large.sum() > 2
    assert np.sqrt(np.diag(held))[large] == pytest.approx(np.abs(moved)[large], rel=0.2)
