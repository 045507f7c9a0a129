"""Polar sampling of a picture about the spindle, in the view of the plate."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, View
from vision.video import Luma

Strips = NDArray[np.float32]  # (pictures, rings, azimuths), or of one picture (rings, azimuths)


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
        1 where the point is inside the picture; where nothing stands in front of it; else 0.
    """

    view: View
    radius: FloatArray
    azimuths: int
    x: Strips
    y: Strips
    inside: Strips
    uncovered: Strips

    def strip(self, picture: Luma) -> Luma:
        """The picture along the rings, shape (r, n)."""
        return np.asarray(cv2.remap(picture, self.x, self.y, cv2.INTER_LINEAR), np.uint8)

    def strips(self, pictures: Sequence[Luma]) -> Strips:
        """Several pictures, in floating point."""
        return np.stack([self.strip(picture) for picture in pictures]).astype(np.float32)

    def moved(self, view: View, shape: tuple[int, ...]) -> "Grid":
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
        """1 where the point is inside the picture and not covered, else 0; shape (r, n)."""
        return self.inside * self.uncovered

    def weight(self) -> NDArray[np.float32]:
        """Pixels of the film per sample of each ring, shape (r,), up to a factor: the radius."""
        return self.radius.astype(np.float32)


def polar_grid(view: View, radius: FloatArray, azimuths: int, shape: tuple[int, ...]) -> Grid:
    """Sampling positions for pictures of the given shape."""
    azimuth = np.arange(azimuths) * 2 * np.pi / azimuths
    x, y = view.pixels(radius[:, None], azimuth[None, :])
    inside = (x >= 0) & (y >= 0) & (x <= shape[1] - 1) & (y <= shape[0] - 1)
    return Grid(
        view,
        radius,
        azimuths,
        x.astype(np.float32),
        y.astype(np.float32),
        inside.astype(np.float32),
        np.ones(x.shape, np.float32),
    )
