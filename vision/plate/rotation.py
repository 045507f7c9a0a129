"""Rotation about a proposed axis, if there is any: rough rate in short windows.

No mark, no first guess, no memory of earlier frames: in each window the rate is the one at which
most of the variation adds up coherently (``vision.plate.window_rate``).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import median
from vision.plate.low_orders import Orders
from vision.plate.window_rate import WindowRate

WINDOW = 48  # frames


@dataclass(frozen=True, eq=False)
class CoarseRotation:
    """Rough motion about an axis.

    Attributes
    ----------
    angle_rad : array, shape (f,)
        Plate angle at each frame, zero at the first, continuous.
    coherence : float
        Share of the varying energy that turns together, less the energy that turns equally well
        the other way; median over the windows, 0 to 1.
    clearest : slice
        Frames of the window with the largest coherence. Between windows frames may be missing,
        and the angle with them.
    """

    angle_rad: FloatArray
    coherence: float
    clearest: slice


class RotationSearch:
    """Search for the rough motion of the same frames about several axes in turn.

    Parameters
    ----------
    time_s : array, shape (f,)
    """

    def __init__(self, time_s: FloatArray) -> None:
        frames = len(time_s)
        window = min(WINDOW, frames)
        starts = np.linspace(0, frames - window, max(1, -(-frames // window))).astype(int)
        limit = np.pi / max(float(median(np.diff(time_s))), 1e-4)
        self._time_s = time_s
        self._parts = [slice(start, start + window) for start in starts]
        self._windows = [WindowRate(time_s[part], limit) for part in self._parts]
        self._middles_s = [float(time_s[part].mean()) for part in self._parts]

    def about(self, spectra: Orders, weight: NDArray[np.float32]) -> CoarseRotation:
        """Rough plate angles about an axis.

        Parameters
        ----------
        spectra : array of complex64, shape (orders, r, f)
            Angular orders 1 ... of every ring and frame, in luma steps.
        weight : array, shape (r,)
            Weights of the rings, no unit.
        """
        results = [window.best(spectra[:, :, part], weight)
                   for window, part in zip(self._windows, self._parts, strict=True)]
        rates, shares = np.array(results).T
        rate_at = np.interp(self._time_s, self._middles_s, rates)
        step = 0.5 * (rate_at[1:] + rate_at[:-1]) * np.diff(self._time_s)
        return CoarseRotation(
            np.concatenate([[0.0], np.cumsum(step)]),
            float(median(shares)),
            self._parts[int(shares.argmax())],
        )
