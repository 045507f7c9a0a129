"""Three more ways to the rate, none as exact, that would show if the first went wrong.

The count of frames between alignments, the return of the frames after whole turns, and a return of
what does not return with them. They use the time stamps as they are, without the time of dropped
frames, and are compared with the rate on these, not averaged with it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.image_return import (
    ABOUT,
    FEWEST_RETURNS,
    ImageReturn,
    autocorrelation,
    fitted_period,
    other_return,
    returns_near,
)
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.unwrap import frame_time

END_SD = 1 / np.sqrt(6.0)  # frames: the difference of two ends rounded to whole frames
LONGEST = 4000  # frames that are correlated
EVEN = 0.05  # of the frame time: stamps nearer to a grid are evenly spaced


@dataclass(frozen=True)
class CrossCheckThresholds:
    """What counts as an alignment or a return, and when a return disagrees with the rate.

    Attributes
    ----------
    gap : float
        Frame times between the frames before and after an alignment; more is a gap in which nobody
        sees the alignment. Derived: between one and two.
    clear_peak : float
        Correlation that the return of the image must reach.
    apart : float
        Sds. Derived: five, beyond every chance.
    matters : float
        Relative difference that matters. Fact: the lag's own bias where the frames change during
        the clip (``tests.bench.vision_films``).
    """

    gap: float = 1.5
    clear_peak: float = 0.25
    apart: float = 5.0
    matters: float = 2e-3


THRESHOLDS = CrossCheckThresholds()


@dataclass(frozen=True, eq=False)
class FrameCount:
    """Rate from counted frames.

    Attributes
    ----------
    rate_rad_s, sd_rad_s : float
        Positive, rad/s.
    alignments : array of int, shape (m,)
        Frames in which the marks are aligned.
    """

    rate_rad_s: float
    sd_rad_s: float
    alignments: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class CrossChecks:
    """The rate by other ways, on the time stamps as they are.

    Attributes
    ----------
    by_stamps_rad_s : float
        The measured rate on these stamps, positive.
    frame_count : FrameCount or None
        None with fewer than two alignments of the marks.
    lag : ImageReturn or None
        None where the frames have no clear return or the stamps are not evenly spaced.
    second : ImageReturn or None
        Of something else that turns.
    apart_rad_s : float
        How far the return of the frames is from the rate, where that is beyond every chance: which
        of them is right the clip does not show. Else 0.
    """

    by_stamps_rad_s: float
    frame_count: FrameCount | None
    lag: ImageReturn | None
    second: ImageReturn | None
    apart_rad_s: float


def cross_check(
    track: PhaseTrack, time_s: FloatArray, angle: PlateAngle, rate_rad_s: float, sd_rad_s: float
) -> CrossChecks:
    """Measure the rate by other ways and compare.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Stamps of all frames of the track, s.
    angle : PlateAngle
        With the dropped frames counted.
    rate_rad_s, sd_rad_s : float
        The measured rate, signed, and its sd without the clock's.
    """
    repaired_s = float(np.ptp(angle.repaired_time_s))
    by_stamps = abs(rate_rad_s) * repaired_s / float(np.ptp(angle.time_s))
    frame_s = frame_time(time_s)
    is_even = np.abs(np.diff(time_s) - frame_s).max() <= EVEN * frame_s
    lag = second = None
    apart = 0.0
    if is_even:
        lag = lag_rate(track, frame_s, by_stamps)
        if track.plate.symmetry == 1:
            second = other_return(track.thumbnail, frame_s, 2 * np.pi / by_stamps)
    if lag is not None:
        lag_sd = lag.rate_rad_s * lag.sd_s / lag.period_s
        chance = THRESHOLDS.apart * float(np.hypot(lag_sd, sd_rad_s))
        away = abs(lag.rate_rad_s - by_stamps)
        apart = away if away > max(chance, THRESHOLDS.matters * by_stamps) else 0.0
    count = count_frames(angle)
    return CrossChecks(by_stamps, count, lag, second, apart)


def count_frames(angle: PlateAngle) -> FrameCount | None:
    """The rate by counting frames from turn to turn.

    As in Angrisano et al., with plate angle zero as the fixed place: M turns
    between the first alignment and the last took n frames, so the rate is 2πM/(n frame times). Each
    end is a whole frame, so n is uncertain by up to one frame whatever the scatter of the single
    counts: at 15 frames per second three of the four record speeds give a whole number of frames
    per turn, all counts agree and their scatter is zero. The term stays.

    Parameters
    ----------
    angle : PlateAngle

    Returns
    -------
    FrameCount or None
        None with fewer than two alignments.
    """
    turns = angle.angle_rad / (2 * np.pi)
    progress = np.maximum.accumulate(turns if turns[-1] >= turns[0] else -turns)
    whole = np.arange(np.ceil(progress[0]), np.floor(progress[-1]) + 1)
    after = np.searchsorted(progress, whole).clip(1, len(progress) - 1)
    # Nobody sees an alignment that falls where frames are missing.
    frame_s = frame_time(angle.time_s)
    seen = np.diff(angle.time_s)[after - 1] < THRESHOLDS.gap * frame_s
    whole, after = whole[seen], after[seen]
    if len(whole) < 2:
        return None
    nearer = np.abs(progress[after - 1] - whole) < np.abs(progress[after] - whole)
    aligned = np.where(nearer, after - 1, after)
    time = float(angle.time_s[aligned[-1]] - angle.time_s[aligned[0]])
    rate = float(2 * np.pi * (whole[-1] - whole[0])) / time
    return FrameCount(rate, rate * END_SD * frame_s / time, angle.index[aligned])


def lag_rate(track: PhaseTrack, frame_s: float, rate_rad_s: float) -> ImageReturn | None:
    """The rate by autocorrelation: after how many frames does the image look the same again?

    No plate, no centre, no mark: the surroundings of the plate at a few hundred pixels are
    correlated with themselves over time. The highest peak near each multiple of a turn gives the
    time of that many turns.

    Parameters
    ----------
    track : PhaseTrack
    frame_s : float
        From frame to frame, always the same.
    rate_rad_s : float
        Near which returns are looked for.

    Returns
    -------
    ImageReturn or None
        None without clear returns; none where the plate looks the same again in less than the turn
        that is looked through about a return.
    """
    if 2 * ABOUT * track.plate.symmetry > 1:
        return None
    values = track.thumbnail[:LONGEST].astype(np.float32)
    values -= values.mean(axis=0)
    values -= values.mean(axis=1, keepdims=True)  # flicker
    per_turn = 2 * np.pi / (abs(rate_rad_s) * frame_s)
    lags, count, shown = returns_near(autocorrelation(values), per_turn)
    clear = shown >= THRESHOLDS.clear_peak
    if clear.sum() < FEWEST_RETURNS:
        return None
    period, sd = fitted_period(lags[clear], count[clear])
    return ImageReturn(
        period * frame_s, sd * frame_s, int(count[clear].max()), float(shown[clear].mean()))
