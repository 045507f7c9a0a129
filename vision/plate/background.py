"""The stationary background of the first frames of a clip, and the frames used for it."""

import math
from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import quantile
from vision.phase_track import BoolArray
from vision.video.reader import Luma
from vision.video.reduction import reduced

SMALL_SIDE = 300  # pixels at most, by halving; moving objects are larger than one of them
BLURRED = (3, 3)  # pixels
CALM = 0.1  # quantile of the sds of the change that belongs to calm places: a plate leaves corners
OFTEN = 0.75  #: quantile of the largest changes: a mark may be hidden for most of a turn
SMOOTH_PER_ROUGH = 8**-0.5  # fact: sds of white noise, the mean of 9 pixels over the rest
#: Largest noise from frame to frame, in sds of calm places. Derived: 4.4 in 20 000 places of
#: Gaussian noise in three frames of four, 1.7 times the noise in bright places.
BEYOND = 7.5
LEAST = 3.0  # luma steps, blurred: a weaker mark cannot be measured; encoders leave up to 2.7
MEDIAN_OF = 31  # frames; an obstacle in a third of them does not change the median
GOLDEN = (np.sqrt(5) - 1) / 2  #: fraction of the golden ratio: its multiples spread evenly


# Limits for repeated frames.
MOST = 0.5
"""Share of the usual change from frame to frame; a larger change is not a repetition, whatever gap
lies above. Derived: half, with which a plate at half its rate shows."""
GAP = 1.6
"""Least ratio of the two changes beside the widest gap that separates repeats. Tuned on
``tests.bench.clip_study --only pulldown,recorder,plain``."""
NEVER = 0.1  #: share of the usual change; a smaller change is a repetition even without a gap
USUAL = 0.75
"""Quantile of the changes that counts as usual: a camera slower than its clip repeats every other
frame. Derived: above 0.5, below 1."""


def spread_choice(available: int, wanted: int) -> NDArray[np.intp]:
    """Indices spread aperiodically over a range, in order, shape (≤ wanted,).

    An even stride could keep step with the plate (27 frames per turn at 15 fps and 33 1/3 rpm)
    and show the mark always in the same places.
    """
    if available <= wanted:
        return np.arange(available)
    places = (np.mod(np.arange(wanted) * GOLDEN, 1.0) * available).astype(np.intp)
    return np.flatnonzero(np.bincount(places))


def repeated(change: FloatArray) -> BoolArray:
    """Which frames repeat the previous one, from their mean change since it, shape (f,).

    An encoder leaves a varying change in a repeated frame: the widest gap of the changes separates
    the repeats.
    """
    usual = float(quantile(change, USUAL))
    limit = NEVER * usual
    small = change < MOST * usual
    low = np.sort(change[small])
    above = np.append(low[1:], np.min(change, initial=np.inf, where=~small))
    if low.size:
        ratio = above / np.maximum(low, 1e-9)
        widest = int(ratio.argmax())
        if ratio[widest] > GAP and low[widest] > limit:
            limit = float(np.sqrt(low[widest] * above[widest]))
    return np.asarray(change < limit)


def change_over_noise(images: Sequence[Luma]) -> FloatArray:
    """Largest change of every image from the one before over noise, no unit, (f - 1,).

    Where three quarters are below 1 nothing moves: a turning object changes the frames repeatedly,
    a refresh by the encoder only once.

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
        # Differences from pixel to pixel are noise; a flickering lamp does not differ.
        cv2.accumulateSquare(cv2.subtract(change, smooth), square)
    calm = float(quantile(np.sqrt(square / len(largest)), CALM)) * SMOOTH_PER_ROUGH
    return np.array(largest) / max(BEYOND * calm, LEAST)


def halved(image: Luma) -> Luma:
    """Reduced by halves to at most ``SMALL_SIDE`` pixels, shape (h / 2ⁿ, w / 2ⁿ)."""
    halves = max(0, math.ceil(math.log2(max(image.shape) / SMALL_SIDE)))
    return reduced(image, 2**halves)


def every_nth(count: int, nth: int) -> NDArray[np.intp]:
    """Indices (≈ count / nth,) of every n-th frame, shifted by one after each n-th of the stretch.

    If a plate makes a turn in 20 frames, every other frame shows it in ten places only, and a wave
    of ten periods looks stationary.
    """
    index = np.arange(count)
    return np.flatnonzero(index % nth == index * nth // count)


def median_image(images: Sequence[Luma]) -> Luma:
    """Median over time of each pixel, (h, w), from an odd number of frames spread over the time.

    Compare-exchange of whole frames: a thirtieth of the time of sorting pixel by pixel. Of any
    n/2 + 2 values neither the smallest nor the largest is the median of n; both are dropped, the
    next value is added, and so on.
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
