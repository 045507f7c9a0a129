"""Facts: units and the normal distribution."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

RPM = 2 * math.pi / 60  #: rad/s

FASTEST_USUAL = 100 * RPM
"""Fastest usual rate of record players, rad/s; a faster one may be flickering light."""

SD_PER_MAD = 1.4826
"""Sd of a normal distribution over its median absolute deviation."""


def quantile(values: ArrayLike, share: float, axis: int | None = None) -> Any:
    """Quantile, linear between two values; NumPy's imports masked arrays, 25 ms of a short clip.

    Parameters
    ----------
    values : array
    share : float
        0 to 1.
    axis : int, optional
        None for all values.

    Returns
    -------
    float or array
        NaN if a value is NaN, or without values.
    """
    values = np.asarray(values)
    if not values.size:
        return np.nan
    last = (values.size if axis is None else values.shape[axis]) - 1
    low, high = math.floor(share * last), math.ceil(share * last)
    ordered = (np.partition(values, (low, high, last), axis=None) if axis is None else
               np.sort(values, axis=axis))  # along an axis a quarter of the time
    below, above, largest = (np.take(ordered, i, axis=axis) for i in (low, high, last))
    between = below + (share * last - low) * (above - below) if high > low else below
    return np.where(np.isnan(largest), np.nan, between)[()]


def median(values: ArrayLike, axis: int | None = None) -> Any:
    """Median along an axis or of all values."""
    return quantile(values, 0.5, axis)
