"""Means of stretches of a log and variances of its windows, from sums computed once.

The sums are of the readings less their mean over the log, so that a variance loses no more than a
few parts in 10⁸ of what the log as a whole scatters within such a stretch.
"""

from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class RunningSums:
    """Sums of the readings (t, 3) and of their squares up to every sample.

    Attributes
    ----------
    centre : array, shape (3,)
        Mean of the log, SI.
    total, square : array, shape (t + 1, 3)
        Sums of what the readings and their squares are beyond it.
    """

    centre: FloatArray
    total: FloatArray
    square: FloatArray

    @classmethod
    def of(cls, values: FloatArray) -> "RunningSums":
        """The sums of readings (t, 3), SI."""
        centre = values.mean(axis=0)
        centred = values - centre
        total, square = np.zeros((2, len(values) + 1, values.shape[1]))
        np.cumsum(centred, axis=0, out=total[1:])
        np.cumsum(np.square(centred, out=centred), axis=0, out=square[1:])
        return cls(centre, total, square)

    def mean(self, start: int, stop: int) -> FloatArray:
        """Mean reading (3,) of the samples ``start`` to ``stop``, SI."""
        return np.asarray(self.centre + (self.total[stop] - self.total[start]) / (stop - start))

    def means(self, edges: IntArray) -> FloatArray:
        """Means between neighbouring ``edges`` (k + 1,), SI, (k, 3)."""
        return self.centre + np.diff(self.total[edges], axis=0) / np.diff(edges)[:, None]

    def window_variance(self, window: int) -> FloatArray:
        """Variance of each window of ``window`` samples, axes summed, SI, (t - window + 1,)."""
        mean = (self.total[window:] - self.total[:-window]) / window
        square = (self.square[window:] - self.square[:-window]) / window
        return np.asarray(np.maximum(square - mean**2, 0.0).sum(axis=1))
