"""Cause of the changes in a film without a plate: the whole view, or something in it.

From a frame I to a frame J a little later a change of the light, and a camera that shifts,
approaches and rolls, change the pixel at x by

    J - I = a I + c - (b + z x + ω x⊥)·∇I,

six numbers for all pixels, by least squares. The share of the change that they explain identifies
the cause; a camera moves every place that has edges, an object in front of it only some. If one
motion explains most of the change but few places follow it, then, with each pixel weighted by its
change, b is the motion of a passing object.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import NoPlate, OnlyShifts, RateRefused, TooShortToReturn
from vision.geometry import FloatArray
from vision.image_return import LATEST
from vision.numbers import SD_PER_MAD, median, quantile
from vision.plate.background import spread_choice
from vision.tracking.stretch import LEARN_FOR_S
from vision.video.reader import Luma
from vision.video.reduction import reduced

BLUR = 1.5  #: pixels, sd, for the slopes of edges
SIDE = 64  # pixels at most: an object that moves by one per frame crosses the view in 2.5 s
LAGS = (1, 2, 4, 8, 16)  # frames from one to the other, for fast and slow motions
PAIRS = 40  #: pairs of frames with each lag; a limit of time
LEAST_SD = 0.2  # luma steps: the noise of pixels that rounding keeps still
CALM = 0.1  # quantile of the change from frame to frame that counts as noise
CLEAR = 3.0  # sds of noise, least change of a place by the motion of a camera


# Limits for naming the cause of a change.
MOSTLY = 0.5  #: share of the change that one cause explains. Derived: half
GOES_WITH = 0.7
"""Share of the places with edges that follow a moving camera. Tuned on kinds of film without a
rate: 0.78 and more for a camera, 0.28 and less for an object that passes in front of it."""
MUCH = 0.03
"""Least share of the picture that varies beyond noise by a motion without repetition. As much as
the blocks of ``vision.image_return``."""
STRAIGHT = 0.9
"""Net displacement over path length of a passing object. Derived: a mark on a plate that makes a
quarter of a turn."""
ACROSS = 0.5
"""Its path over the longer side of the view. Derived: no mark of a plate in the view moves as far
in a quarter of a turn."""
STEPS = 0.1
"""Share of the frames with half of all change, and of that change the share that goes on in the
frames before and after, if the picture is still in between. Derived: a tenth; an even motion
changes half in half of them, and a hand as much in the frames beside."""


@dataclass(frozen=True, eq=False)
class _Motion:
    """Causes of the change between pairs of frames that are some frames apart.

    Shares: of light and camera together, of the places that follow the camera, and of a passing
    object. The camera's shift, approach and roll per frame, (3,), in pixels at the
    edge; the path per frame and the straightness of the passing object.
    """

    together: float
    goes_with: float
    passes: float
    camera_px: FloatArray
    way_px: float
    straight: float


def what_changes(
    frames: Sequence[Luma], time_s: FloatArray, pixel: float
) -> RateRefused:
    """A refusal that names the cause of the changes.

    Parameters
    ----------
    frames : sequence of arrays of uint8, shape (h, w)
        Small frames, in which nothing returns.
    time_s : array, shape (f,)
    pixel : float
        Pixels of the clip per pixel of these frames.
    """
    lasts_s = float(np.ptp(time_s))
    factor = -(-max(frames[0].shape) // SIDE)
    small = np.stack([np.asarray(cv2.GaussianBlur(reduced(frame, factor), (0, 0), BLUR), np.uint8)
                      for frame in frames])
    change = np.abs(np.diff(small.astype(np.float32), axis=0))
    second = np.abs(small[2:].astype(np.float32) - 2.0 * small[1:-1] + small[:-2])
    noise = SD_PER_MAD * median(second, axis=0) / np.sqrt(6) + LEAST_SD
    motions = [_motion(small, noise, lag) for lag in LAGS if lag < len(small)]
    best = max(motions, key=lambda motion: motion.together)
    per_s = len(time_s) / lasts_s
    much = small.std(axis=0) > CLEAR * median(noise)
    if much.mean() < MUCH:
        return RateRefused(f"nothing in the picture repeats within its {lasts_s:.1f} s")
    energy = (change**2).sum(axis=(1, 2))
    # Both exceed the noise of a pair: this one where everything moves, that one where a part does.
    energy = np.maximum(energy - min(2 * (noise**2).sum(), quantile(energy, CALM)), 0)
    by_size = np.argsort(-energy)
    half = np.searchsorted(np.cumsum(energy[by_size]), MOSTLY * energy.sum()) + 1
    steps, around = by_size[:half], np.minimum(np.roll(energy, 1), np.roll(energy, -1))
    if (half < STEPS * len(energy)
            and around[steps].sum() < STEPS * energy[steps].sum()):
        return NoPlate(f"the picture changes in steps and stands still between them: half of all "
                       f"change is in {half} of {len(energy)} frames; a plate turns on evenly")
    moves = [motion for motion in motions if motion.together > MOSTLY]
    if moves and min(motion.goes_with for motion in moves) > GOES_WITH:
        which = int(np.abs(best.camera_px).argmax())
        at_edge = float(abs(best.camera_px[which])) * per_s
        how = (f"shifts by {at_edge * factor * pixel:.0f} px",
               f"grows or shrinks by {2 * at_edge / SIDE:.1%}",
               f"turns by {np.degrees(2 * at_edge / SIDE):.0f}°")[which]
        return OnlyShifts(f"the camera moves, or what fills its view: all that it sees {how} or so "
                          f"per second, and nothing in the frame turns about a fixed axis")
    passing = max(motions, key=lambda motion: motion.passes)
    way = passing.way_px * len(time_s)
    if (passing.passes > MOSTLY and passing.straight > STRAIGHT
            and way > ACROSS * max(small.shape[1:])):
        speed = passing.way_px * per_s * factor * pixel
        return OnlyShifts(f"what moves in the picture passes by in one direction, at about "
                          f"{speed:.0f} px per second, and nothing in the frame turns about a "
                          f"fixed axis")
    y, x = (factor * pixel * float(np.mean(at)) for at in np.nonzero(much))
    # In a short clip a slow plate does not return twice, and may be there nevertheless.
    kind = NoPlate if LATEST * lasts_s > LEARN_FOR_S else TooShortToReturn
    return kind(f"what changes, {much.mean():.0%} of the picture around ({x:.0f}, {y:.0f}) px, "
                f"repeats nothing within its {lasts_s:.1f} s")


def _motion(small: NDArray[np.uint8], noise: FloatArray, lag: int) -> _Motion:
    h, w = small.shape[1:]
    y, x = (np.mgrid[1 : h - 1, 1 : w - 1] - np.array([h - 1, w - 1])[:, None, None] / 2) / (w / 2)
    clear = CLEAR * noise[1:-1, 1:-1].ravel()
    of_all = together = of_weighed = by_passing = 0.0
    places = going = 0
    camera, ways = [], []
    for i in spread_choice(len(small) - lag, PAIRS):
        before, after = small[[i, i + lag]].astype(np.float64)
        mean = (before + after) / 2
        changed = (after - before)[1:-1, 1:-1].ravel()
        right = (mean[1:-1, 2:] - mean[1:-1, :-2]) / 2
        down = (mean[2:, 1:-1] - mean[:-2, 1:-1]) / 2
        rows = np.stack([mean[1:-1, 1:-1], np.ones_like(right), -right, -down,
                         -(right * x + down * y), -(down * x - right * y)]).reshape(6, -1).T
        beta = np.linalg.lstsq(rows.T @ rows, rows.T @ changed)[0]
        explained = rows @ beta
        of_all += float(changed @ changed)
        together += float(changed @ explained)
        seen = np.abs(explained) > clear
        places += int(seen.sum())
        going += int((np.abs(changed - explained) < np.abs(changed))[seen].sum())
        camera.append([np.hypot(*beta[2:4]), beta[4], beta[5]])
        weight = np.sqrt(np.abs(changed))
        shift, weighed = rows[:, 2:4] * weight[:, None], changed * weight
        way = np.linalg.lstsq(shift.T @ shift, shift.T @ weighed)[0]
        of_weighed += float(weighed @ weighed)
        by_passing += float(weighed @ (shift @ way))
        ways.append(way * np.sqrt(weighed @ weighed))
    gone, net = float(np.hypot(*np.transpose(ways)).sum()), float(np.hypot(*np.sum(ways, axis=0)))
    return _Motion(
        together=together / max(of_all, 1e-9),
        goes_with=going / max(places, 1), passes=by_passing / max(of_weighed, 1e-9),
        camera_px=np.asarray(median(np.array(camera), axis=0)) / lag,
        way_px=net / lag / max(float(np.sqrt(of_weighed * len(ways))), 1e-9),
        straight=net / max(gone, 1e-9))
