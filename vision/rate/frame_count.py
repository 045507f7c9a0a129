"""The rate by counting frames between alignments of the plate's mark with the fixed mark.

As in Angrisano et al.: M turns between the first alignment and the last took n frames, so the rate
is 2πM/(n frame times). Each end is a whole frame, so n is uncertain by up to one frame whatever
the scatter of the single counts: at 15 frames per second three of the four record speeds give a
whole number of frames per turn, all counts agree and their scatter is zero. The term stays.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.phase_track import PlateAngle
from vision.rate.unwrap import frame_time

END_SD = 1 / np.sqrt(6.0)  # frames: the difference of two ends rounded to whole frames
GAP = 1.5  # frames between the pictures before and after an alignment; more is a gap


@dataclass(frozen=True, eq=False)
class FrameCount:
    """Rate from counted frames.

    Attributes
    ----------
    rate_rad_s, sd_rad_s : float
    alignments : array of int
        Pictures in which the marks are aligned.
    """

    rate_rad_s: float
    sd_rad_s: float
    alignments: NDArray[np.intp]


def count_frames(angle: PlateAngle, mark_rad: float, deck_mark_rad: float) -> FrameCount | None:
    """Count; None with fewer than two alignments.

    Parameters
    ----------
    angle : PlateAngle
    mark_rad : float
        Azimuth of the plate's mark at plate angle zero; NaN takes the plate's own zero.
    deck_mark_rad : float
        Azimuth of the fixed mark; NaN takes the place where the plate's mark was first.
    """
    mark = angle.angle_rad + (0.0 if np.isnan(mark_rad) else mark_rad)
    fixed = mark[0] if np.isnan(deck_mark_rad) else deck_mark_rad
    turns = (mark - fixed) / (2 * np.pi)
    sign = 1.0 if turns[-1] >= turns[0] else -1.0
    progress = np.maximum.accumulate(sign * turns)
    whole = np.arange(np.ceil(progress[0]), np.floor(progress[-1]) + 1)
    after = np.searchsorted(progress, whole).clip(1, len(progress) - 1)
    # Nobody sees an alignment that falls where pictures are left out.
    frame_s = frame_time(angle.time_s)
    seen = np.diff(angle.time_s)[after - 1] < GAP * frame_s
    whole, after = whole[seen], after[seen]
    if len(whole) < 2:
        return None
    nearer = np.abs(progress[after - 1] - whole) < np.abs(progress[after] - whole)
    aligned = np.where(nearer, after - 1, after)
    time = angle.repaired_time_s[aligned[-1]] - angle.repaired_time_s[aligned[0]]
    rate = 2 * np.pi * (whole[-1] - whole[0]) / float(time)
    sd = rate * END_SD * frame_s / float(time)
    return FrameCount(rate, sd, angle.index[aligned])
