"""The low angular orders of all frames about any proposed axis.

The first few orders show whether something turns about an axis (``vision.plate.rotation``), and
a reduced frame has enough pixels for them. The values of a pixel in all frames are contiguous, so a
sample on a ring, bilinear between four pixels, is taken from all frames at once:

    F_k(r, t) = 1/n Σ_j P(r, φ_j, t) exp(-ikφ_j),        φ_j = 2πj/n.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.plate.background import halved
from vision.video.reader import Luma

AZIMUTHS = 64  #: per ring, eight in a wave of the highest order
ORDERS = 8  #: number of angular orders 1 ... in the sums

Orders = NDArray[np.complex64]  # (orders, rings, frames)


class PixelSeries:
    """Values of every pixel of reduced frames over time.

    Parameters
    ----------
    images : sequence of arrays of uint8, shape (h, w)
    """

    def __init__(self, images: Sequence[Luma]) -> None:
        small = np.stack([halved(image) for image in images])
        self._shape = small.shape[1:]
        self._factor = images[0].shape[1] // small.shape[2]
        self._series = np.ascontiguousarray(small.reshape(len(small), -1).T)  # (pixels, frames)

    def low_orders(self, view: PlateView, radius: FloatArray) -> Orders:
        """Fourier coefficients 1 to ``ORDERS`` along rings about the spindle of a view.

        Parameters
        ----------
        view : PlateView
        radius : array, shape (r,)
            In plate radii.

        Returns
        -------
        array of complex64, shape (orders, r, f)
            In luma steps; places outside the frame count as dark.
        """
        azimuth = np.arange(AZIMUTHS) * 2 * np.pi / AZIMUTHS
        strips = self._strips(*view.pixels(radius[:, None], azimuth))
        strips = strips.reshape(len(radius), AZIMUTHS, -1)
        wave = np.exp(-1j * np.outer(np.arange(1, ORDERS + 1), azimuth)) / AZIMUTHS
        spectra = np.empty((ORDERS, len(radius), strips.shape[-1]), np.complex64)
        spectra.real = (wave.real.astype(np.float32) @ strips).swapaxes(0, 1)
        spectra.imag = (wave.imag.astype(np.float32) @ strips).swapaxes(0, 1)
        return spectra

    def _strips(self, x: FloatArray, y: FloatArray) -> NDArray[np.float32]:
        """The values at pixels of the clip in every frame, shape (samples, f)."""
        h, w = self._shape
        middle = (self._factor - 1) / 2
        x, y = (x.ravel() - middle) / self._factor, (y.ravel() - middle) / self._factor
        inside = (x >= 0) & (y >= 0) & (x <= w - 1) & (y <= h - 1)
        column = np.clip(x, 0, w - 1).astype(np.intp).clip(max=w - 2)
        row = np.clip(y, 0, h - 1).astype(np.intp).clip(max=h - 2)
        across, down = x - column, y - row
        strips = np.zeros((len(x), self._series.shape[1]), np.float32)
        for right, below, share in (
            (0, 0, (1 - across) * (1 - down)), (1, 0, across * (1 - down)),
            (0, 1, (1 - across) * down), (1, 1, across * down),
        ):
            values = self._series[(row + below) * w + column + right]
            strips += values * np.where(inside, share, 0).astype(np.float32)[:, None]
        return strips
