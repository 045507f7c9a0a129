"""Tables of means that were put together twice."""

from dataclasses import replace

import pytest

from calib.consistency.repeats import require_no_repeated_means
from calib.errors import Contradiction
from calib.poses.imu_log import Triad
from tests.calib.made_poses import SLOW, made_poses, noisy


@pytest.mark.parametrize(("triad", "copied", "is_refused"), [
    ("accelerometer", 18, True), ("accelerometer", 9, True), ("gyroscope", 18, True),
    ("accelerometer", 1, False), ("accelerometer", 0, False),
])
def test_rows_of_means_that_are_put_together_twice_are_refused(
    triad: Triad, copied: int, is_refused: bool
) -> None:
    speeds = (SLOW,) if triad == "gyroscope" else (0.0,)
    poses = noisy(made_poses(triad, speeds), 3)
    twice = poses.concat(replace(poses.take(range(copied)), run=("again",) * copied))
    if is_refused:
        with pytest.raises(Contradiction, match="the same to the last digit"):
            require_no_repeated_means(twice)
    else:
        require_no_repeated_means(twice)
