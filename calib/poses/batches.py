"""A pose cut into equal stretches: their means, and what their scatter says of the pose's mean."""

import numpy as np

from calib.poses.imu_log import FloatArray

BATCHES = 6  #: of a pose: few, so that they outlast the correlation; five degrees of freedom
COARSE_BATCHES = BATCHES // 2
"""Long enough stretches to hold most of the correlation, enough of them to show a scatter."""


def batch_means(values: FloatArray, count: int) -> FloatArray:
    """Means of ``count`` equal stretches of ``values`` (t, k), in their unit, (count, k)."""
    length = len(values) // count
    return np.asarray(values[: count * length].reshape(count, length, -1).mean(axis=1))


def batch_variance(values: FloatArray, count: int) -> FloatArray:
    """Variance of the mean of ``values`` (t, k) by ``count`` batches, (k,), its unit squared."""
    return np.asarray(batch_means(values, count).var(axis=0, ddof=1) / count)
