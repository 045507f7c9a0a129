"""Jumps of the angle by whole frame times: where frames may have been dropped."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD
from vision.phase_track import PlateAngle
from vision.rate.unwrap import LOCAL_STEPS, running_median

SPREAD = (1, 2, 3)  # steps over which an encoder that blends frames spreads a jump
LOCAL_S = 1.0  # over which the usual step is taken, at least
STAYS = 8  # frames on either side of a jump from which its level is read


@dataclass(frozen=True)
class JumpThresholds:
    """What counts as a jump.

    Attributes
    ----------
    clear : float
        Robust sds of a step that a jump must exceed. Derived: one of 10⁴ Gaussian steps exceeds 4,
        and the size of a jump is known to a quarter (``near_whole``): 4 / (1 - 1/4) and a margin.
    near_whole : float
        Frame times, from the nearest whole number of them. Derived: half of the half that lies
        between two neighbours.
    blind : float
        Frames from one that shows its angle to the next; over more of them the angle is carried on
        by the usual rate, which a view that is off by some degrees makes a few per cent too large
        or too small along an arc. Derived: a quarter of a frame time (``near_whole``) at 4 %.
    tidied : float
        Spread of the angles about a jump with its time put back, relative to that without.
    """

    clear: float = 6.0
    near_whole: float = 0.25
    blind: float = 6.0
    tidied: float = 0.6


THRESHOLDS = JumpThresholds()


def frame_jumps(angle: PlateAngle) -> NDArray[np.int64]:
    """Whole frame times by which the angle jumps in each step, shape (u - 1,).

    An encoder that blends frames spreads a jump over two or three steps.
    """
    step, step_s = np.diff(angle.angle_rad), np.diff(angle.time_s)
    # Of a fast camera, more steps: each has all the noise and less of the motion.
    over = max(LOCAL_STEPS, 2 * round(LOCAL_S / angle.frame_s / 2) + 1)
    rate = running_median(step / step_s, over)
    whole = rate * angle.frame_s
    excess = step - rate * step_s  # beyond the usual rate, less the jumps found so far
    excess[np.diff(angle.index) > THRESHOLDS.blind] = 0
    limit = THRESHOLDS.clear * SD_PER_MAD * float(np.median(np.abs(excess)))
    clear = np.abs(whole) > limit
    count = np.zeros(len(step), np.int64)
    for width in SPREAD:
        if width > 1:
            clear &= np.abs(whole) > THRESHOLDS.clear * _level_noise(excess)
        for at, frames in _jumps(excess, np.where(clear, whole, np.inf), width):
            count[at] += frames
            excess[at] -= frames * whole[at]
    return count


def _jumps(excess: FloatArray, whole: FloatArray, width: int) -> list[tuple[int, int]]:
    """Steps that hold whole frame times, and how many, by sums over ``width`` steps.

    A jump backwards is a repeated frame. It has its time: recorders insert it where the camera is
    slower than the clip, and taken out it would leave the plate as much too fast.
    """
    if len(excess) < width:
        return []
    ratio = np.convolve(excess, np.ones(width), "valid")
    ratio /= whole[: len(ratio)]
    count = np.round(ratio).clip(0).astype(int)
    off = np.abs(ratio - count)
    near = np.flatnonzero((off < THRESHOLDS.near_whole) & (count > 0))
    apart: list[int] = []
    for i in near[np.argsort(off[near])]:
        if all(abs(i - other) >= width for other in apart):
            apart.append(int(i))
    steps = [(i + int(np.abs(excess[i : i + width]).argmax()), int(count[i])) for i in apart]
    put_back = excess.copy()
    for i, (at, frames) in zip(apart, steps, strict=True):
        put_back[at] -= frames * whole[i]
    level = np.concatenate([[0.0], np.cumsum(put_back)])
    jumps = []
    for i, (at, frames) in zip(apart, steps, strict=True):
        before, after = level[max(0, i + 1 - STAYS) : i + 1], level[i + width : i + width + STAYS]
        # An angle that jumps there and back, or creeps back, was mismeasured.
        as_measured = np.concatenate([before, after + frames * whole[i]])
        if _spread(np.concatenate([before, after])) < THRESHOLDS.tidied * _spread(as_measured):
            jumps.append((at, frames))
    return jumps


def _spread(values: FloatArray) -> float:
    return float(np.abs(values - np.median(values)).sum())


def _level_noise(excess: FloatArray) -> float:
    """Sd of the level of some frames against that of the next ones, jumps left aside."""
    level = np.concatenate([[0.0], np.cumsum(excess)])
    if len(level) < 2 * STAYS:
        return np.inf
    level = np.median(np.lib.stride_tricks.sliding_window_view(level, STAYS), axis=1)
    # A quarter of Gaussian values lies within 0.3186 sds.
    return float(np.quantile(np.abs(level[STAYS:] - level[:-STAYS]), 0.25)) / 0.3186
