"""Poses that contradict all others are found together, whatever was done to them."""

from dataclasses import replace

import numpy as np
import pytest

from calib.fit.least_squares.solver import fit
from calib.fit.validation.odd_poses import MOST_ODD, left_over, odd_poses, quadric
from calib.poses.imu_log import Triad
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import MODEL, SLOW, made_poses, noisy


def session(triad: Triad, seed: int) -> PoseSet:
    speeds = (SLOW, 0.0) if triad == "gyroscope" else (0.0,)
    return noisy(made_poses(triad, speeds, seed=seed, shared_sd=1e-4), seed)


def spoilt(poses: PoseSet, places: list[int], size: float) -> PoseSet:
    """Readings of some poses that are too long, one the more the later it stands."""
    reading = poses.reading.copy()
    reading[places] *= 1 + size * (1 + np.arange(len(places)))[:, None]
    return replace(poses, reading=reading)


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
@pytest.mark.parametrize("places", [[4], [2, 11], [0, 7, 17]])
@pytest.mark.parametrize("size", [0.1, 0.3, 3.0])
def test_they_are_found_at_any_size(triad: Triad, places: list[int], size: float) -> None:
    for seed in range(2):
        odd = odd_poses(spoilt(session(triad, seed), places, size))
        assert odd is not None
        assert np.flatnonzero(odd).tolist() == places


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_noise_and_too_many_are_none(triad: Triad) -> None:
    for seed in range(5):
        assert odd_poses(session(triad, seed)) is None
    assert len([2, 5, 8, 13]) > MOST_ODD
    assert odd_poses(spoilt(session(triad, 1), [2, 5, 8, 13], 0.3)) is None


def test_without_poses_to_spare_none_can_be_left_out() -> None:
    few = session("accelerometer", 0).take(np.arange(18) < 11)
    assert odd_poses(spoilt(few, [3], 0.3)) is None


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_the_quadric_leaves_what_the_fit_does(triad: Triad) -> None:
    """Not less than noise, and no more than the fit but for what is of second order."""
    for seed in range(5):
        poses = session(triad, seed)
        chi2, dof = left_over(*quadric(poses))
        assert dof == 18 - 9
        assert 0.5 * dof < chi2 + dof
        assert chi2 < 1.1 * fit(poses, MODEL).chi2 + 1
