"""What does not move in the first frames of a clip, and which of the frames are used for that."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import quantile
from vision.phase_track import BoolArray
from vision.video.reader import Luma
from vision.video.reduction import reduced

SMALL_SIDE = 300  # pixels at most, by halving; what moves is larger than one of them
BLURRED = (3, 3)  # pixels
CALM = 0.1  # quantile of the sds of the change that is that of calm places: a plate leaves corners
OFTEN = 0.75  # quantile of the largest changes: a mark may be out of sight for most of a turn
SMOOTH_PER_ROUGH = 8**-0.5  # fact: sds of white noise, the mean of 9 pixels over what is beyond it
#: Largest change from frame to frame that is noise, sds of that of calm places. Derived: 4.4 in
#: 20 000 places of Gaussian noise in three frames of four, 1.7 times the noise in bright places.
BEYOND = 7.5
LEAST = 3.0  # luma steps, blurred: a mark of no more cannot be measured; encoders leave up to 2.7
MEDIAN_OF = 31  # frames; something in the way for a third of them leaves the median alone
GOLDEN = (np.sqrt(5) - 1) / 2  #: fraction of the golden ratio: its multiples spread evenly


@dataclass(frozen=True)
class RepeatThresholds:
    """Which frames are the one before again.

    Attributes
    ----------
    most : float
        Of the usual change from frame to frame; more is no repetition, whatever gap lies above.
        Derived: half, with which a plate at half its rate shows.
    gap : float
        Ratio of the two changes beside the widest gap, from which it separates repeats. Tuned on
        ``tests.bench.clip_study --only pulldown,recorder,plain``.
    never : float
        Of the usual change; less is a repetition without a gap too.
    usual : float
        Quantile of the changes that is the usual one: a camera slower than its clip repeats every
        other frame. Derived: above 0.5, below 1.
    """

    most: float = 0.5
    gap: float = 1.6
    never: float = 0.1
    usual: float = 0.75


THRESHOLDS = RepeatThresholds()


def spread_choice(available: int, wanted: int) -> NDArray[np.intp]:
    """Indices spread over a range without a period, in order, shape (≤ wanted,).

    An even stride could keep step with the plate (27 frames per turn at 15 fps and 33 1/3 rpm)
    and show the mark always in the same places.
    """
    if available <= wanted:
        return np.arange(available)
    places = (np.mod(np.arange(wanted) * GOLDEN, 1.0) * available).astype(np.intp)
    return np.flatnonzero(np.bincount(places))


def repeated(change: FloatArray) -> BoolArray:
    """Which frames are the one before again, by their mean change since that one, shape (f,).

    An encoder leaves something of its own in a repeated frame, more or less of it: repeats are told
    by the widest gap of the changes.
    """
    usual = float(quantile(change, THRESHOLDS.usual))
    limit = THRESHOLDS.never * usual
    small = change < THRESHOLDS.most * usual
    low = np.sort(change[small])
    above = np.append(low[1:], np.min(change, initial=np.inf, where=~small))
    if low.size:
        ratio = above / np.maximum(low, 1e-9)
        widest = int(ratio.argmax())
        if ratio[widest] > THRESHOLDS.gap and low[widest] > limit:
            limit = float(np.sqrt(low[widest] * above[widest]))
    return np.asarray(change < limit)


def stands_still(images: Sequence[Luma]) -> bool:
    """Whether nothing changes but by the noise of the camera.

    What turns changes the frames again and again, what an encoder renews does so once.

    Parameters
    ----------
    images : sequence of arrays of uint8, shape (h, w)
        In the order of time, two at least.
    """
    small = [halved(image) for image in images]
    square, largest = np.zeros(small[0].shape, np.float32), []
    for before, after in pairwise(small):
        change = cv2.subtract(after, before, dtype=cv2.CV_32F)
        smooth = cv2.blur(change, BLURRED)
        largest.append(cv2.norm(smooth, cv2.NORM_INF))
        # What differs from pixel to pixel is noise; a lamp that flickers does not.
        cv2.accumulateSquare(cv2.subtract(change, smooth), square)
    calm = float(quantile(np.sqrt(square / len(largest)), CALM)) * SMOOTH_PER_ROUGH
    return float(quantile(largest, OFTEN)) < max(BEYOND * calm, LEAST)


def halved(image: Luma) -> Luma:
    """Reduced by halves to at most ``SMALL_SIDE`` pixels, shape (h / 2ⁿ, w / 2ⁿ)."""
    halves = max(0, math.ceil(math.log2(max(image.shape) / SMALL_SIDE)))
    return reduced(image, 2**halves)


def every_nth(count: int, nth: int) -> NDArray[np.intp]:
    """Indices (≈ count / nth,) of every n-th frame, a frame later after each n-th of the stretch.

    Of a plate that makes a turn in 20 frames, every other one shows it in ten places only, and a
    wave of ten periods as standing still.
    """
    index = np.arange(count)
    return np.flatnonzero(index % nth == index * nth // count)


def median_image(images: Sequence[Luma]) -> Luma:
    """Median over time of each pixel, (h, w), from an odd number of frames spread over the time.

    Compare-exchange of whole frames: a thirtieth of the time of sorting pixel by pixel. Of any
    n/2 + 2 values neither the smallest nor the largest is the median of n; both are let go, the
    next value is taken in, and so on.
    """
    chosen = spread_choice(len(images), MEDIAN_OF)
    chosen = chosen[: len(chosen) - (len(chosen) + 1) % 2]
    first = len(chosen) // 2 + 2
    held = [images[i].copy() for i in chosen[:first]]
    spare = np.empty_like(held[0])
    for following in (*chosen[first:], None):
        last, middle = len(held) - 1, len(held) // 2
        pairs = [(i, last - i) for i in range(middle)]  # the smallest is now in the first half
        pairs += [(0, i) for i in range(1, last - middle + 1)]
        pairs += [(i, last) for i in range(middle, last)]
        for low, high in pairs:
            np.minimum(held[low], held[high], out=spare)
            np.maximum(held[low], held[high], out=held[high])
            held[low], spare = spare, held[low]
        held = held[1:last] if last > 1 else held[:1]
        if following is not None:
            held.append(images[following].copy())
    return np.asarray(held[0])
