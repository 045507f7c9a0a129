"""The measured quantity of a frame: its brightness, or an axis of colour if that shows nothing.

The colour of a pixel apart from its brightness is a point c = (Cr, Cb) of the chroma plane. Where a
mark of another colour passes, c moves along the line between the two colours, and that line is the
principal axis of the covariance in time, summed over the frame,

    Σ_p (cov_t c_p - N),

with the noise N of a place where nothing moves, the median over the frame. The measured quantity is
the coordinate along the axis, a frame like any other: 128 + a·(c - 128).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from vision.numbers import median
from vision.phase_track import LUMA
from vision.plate.background import spread_choice
from vision.video.reader import Frame, Luma

GREY = 128  # Cr and Cb without colour
MOMENTS_OF = 60  # frames
#: Least strength of an axis, as a share of the strongest. Derived: a third in contrast.
WEAKEST = 0.1


@dataclass(frozen=True)
class Brightness:
    """The luma."""

    def __call__(self, frame: Frame) -> Luma:
        """The frame itself, shape (h, w)."""
        return frame.luma

    def __str__(self) -> str:
        return LUMA


@dataclass(frozen=True)
class ChromaAxis:
    """The coordinate of the colour along a unit vector of the chroma plane."""

    cr: float
    cb: float

    def __call__(self, frame: Frame) -> Luma:
        """The frame of the coordinate, grey at 128, shape (h, w)."""
        cr, cb = cv2.split(frame.chroma)
        grey = GREY * (1 - self.cr - self.cb)
        return np.asarray(cv2.addWeighted(cr, self.cr, cb, self.cb, grey), np.uint8)

    def __str__(self) -> str:
        return f"{self.cr:.2f} Cr {'-' if self.cb < 0 else '+'} {abs(self.cb):.2f} Cb"


Channel = Brightness | ChromaAxis


def axes_of_colour(frames: Sequence[Frame]) -> list[Channel]:
    """The axes of colour along which something moves, the strongest first."""
    chosen = spread_choice(len(frames), MOMENTS_OF)
    mean = np.zeros((*frames[0].chroma.shape[:2], 2), np.float32)
    square = np.zeros((3, *mean.shape[:2]), np.float32)
    for i in chosen:
        cv2.accumulate(frames[i].chroma, mean)
        cr, cb = cv2.split(frames[i].chroma)
        for one, other, product in ((cr, cr, square[0]), (cr, cb, square[1]), (cb, cb, square[2])):
            cv2.accumulateProduct(one, other, product)
    cr, cb = np.moveaxis(mean / len(chosen), -1, 0)
    moments = square / len(chosen) - np.stack([cr * cr, cr * cb, cb * cb])
    of_cr, of_both, of_cb = (float((m - median(m)).sum(dtype=float)) for m in moments)
    moving = np.array([[of_cr, of_both], [of_both, of_cb]])
    strength, axes = np.linalg.eigh(moving)  # ascending
    return [
        ChromaAxis(*(float(a) for a in axis * np.sign(axis[np.abs(axis).argmax()])))
        for size, axis in zip(strength[::-1], axes.T[::-1], strict=True)
        if size > max(0.0, WEAKEST * strength[-1])
    ]
