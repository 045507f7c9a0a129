"""Still intervals in one long log, found relative to the sensor's own noise.

The variance of a sliding window, over the three axes together, is divided by the variance the
triad has when nothing moves. The log itself tells that one: it is the most common value among the
quieter half of the windows. A window is still up to ``STILL_RATIO`` times it; there is no
threshold in counts, and nothing depends on how long or how many the poses are.
"""

import math

import numpy as np

from calib.errors import Undetermined
from calib.poses.imu_log import FloatArray, ImuLog

WINDOW_S = 1.0
"""Long enough that a hand cannot hold still by chance, short against a pose."""

SHORTEST_POSE_S = 1.5
STILL_RATIO = 4.0
"""Twice the noise amplitude at rest. From 4 to 20 the real logs give the same poses."""

MARGIN_S = 0.25
"""Cut off both ends of a stretch: a still window may hold the last of a movement."""


def window_variance(values: FloatArray, window: int) -> FloatArray:
    """Variance of every run of ``window`` samples summed over the axes, shape (t - window + 1,)."""
    centred = values - values.mean(axis=0)
    start = np.zeros((1, values.shape[1]))
    total = np.vstack([start, np.cumsum(centred, axis=0)])
    square = np.vstack([start, np.cumsum(centred**2, axis=0)])
    mean = (total[window:] - total[:-window]) / window
    mean_square = (square[window:] - square[:-window]) / window
    return np.asarray(np.maximum(mean_square - mean**2, 0.0).sum(axis=1))


def quiet_level(variance: FloatArray) -> float:
    """The most common variance among the quieter half: the half-sample mode of its logarithm."""
    positive = variance[variance > 0]
    if positive.size == 0:
        return 0.0
    sample = np.sort(np.log(positive))[: max(1, positive.size // 2)]
    while sample.size > 50:
        half = sample.size // 2
        narrowest = int(np.argmin(sample[half:] - sample[:-half]))
        sample = sample[narrowest : narrowest + half + 1]
    return float(np.exp(np.median(sample)))


def find_still(log: ImuLog) -> list[ImuLog]:
    """The still stretches of a log, in time order, each as a log of its own.

    The accelerometer decides where it was logged, else the gyro.

    Raises
    ------
    Undetermined
        The log is too short, or no stretch of ``SHORTEST_POSE_S`` is still.
    """
    step_s = float(np.median(np.diff(log.time_s)))
    window = max(8, round(WINDOW_S / step_s))
    margin = round(MARGIN_S / step_s)
    shortest = max(window, math.ceil(SHORTEST_POSE_S / step_s))
    if len(log.time_s) < 2 * shortest:
        raise Undetermined(
            f"{log.label}: {len(log.time_s)} samples ({log.time_s[-1] - log.time_s[0]:.1f} s) are "
            f"too few to look for still poses; each pose needs {SHORTEST_POSE_S:g} s or more."
        )
    values = log.accelerometer if log.has("accelerometer") else log.gyroscope
    variance = window_variance(values, window)
    still = variance <= STILL_RATIO * quiet_level(variance)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    poses: list[ImuLog] = []
    free = 0  # a window that is still may begin inside the one before: samples are used once
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        start, stop = max(int(first), free) + margin, int(last) - 1 + window - margin
        if stop - start >= shortest:
            span = f"{log.time_s[start]:.1f}-{log.time_s[stop - 1]:.1f} s"
            poses.append(log.between(start, stop, f"{log.label} {span}"))
            free = stop + margin
    if not poses:
        raise Undetermined(
            f"{log.label}: no stretch of {SHORTEST_POSE_S:g} s or more is still. Let the sensor "
            f"rest untouched for a few seconds in every pose, on a table that nobody leans on."
        )
    return poses
