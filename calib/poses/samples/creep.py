"""How fast a pose at rest gave way, from the direction of gravity in it.

A hand, a gimbal or a soft support lets a still sensor turn by some tenths of a degree. Its
gyroscope reads that: the mean over a pose of length T is the bias and Δθ/T, which no scatter within
the pose shows where it turns steadily. The accelerometer sees two of the three components, as the
change of gravity's direction; about the vertical the pose turns unseen, and is taken to turn alike.
"""

import numpy as np

from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import FloatArray

SEEN_CHI2 = 13.8
"""Chi-square of two components: noise alone makes as much once in a thousand poses. Derived."""


def creep_rate(batches: FloatArray, duration_s: float) -> float:
    """Rate (rms over the axes) at which a pose at rest turned, rad/s; 0 where noise explains it.

    Parameters
    ----------
    batches : array, shape (b, 3)
        Means of the specific force over b >= 4 equal stretches of the pose.
    duration_s : float
        Of the pose.
    """
    mean = batches.mean(axis=0)
    size = float(np.linalg.norm(mean))
    if not np.isfinite(size) or size == 0.0 or duration_s <= 0:
        return 0.0
    up = mean / size
    change = batches[-1] - batches[0]
    across = change - up * (up @ change)
    # Second differences: neither a steady turn nor a step of the attitude enters their noise much.
    second = np.diff(batches, n=2, axis=0)
    of_change = 2 * float(np.median(second**2)) / MEDIAN_OF_NORMAL**2 / 6
    square = float(across @ across)
    if square <= SEEN_CHI2 * of_change:
        return 0.0
    between_s = duration_s * (1 - 1 / len(batches))
    return float(np.sqrt((square - 2 * of_change) / 2)) / size / between_s
