"""The jumps of a plate's angle against its frames' times, and how probable the angles are.

The rotation beyond the usual rate, in frame times, has a level that wanders slowly and leaps; a
single frame that is mismeasured, repeated, or blended by an encoder deviates from it,

    L_i = L_(i-1) + {0 | ±1/8 slow wander | anything, a jump},
    r_i = L_i + {noise | anything, of a stray frame}.

The levels of all frames together that are the most probable, and the logarithm of that probability,
follow from one pass forward and one back (Viterbi: Rabiner, Proc. IEEE 77, 1989).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray, PlateAngle
from vision.rate.unwrap import LOCAL_STEPS, running_median

LEVELS = 8  #: steps of the level in a frame time; numerical
MOST_AT_ONCE = 6  #: frames that an encoder blends, or that are mismeasured, in one place; judgement
SPREAD = 2  #: frames on either side of a jump that an encoder blends; a judgement
MOST_CELLS = 5e7  #: frames times levels; a limit of memory


# Prior probabilities, and a limit of what the angles can show.
JUMPS = 1e-3  #: probability of a jump before a frame. A judgement: one in a thousand
WANDERS = 0.05
"""Probability that the level moves an eighth of a frame time up or down. Derived: a frame time in
80 frames, the error of a usual rate that is determined over some dozen frames."""
STRAY = 0.01  #: probability that a frame is stray. A judgement
BLIND = 6.0
"""Frames from one that shows its angle to the next; over more of them the angle is continued at the
usual rate, which a view wrong by some degrees makes a few per cent too large or too small along an
arc. Derived: a quarter of a frame time at 4 %."""


@dataclass(frozen=True, eq=False)
class AngleLevels:
    """The most probable jumps.

    Attributes
    ----------
    jumps : array of int, shape (j,)
        First frame after each jump, among the usable ones.
    stray : array of bool, shape (u,)
        Frames whose angle is likely mismeasured, or within a jump.
    log_probability : float
        Of the angles, per radian of each; comparable for the same frames at other times.
    """

    jumps: NDArray[np.intp]
    stray: BoolArray
    log_probability: float


def angle_levels(angle: PlateAngle) -> AngleLevels:
    """Find the jumps of an angle on its times."""
    step, step_s = np.diff(angle.angle_rad), np.diff(angle.time_s)
    rate = running_median(step / step_s, LOCAL_STEPS)
    blind = np.diff(angle.index) > BLIND
    per_frame = rate * angle.frame_s
    beyond = np.zeros_like(step)
    np.divide(step - rate * step_s, per_frame, out=beyond, where=~blind & (per_frame != 0))
    noise = max(SD_PER_MAD * float(median(np.abs(beyond))) / np.sqrt(2), 0.5 / LEVELS)
    above = np.concatenate([[0.0], np.cumsum(beyond)])
    stray = np.zeros(len(above), bool)
    if np.ptp(above) * LEVELS * len(above) > MOST_CELLS:
        return AngleLevels(np.zeros(0, np.intp), stray, -np.inf)
    level, stray, log_probability = _most_probable(above, noise, blind)
    moves = np.flatnonzero(np.abs(np.diff(level, prepend=level[0])) > 1.5 / LEVELS)
    jumps = []
    for together in np.split(moves, np.flatnonzero(np.diff(moves) > MOST_AT_ONCE) + 1):
        if len(together):  # one jump, that an encoder spreads, or there and back
            first, last = together[[0, -1]]
            stray[first:last] = True
            if abs(level[last] - level[first - 1]) > 1.5 / LEVELS:
                jumps.append(last)
    step_rad = max(abs(float(median(per_frame))), np.finfo(float).tiny)
    return AngleLevels(np.array(jumps, np.intp), stray,
                       log_probability - len(above) * float(np.log(step_rad)))


def _most_probable(
    above: FloatArray, noise: float, blind: BoolArray
) -> tuple[FloatArray, BoolArray, float]:
    """Level of each frame, frame times, stray frames, (n,) both, and the log of the probability.

    Parameters
    ----------
    above : array, shape (n,)
        Angle beyond the usual rate, frame times.
    noise : float
        Sd of a frame, frame times.
    blind : array of bool, shape (n - 1,)
        Steps in which no jump can be seen.
    """
    grid = np.arange(np.floor(LEVELS * above.min()), np.ceil(LEVELS * above.max()) + 1) / LEVELS
    n, g = len(above), len(grid)
    wander, jump = np.log(WANDERS), np.where(blind, -np.inf, np.log(JUMPS / g))
    stray = np.log(STRAY / max(np.ptp(grid), 1.0))
    density = -np.log(np.sqrt(2 * np.pi) * noise)
    came, top = np.empty((n, g), np.int8), np.empty(n, np.intp)
    score = np.zeros(g)
    reached = np.full((4, g), -np.inf)
    for i in range(n):
        if i:
            top[i] = score.argmax()
            reached[0] = score
            reached[1, 1:] = score[:-1] + wander
            reached[2, :-1] = score[1:] + wander
            reached[3] = score[top[i]] + jump[i - 1]
            came[i] = reached.argmax(axis=0)
            score = reached.max(axis=0)
        score = score + np.maximum(density - 0.5 * ((above[i] - grid) / noise) ** 2, stray)
    at = int(score.argmax())
    levels = np.empty(n, np.intp)
    for i in range(n - 1, -1, -1):
        levels[i] = at
        at = (at, at - 1, at + 1, int(top[i]))[came[i, at]] if i else at
    level = grid[levels]
    return level, density - 0.5 * ((above - level) / noise) ** 2 < stray, float(score.max())
