"""Two other methods for the rate, less exact, for comparison with the first.

The count of frames between alignments, and the return of the picture (``vision.image_return``),
which uses no plate and no mark. Both use the time stamps unchanged, without the time of dropped
frames, and are compared with the rate on these stamps, not averaged with it.
"""

from dataclasses import dataclass, replace

import numpy as np

from vision.geometry import FloatArray
from vision.image_return import MOST_FRAMES, SAME_RETURN, ImageReturn, image_return
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.unwrap import frame_time

END_SD = 1 / np.sqrt(6.0)  # frames: sd of the difference of two ends rounded to whole frames
EVEN = 0.05  # of the frame time: stamps nearer to a grid are evenly spaced


@dataclass(frozen=True, eq=False)
class FrameCount:
    """Rate from counted frames.

    Attributes
    ----------
    rate_rad_s, sd_rad_s : float
        Positive, rad/s.
    """

    rate_rad_s: float
    sd_rad_s: float


@dataclass(frozen=True, eq=False)
class CrossChecks:
    """The rate by other methods, on the time stamps unchanged.

    Attributes
    ----------
    by_stamps_rad_s : float
        The measured rate on these stamps, positive.
    frame_count : FrameCount or None
        None with fewer than two alignments of the marks.
    lag : ImageReturn or None
        Return after a turn of the plate, or a multiple or a part of one; None without it, or if
        the stamps are not evenly spaced.
    """

    by_stamps_rad_s: float
    frame_count: FrameCount | None
    lag: ImageReturn | None


def strongest_return(track: PhaseTrack, time_s: FloatArray) -> ImageReturn | None:
    """The return of the strongest variation; None without one, and if the times, (f,), are uneven.
    """
    frame_s = frame_time(track, time_s)
    if np.abs(np.diff(time_s) - frame_s).max() > EVEN * frame_s:
        return None
    return image_return(np.ascontiguousarray(track.thumbnail[:MOST_FRAMES, :, None]), frame_s, (1,))


def cross_check(angle: PlateAngle, rate_rad_s: float, returns: ImageReturn | None) -> CrossChecks:
    """Measure the rate by other methods, for comparison.

    Parameters
    ----------
    angle : PlateAngle
        With the dropped frames counted.
    rate_rad_s : float
        The measured rate, signed.
    returns : ImageReturn or None
        Of the strongest variation.
    """
    repaired_s = float(np.ptp(angle.repaired_time_s))
    by_stamps = abs(rate_rad_s) * repaired_s / float(np.ptp(angle.time_s))
    lag = None
    if returns is not None:
        turn_s = 2 * np.pi / by_stamps
        share = max(1, round(turn_s / returns.period_s)) / max(1, round(returns.period_s / turn_s))
        turn = replace(returns, period_s=share * returns.period_s, sd_s=share * returns.sd_s)
        if abs(turn.period_s / turn_s - 1) <= SAME_RETURN:
            lag = turn
    return CrossChecks(by_stamps, count_frames(angle), lag)


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
    if len(whole) < 2:
        return None
    nearer = np.abs(progress[after - 1] - whole) < np.abs(progress[after] - whole)
    aligned = np.where(nearer, after - 1, after)
    time = float(angle.time_s[aligned[-1]] - angle.time_s[aligned[0]])
    rate = float(2 * np.pi * (whole[-1] - whole[0])) / time
    return FrameCount(rate, rate * END_SD * angle.frame_s / time)
