"""A pose cut into equal stretches: their means, and what their scatter says of the pose's mean."""

import numpy as np

from calib.poses.imu_log import FloatArray

BATCHES = 6
"""Number of batches of a pose. A judgement: fewer outlast the correlation better, more state the
variance better; six have five degrees of freedom."""

COARSE_BATCHES = BATCHES // 2
"""Derived: twice as long, so that the ratio of both variances shows the correlation
(:func:`calib.poses.averaging.mean_noise.correlation_factor`)."""

SHORTEST_SAMPLES = 2 * BATCHES  #: samples of a pose; derived: two in each batch


def batch_means(values: FloatArray, count: int) -> FloatArray:
    """Means of ``count`` equal stretches of ``values`` (t, k), in their unit, (count, k)."""
    length = len(values) // count
    return np.asarray(values[: count * length].reshape(count, length, -1).mean(axis=1))


def batch_variance(values: FloatArray, count: int) -> FloatArray:
    """Variance of the mean of ``values`` (t, k) by ``count`` batches, (k,), its unit squared."""
    return np.asarray(batch_means(values, count).var(axis=0, ddof=1) / count)
