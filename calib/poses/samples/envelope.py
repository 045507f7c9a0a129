"""The envelope of a pose: what its samples look like, in a few numbers."""

from functools import lru_cache

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray

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
    """Where the stretches of a pose begin; the poses of a session have few different lengths."""
    count = min(samples, STRETCHES)
    return np.linspace(0, samples, count, endpoint=False).astype(np.int64)
