"""Whether the logs of a session keep one clock."""

from collections.abc import Sequence

import numpy as np

from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray


def on_one_clock(means: Sequence[PoseMean]) -> FloatArray:
    """Mid times of poses, s, (n,); NaN where every file starts its own clock: they overlap."""
    time_s = np.array([mean.time_s for mean in means])
    half = np.array([mean.duration_s for mean in means]) / 2
    order = np.argsort(time_s)
    overlap = (time_s - half)[order][1:] < (time_s + half)[order][:-1] - 1e-6  # rounding
    return np.full(len(means), np.nan) if overlap.any() else time_s
