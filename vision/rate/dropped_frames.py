"""Frames that a recorder dropped without a gap in its time stamps: a switching model of the angle.

The rotation beyond the usual rate, r, has a level that wanders slowly and grows by whole frame
times at dropped frames; single frames that are mismeasured, repeated, or blended by an encoder
deviate from it,

    L_i = L_(i-1) + {0 | ±Δ/8 slow wander | nΔ where n frames were dropped},      Δ = Ω T,
    r_i = L_i + {noise | anything, of a stray frame}.

The probabilities of all levels in every frame follow from those before and after it (forward and
backward sums: Rabiner, Proc. IEEE 77, 1989), and with them the probable stray frames. A growing
level does not prove dropped frames: the angle of a plate with little texture at one angle jumps
there too, once per turn, and drifts back. Two things separate them. The error of the angle at each
place of the plate repeats with every turn, so that the time of a turn, t_i - t(θ_i - 2π), is free
of it; if K frames were dropped within the turn, the stamps make it K T too short. So A in

    t_i - t(θ_i - 2π) = P - A T K_i + noise

is 1 for dropped frames and 0 for errors of the angle. And frames are dropped at any angle of the
plate, errors occur at one: the resultant R of n jumps occurs by chance with the probability
exp(-n R²) (Mardia and Jupp, Directional Statistics, 2000, section 6.3). Both together are the odds
of dropped frames.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray, PlateAngle
from vision.rate.unwrap import LOCAL_STEPS, running_median

FEWEST_FRAMES = 6  #: frames one turn after another, to determine a share; a judgement
LEVELS = 8  #: steps of the level in a frame time; numerical
MOST_AT_ONCE = 6  #: largest number of frames dropped, or mismeasured, in one place; a judgement
MOST_DROPPED = 100  #: largest growth of the level in a stretch, frame times; a limit of memory
STRETCH, MARGIN = 480, 32  #: frames that are processed together, and on both sides; numerical
LIKELY = 0.5  #: probability from which a frame counts as stray; definition: likelier than not
POSSIBLE = 0.01  # frames: the prior alone expects fewer dropped ones
SEEN = 0.25  # frame times: if an encoder spreads a jump over three steps, one is larger
SURE = 30.0  # logarithm of odds beyond which nothing changes


@dataclass(frozen=True)
class DroppedFrameThresholds:
    """Prior probabilities, and limits of what the angles can show.

    Attributes
    ----------
    drops : float
        Probability that frames are dropped before a frame. A judgement: one in a thousand.
    wanders : float
        Probability that the level moves an eighth of a frame time up or down. Derived: a frame time
        in 80 frames, the error of a usual rate that is determined over some dozen frames.
    stray, stays : float
        Probability that a frame is stray; that the next one is too. A judgement.
    clear : float
        Least frame time over the noise of a level at which a jump is visible. Derived: half of it
        is then three sds.
    amiss : float
        Sd of the share: with dropped frames one jump in ten may be false, with errors of the angle
        they do not repeat exactly. Measured: 0.87 to 1.00, and -0.03 to 0.19 (300 tracks each of
        ``tests.bench.simulated_tracks``).
    blind : float
        Frames from one that shows its angle to the next; over more of them the angle is continued
        at the usual rate, which a view wrong by some degrees makes a few per cent too large or too
        small along an arc. Derived: a quarter of a frame time at 4 %.
    """

    drops: float = 1e-3
    wanders: float = 0.05
    stray: float = 0.01
    stays: float = 0.5
    clear: float = 6.0
    amiss: float = 0.1
    blind: float = 6.0


THRESHOLDS = DroppedFrameThresholds()


@dataclass(frozen=True, eq=False)
class DroppedFrames:
    """The angle with the time of dropped frames added if that is more probable.

    Attributes
    ----------
    angle : PlateAngle
        Angle with the dropped frames counted, or none.
    stray : array of bool, shape (u,)
        Frames whose angle is likely mismeasured.
    jumps : int
        Total jump of the angle, frame times.
    probability : float
        Probability that frames were dropped, and not the angle mismeasured; 0 without jumps.
    share, share_sd : float
        A of the module's equation; NaN without jumps, sd infinite if not determined.
    at_rad : float
        Mean plate angle of the jumps.
    """

    angle: PlateAngle
    stray: BoolArray
    jumps: int = 0
    probability: float = 0.0
    share: float = np.nan
    share_sd: float = np.inf
    at_rad: float = np.nan

    @property
    def count(self) -> int:
        """Number of dropped frames."""
        return int(self.angle.dropped.sum())

    @property
    def change(self) -> float:
        """Relative change of the rate by the time of all jumps."""
        return self.jumps * self.angle.frame_s / float(np.ptp(self.angle.time_s))

    @property
    def sd_of_rate(self) -> float:
        """Relative sd of the rate, from the change by the less probable of the two causes."""
        return float(np.sqrt(min(self.probability, 1 - self.probability))) * self.change


def dropped_frames(angle: PlateAngle) -> DroppedFrames:
    """Find the frames that were dropped silently.

    Parameters
    ----------
    angle : PlateAngle
        Angle on the stamps unchanged, without dropped frames.
    """
    count, stray = frame_jumps(angle)
    repaired = replace(angle, dropped=count)
    jumps = int(count.sum())
    if not jumps:
        return DroppedFrames(angle, stray)
    share, sd = confirmed_share(repaired)
    resultant = complex(np.exp(1j * angle.angle_rad[count > 0]).mean())
    log_odds = 1 - np.count_nonzero(count) * abs(resultant) ** 2  # 0 on average of uniform angles
    if np.isfinite(sd):
        log_odds += (share - 0.5) / (sd**2 + THRESHOLDS.amiss**2)  # of 1 against 0
    probability = float(1 / (1 + np.exp(-np.clip(log_odds, -SURE, SURE))))
    return DroppedFrames(repaired if probability > 0.5 else angle, stray, jumps, probability, share,
                         sd, float(np.angle(resultant)))


def frame_jumps(angle: PlateAngle) -> tuple[NDArray[np.int64], BoolArray]:
    """Jump of the angle before each frame, whole frame times, and stray frames, (u,) both."""
    step, step_s = np.diff(angle.angle_rad), np.diff(angle.time_s)
    rate = running_median(step / step_s, LOCAL_STEPS)
    blind = np.diff(angle.index) > THRESHOLDS.blind
    per_frame = rate * angle.frame_s
    beyond = np.zeros_like(step)
    np.divide(step - rate * step_s, per_frame, out=beyond, where=~blind & (per_frame != 0))
    noise = SD_PER_MAD * float(median(np.abs(beyond))) / np.sqrt(2)
    expected = np.zeros(len(angle.time_s))
    stray = np.zeros_like(expected)
    if THRESHOLDS.clear * noise > 1:
        return expected.astype(np.int64), stray > LIKELY
    for start in range(0, len(beyond), STRETCH):
        first = max(start - MARGIN, 0)
        part = slice(first, start + STRETCH + MARGIN)
        if beyond[part].max() > SEEN:
            states = _states(beyond[part], max(noise, 0.5 / LEVELS), blind[part])
            for values, shown in zip((expected, stray), states, strict=True):
                values[start + 1 : start + STRETCH + 1] = shown[start - first + 1 :][:STRETCH]
    # Beside a stray frame, the sum of two steps is visible, but not each of them. The contribution
    # of the prior in all frames adds up to no jump.
    count = np.zeros(len(expected), np.int64)
    for first, stop in _runs(expected > POSSIBLE):
        whole = np.round(np.cumsum(expected[first:stop]))
        count[first:stop] = np.diff(whole, prepend=0.0)
    is_stray = stray > LIKELY
    for first, stop in _runs(is_stray):  # a longer run is a plate that changes its rate
        is_stray[first:stop] = stop - first <= MOST_AT_ONCE
    return count, is_stray


def _runs(chosen: BoolArray) -> NDArray[np.intp]:
    """First frame and the one after the last of each run of chosen frames, (runs, 2)."""
    return np.flatnonzero(np.diff(chosen, prepend=False, append=False)).reshape(-1, 2)


def _states(
    beyond: FloatArray, noise: float, blind: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Frames dropped before each frame, (s + 1,), and the probability that it is stray.

    Both are forward and backward sums of the switching model.

    Parameters
    ----------
    beyond : array, shape (s,)
        Steps of the angle beyond the usual rate, in frame times.
    noise : float
        Sd of a frame, in frame times.
    blind : array of bool, shape (s,)
        Steps in which no drop can be seen.
    """
    level = np.concatenate([[0.0], np.cumsum(beyond)])
    highest = min(float(np.ptp(level)), MOST_DROPPED)
    grid = np.arange(-LEVELS, LEVELS * (highest + 1)) / LEVELS + level.min()
    n, g = len(level), len(grid)
    near = np.exp(-0.5 * ((level[:, None] - grid) / noise) ** 2) / (np.sqrt(2 * np.pi) * noise)
    shown = np.stack([near, np.full_like(near, 1 / np.ptp(grid))], axis=1)  # (n, 2, g)
    t = THRESHOLDS
    switch = np.array([[1 - t.stray, t.stray], [1 - t.stays, t.stays]])
    at_once = t.drops / 2.0 ** np.arange(1, MOST_AT_ONCE + 1)

    def moved(p: FloatArray, sign: int, drop: bool) -> FloatArray:
        out = (1 - 2 * t.wanders) * p
        out[:, 1:] += t.wanders * p[:, :-1]
        out[:, :-1] += t.wanders * p[:, 1:]
        if drop:
            for k, chance in enumerate(at_once, start=1):
                by = k * LEVELS
                if by >= g:
                    break
                here, there = (slice(by, None), slice(None, -by))[::sign]
                out[:, here] += chance * p[:, there]
        return out

    forward = np.empty((n, 2, g))
    forward[0] = shown[0] / shown[0].sum()
    for i in range(1, n):
        now = shown[i] * (switch.T @ moved(forward[i - 1], 1, not blind[i - 1]))
        forward[i] = now / now.sum()
    later = np.ones((2, g))
    expected, stray = np.zeros((2, n))
    for i in range(n - 1, 0, -1):
        both = (forward[i] * later).sum(axis=1)
        stray[i] = both[1] / both.sum()
        weighed = switch @ (shown[i] * later)
        later = moved(weighed, -1, not blind[i - 1])
        if not blind[i - 1]:
            for k, chance in enumerate(at_once, start=1):
                by = min(k * LEVELS, g)
                grew = float((forward[i - 1][:, : g - by] * weighed[:, by:]).sum())
                expected[i] += k * chance * grew / float((forward[i - 1] * later).sum())
        later /= later.sum()
    return expected, stray


def confirmed_share(angle: PlateAngle) -> tuple[float, float]:
    """Share A of the candidates that the angles confirm, and its sd.

    Parameters
    ----------
    angle : PlateAngle
        With the candidates counted.

    Returns
    -------
    share, sd : float
        NaN and infinity where the share is not determined.
    """
    turned = np.maximum.accumulate(np.abs(angle.angle_rad - angle.angle_rad[0]))
    later = turned >= 2 * np.pi
    counted = np.cumsum(angle.dropped)
    took, lost = (now[later] - np.interp(turned[later] - 2 * np.pi, turned, now)
                  for now in (angle.time_s, counted))
    between = lost != np.round(lost)  # one turn earlier lies within a jump
    took, lost = took[~between], lost[~between]
    if len(took) < FEWEST_FRAMES or not np.ptp(lost):
        return np.nan, np.inf
    more = lost - lost.mean()
    slope = float(more @ took / (more @ more))
    rest = took - took.mean() - slope * more
    # All frames of a turn see the same jump.
    sd = SD_PER_MAD * float(median(np.abs(rest))) / more.std()
    sd /= np.sqrt(np.count_nonzero(angle.dropped))
    return -slope / angle.frame_s, sd / angle.frame_s
