"""What does not move in the first frames of a clip, and which of the frames are used for that."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.phase_track import BoolArray
from vision.video import Luma

MEDIAN_OF = 31  # frames; something in the way for a third of them leaves the median alone
GOLDEN = (np.sqrt(5) - 1) / 2  #: fraction of the golden ratio: its multiples spread evenly


@dataclass(frozen=True)
class RepeatThresholds:
    """Which frames are the one before again.

    Attributes
    ----------
    change : float
        Of the usual change from frame to frame; less is the same frame again. Tuned on the clips of
        slow cameras in tests.vision.test_clips.
    usual : float
        Quantile of the changes that is the usual one: a camera slower than its clip repeats every
        other frame. Derived: above 0.5, below 1.
    """

    change: float = 0.1
    usual: float = 0.75


THRESHOLDS = RepeatThresholds()


def spread_choice(available: int, wanted: int) -> NDArray[np.intp]:
    """Indices spread over a range without a period, in order, shape (≤ wanted,).

    An even stride could keep step with the plate (27 frames per turn at 15 fps and 33 1/3 rpm)
    and show the mark always in the same places.
    """
    if available <= wanted:
        return np.arange(available)
    return np.unique((np.mod(np.arange(wanted) * GOLDEN, 1.0) * available).astype(np.intp))


def repeated(change: FloatArray) -> BoolArray:
    """Which frames are the one before again, by their mean change since that one, shape (f,)."""
    return np.asarray(change < THRESHOLDS.change * np.quantile(change, THRESHOLDS.usual))


def every_nth(count: int, nth: int) -> NDArray[np.intp]:
    """Every n-th frame, beginning again with the next one after each n-th of the stretch.

    Of a plate that makes a turn in 20 frames, every other one shows it in ten places only, and a
    wave of ten periods as standing still.
    """
    index = np.arange(count)
    return np.flatnonzero(index % nth == index * nth // count)


def median_image(images: Sequence[Luma]) -> Luma:
    """Median over time of each pixel, from a spread choice of the frames.

    Compare-exchange of whole frames: a twentieth of the time of sorting pixel by pixel.
    """
    chosen = [images[i].copy() for i in spread_choice(len(images), MEDIAN_OF)]
    n, spare = len(chosen), np.empty_like(chosen[0])
    for done in range(n // 2 + 1):  # bubble the largest to the end until the middle is in place
        for i in range(n - 1 - done):
            np.minimum(chosen[i], chosen[i + 1], out=spare)
            np.maximum(chosen[i], chosen[i + 1], out=chosen[i + 1])
            chosen[i], spare = spare, chosen[i]
    return np.asarray(chosen[n // 2])
