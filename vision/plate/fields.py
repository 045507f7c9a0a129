"""Interlaced frames: two fields of alternate rows, the second half a frame time later.

Where something moves, the rows of the two fields are offset like the teeth of two combs: a row
differs more from its neighbours, which belong to the other field, than from the rows beyond them.
Each field is a separate frame, at twice the rate. The first field of a frame is the one that is
nearer to the previous frame.

Fine print differs from row to row as much as the teeth do. The change to the next frame separates
them: if the fields are half a frame apart, the teeth of both frames together are that change, with
the same sign in every pair of frames; in whole frames they have nothing to do with it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import median
from vision.plate.background import spread_choice
from vision.video.reader import Frame

LOOKED_AT = 6  # pairs of frames
COLUMN_STEP = 4  # every row, and some of the columns
MOVES = 0.98  # quantile of the change beyond which a pixel belongs to what moves


# Limits for interlaced frames.
COMBED = 1.25
"""Change from row to row over that from each row to the next but one, median of pairs of frames.
Derived: 1 in noise, less in any image of one moment, more if the fields differ in time."""
FOLLOWS = 0.27
"""Teeth of two frames over the change between them, median of the pairs. Derived: 1 in fields, 0 in
whole frames, and compression takes the teeth first. Tuned on ``tests.bench.clip_study`` from seed
310000 on: 0.22 at most in 280 films of whole frames, 0.33 at least in finely printed fields."""


@dataclass(frozen=True)
class Interlacing:
    """The rows that come first, 0 for even ones, and the delay of the others, s."""

    first_row: int
    later_s: float

    def fields(self, batches: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
        """Both fields of every frame, in order."""
        for batch in batches:
            yield self.split(batch)

    def split(self, frames: Sequence[Frame]) -> list[Frame]:
        """Both fields of every frame, each as high as the frame."""
        rows = (self.first_row, 1 - self.first_row)
        return [
            replace(frame, time_s=frame.time_s + i * self.later_s, luma=_field(frame.luma, row),
                    chroma=_field(frame.chroma, row) if frame.chroma.size else frame.chroma)
            for frame in frames for i, row in enumerate(rows)
        ]

    def note(self, source: str) -> str:
        """A note for the user on the reading of the clip."""
        return f"{source}: the clip is interlaced; its fields are used as frames of their own."


def interlacing(frames: Sequence[Frame]) -> Interlacing | None:
    """The interlacing of the frames; None if they are not interlaced.

    Parameters
    ----------
    frames : sequence of Frame
        Neighbours in time.
    """
    chosen = spread_choice(len(frames) - 1, LOOKED_AT)
    pairs = [
        tuple(frames[i + k].luma[:, ::COLUMN_STEP].astype(np.float32) for k in (0, 1))
        for i in chosen
    ]
    combed, follows = [], []
    for before, after in pairs:
        size = cv2.blur(cv2.absdiff(after, before), (3, 9))
        place = round(MOVES * (size.size - 1))
        limit = max(float(np.sort(size, axis=None)[place]), 1.0)  # ties are slow to partition
        row, column = np.nonzero(size[2:-2] >= limit)
        change = (after - before)[row + 2, column]
        both = before + after
        tooth = both[row + 2, column] - (both[row + 1, column] + both[row + 3, column]) / 2
        teeth = float((np.where(row % 2, tooth, -tooth) * change).sum())
        follows.append(teeth / max(float((change**2).sum()), 1.0))
        double = 2 * after[row + 2, column]
        near = float(np.abs(double - after[row + 1, column] - after[row + 3, column]).sum())
        far = float(np.abs(double - after[row, column] - after[row + 4, column]).sum())
        combed.append(near / max(far, 1.0))
    beside = abs(abs(median(follows)) - 1)  # of a codec that holds frames, far above 1
    if median(combed) <= COMBED and beside >= 1 - FOLLOWS:
        return None
    # The later field is farther from the previous frame.
    odd_later, even_later = (
        sum(float(np.abs(_field(after, row) - _field(before, 1 - row)).sum())
            for before, after in pairs)
        for row in (0, 1))
    steps = np.array([b.time_s - a.time_s for a, b in pairwise(frames)])
    # The last field of a frame is followed by the first of the next.
    return Interlacing(int(even_later < odd_later), float(median(steps)) / 2)


def _field(image: NDArray[np.uint8] | NDArray[np.float32], row: int) -> NDArray[np.uint8]:
    """The even or odd rows, with rows in between interpolated, shape (h, w)."""
    h, w = image.shape[:2]
    rows: FloatArray = np.array([[1.0, 0.0, 0.0], [0.0, 0.5, -0.5 * row]])
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(np.ascontiguousarray(image[row::2]), rows, (w, h), flags=how,
                                     borderMode=cv2.BORDER_REPLICATE))
