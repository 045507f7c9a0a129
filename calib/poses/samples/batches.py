"""A pose cut into equal stretches: their means, their scatter and their extremes.

A hand, a gimbal or a soft support lets a still sensor turn by some tenths of a degree. Its
gyroscope measures that: the mean over a pose of length T is the bias and Δθ/T, which the scatter
within the pose does not show if it turns steadily. The accelerometer sees two of the three
components, as the change of gravity's direction; the rotation about the vertical is unseen, and is
assumed to be of the same size.
"""

from functools import lru_cache

import numpy as np

from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import FloatArray, IntArray

BATCHES = 6
"""Number of batches of a pose. A judgement: fewer outlast the correlation better, more state the
variance better; six have five degrees of freedom."""

PARTS = 2 * BATCHES
"""Number of parts of a pose. Derived: half a batch each, so that noise which ends within one is
separated from slower noise (:mod:`calib.poses.averaging.correlation`), and motion shows."""

SHORTEST_SAMPLES = PARTS  #: samples of a pose; derived: one in each part


def batch_means(values: FloatArray, count: int) -> FloatArray:
    """Means of ``count`` equal stretches of ``values`` (t, k), in their unit, (count, k)."""
    length = len(values) // count
    return np.asarray(values[: count * length].reshape(count, length, -1).mean(axis=1))


def batch_variance(values: FloatArray, count: int) -> FloatArray:
    """Variance of the mean of ``values`` (t, k) by ``count`` batches, (k,), its unit squared."""
    return np.asarray(batch_means(values, count).var(axis=0, ddof=1) / count)


SEEN_CHI2 = 13.8
"""Chi-square of two components: noise alone exceeds it once in a thousand poses. Derived."""


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
    # Second differences: neither a steady turn nor a step of the attitude affects their noise much.
    second = np.diff(batches, n=2, axis=0)
    of_change = 2 * float(np.median(second**2)) / MEDIAN_OF_NORMAL**2 / 6
    square = float(across @ across)
    if square <= SEEN_CHI2 * of_change:
        return 0.0
    between_s = duration_s * (1 - 1 / len(batches))
    return float(np.sqrt((square - 2 * of_change) / 2)) / size / between_s


STRETCHES = 40
"""Number of stretches of a picture: as many as a chart of a phone's width can show apart."""


def envelope(values: FloatArray) -> FloatArray:
    """Lowest and highest sample of equal stretches: unlike every n-th sample it keeps each spike.

    Parameters
    ----------
    values : array, shape (t, k)

    Returns
    -------
    array, shape (min(t, STRETCHES), 2, k)
        In the same unit.

    Examples
    --------
    >>> envelope(np.arange(80.0)[:, None])[0].ravel()
    array([0., 1.])
    """
    starts = _starts(len(values))
    return np.stack([np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)],
                    axis=1)


@lru_cache(maxsize=16)
def _starts(samples: int) -> IntArray:
    """Starts of the stretches of a pose; the poses of a session have few different lengths."""
    count = min(samples, STRETCHES)
    return np.linspace(0, samples, count, endpoint=False).astype(np.int64)
