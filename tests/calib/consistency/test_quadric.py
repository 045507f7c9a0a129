"""The bound by which mistakes are passed over: below every fit, and far above where none helps."""

from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.mistakes import BOUND_SLACK
from calib.consistency.quadric import least_chi2
from calib.consistency.signed_axes import SIGNED_PERMUTATIONS
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.poses.imu_log import Triad
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import MODEL, noisy, rich_poses


def exchanged(poses: PoseSet, matrix: np.ndarray, first: int) -> PoseSet:
    """The axes of all poses from ``first`` on."""
    reading = poses.reading.copy()
    reading[first:] = reading[first:] @ matrix.T
    return replace(poses, reading=reading)


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_no_fit_leaves_less_and_wrong_axes_leave_a_hundred_times_as_much(triad: Triad) -> None:
    poses = noisy(rich_poses(triad), 4)
    whole = fit(poses, MODEL)
    sets = [exchanged(poses, matrix, first) for matrix in SIGNED_PERMUTATIONS[1::9]
            for first in (3, 9)]
    least = least_chi2([poses, *sets])
    assert least[0] < BOUND_SLACK * whole.chi2
    for bound, each in zip(least[1:], sets, strict=True):
        try:
            chi2 = fit(each, MODEL).chi2
        except CalibrationError:
            continue
        assert bound < BOUND_SLACK * chi2
    assert np.median(least[1:]) > 100 * whole.chi2
