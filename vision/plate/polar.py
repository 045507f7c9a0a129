"""Polar sampling of a frame about the spindle, in the view of the plate."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.video.reader import Luma

Strips = NDArray[np.float32]  # (frames, rings, azimuths), or of one frame (rings, azimuths)
Spectra = NDArray[np.complex64]  # (frames, rings, azimuths // 2 + 1)


@dataclass(frozen=True, eq=False)
class Grid:
    """Polar sampling of a view: rings of given radius, evenly spaced azimuths.

    Attributes
    ----------
    view : View
    radius : array, shape (r,)
    azimuths : int
    x, y : array, shape (r, n)
        Pixels of the samples.
    inside, uncovered : array, shape (r, n)
        1 if the point is inside the frame; if nothing covers it; else 0.
    """

    view: PlateView
    radius: FloatArray
    azimuths: int
    x: Strips
    y: Strips
    inside: Strips
    uncovered: Strips

    def strip(self, image: Luma) -> Luma:
        """The frame along the rings, shape (r, n)."""
        return np.asarray(cv2.remap(image, self.x, self.y, cv2.INTER_LINEAR), np.uint8)

    def differences(self, background: Strips, images: Sequence[Luma]) -> Strips:
        """The frames less a background strip, 0 where nothing is visible; shape (f, r, n)."""
        differences = np.empty((len(images), *self.x.shape), np.float32)
        seen = self.seen
        partly = not seen.all()
        for difference, image in zip(differences, images, strict=True):
            np.subtract(self.strip(image), background, out=difference)
            if partly:
                difference *= seen
        return differences

    def moved(self, view: PlateView, shape: tuple[int, ...]) -> "Grid":
        """The same rings in another view; what was covered stays covered."""
        return replace(
            polar_grid(view, self.radius, self.azimuths, shape), uncovered=self.uncovered
        )

    def refined(self, radius: FloatArray, azimuths: int, shape: tuple[int, ...]) -> "Grid":
        """Other rings and azimuths of the same view, covered where this grid is."""
        ring = np.abs(self.radius[None, :] - radius[:, None]).argmin(axis=1)
        column = np.round(np.arange(azimuths) * self.azimuths / azimuths).astype(int)
        uncovered = self.uncovered[ring][:, column % self.azimuths]
        return replace(polar_grid(self.view, radius, azimuths, shape), uncovered=uncovered)

    @property
    def seen(self) -> Strips:
        """1 if the point is inside the frame and not covered, else 0; shape (r, n)."""
        return self.inside * self.uncovered

    def weight(self) -> NDArray[np.float32]:
        """Pixels of the clip per sample of each ring, shape (r,), up to a factor, no unit."""
        return self.radius.astype(np.float32)


def polar_grid(view: PlateView, radius: FloatArray, azimuths: int, shape: tuple[int, ...]) -> Grid:
    """Sampling positions for frames of the given shape."""
    azimuth = np.arange(azimuths) * 2 * np.pi / azimuths
    x, y = view.pixels(radius[:, None], azimuth[None, :])
    inside = (x >= 0) & (y >= 0) & (x <= shape[1] - 1) & (y <= shape[0] - 1)
    return Grid(view, radius, azimuths, x.astype(np.float32), y.astype(np.float32),
                inside.astype(np.float32), np.ones(x.shape, np.float32))


def ring_spectra(strips: Strips) -> Spectra:
    """Fourier coefficients along the rings, orders 0 to n / 2 of an even number n of azimuths."""
    return np.asarray(np.fft.rfft(strips), np.complex64)


def ring_strips(spectra: Spectra, azimuths: int) -> Strips:
    """The strips of such coefficients, the inverse of ``ring_spectra``."""
    return np.asarray(np.fft.irfft(spectra, azimuths), np.float32)


def turns(angle_rad: FloatArray, orders: int) -> Spectra:
    """exp(ikθ), the factors that turn spectra back by the angles, shape (f, 1, orders)."""
    turn = angle_rad[:, None] * (np.arange(orders) / (2 * np.pi))
    turn -= np.rint(turn)  # single precision, which is twenty times as fast, suffices within a turn
    phase = (2 * np.pi * turn).astype(np.float32)
    factors = np.empty((len(angle_rad), 1, orders), np.complex64)
    factors.real[:, 0], factors.imag[:, 0] = np.cos(phase), np.sin(phase)
    return factors
