"""A camera that is slower than its clip: the recorder repeats frames to fill the clip's rate.

Such a camera takes its frames evenly, and each is stamped when the clip's next frame is due, up to
one frame time late; only the clip's first frame may be older. With s_k the stamp of the k-th frame
that is not a repetition and T the camera's own frame time,

    s_k = c + T k + late_k,   0 ≤ late_k < one frame time of the clip.

All lines (c, T) that keep all stamps in that band are equally probable. The probability of T is
therefore proportional to the remaining range of c. Where the recorder dropped a frame or its clock
stepped, c changes; the runs of frames between have one T. The angles must be more probable
(``angle_levels``) by T k than by the stamps.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.angle_levels import JUMPS, SPREAD, AngleLevels, angle_levels
from vision.rate.steady_part import FEWEST_FRAMES, ClipPart
from vision.rate.unwrap import (
    continuous_angle,
    frame_time,
    leaps,
    rough_rate,
    scatter_about_even,
    usable,
)

SLOPES, ZOOMS = 51, 6  #: numerical


@dataclass(frozen=True, eq=False)
class FrameTimes:
    """The frames with the times at which they were taken.

    Attributes
    ----------
    track : PhaseTrack
        Without the repetitions, if the camera is slower than its clip.
    time_s : array, shape (f,)
        Time of each of its frames.
    repetitions : array of int, shape (f,)
        Number of repetitions of each by the recorder, or 1 for a repetition still in the track.
    camera_fps : float or None
        Frame rate of a camera that is slower than its clip.
    relative_sd : float
        Relative sd of ``camera_fps``, by the stamps; else 0.
    """

    track: PhaseTrack
    time_s: FloatArray
    repetitions: NDArray[np.int64]
    camera_fps: float | None = None
    relative_sd: float = 0.0

    def part(self, part: ClipPart) -> Self:
        """Some seconds of the clip.

        Raises
        ------
        RateRefused
            The clip has too few frames there.
        """
        chosen = part.frames(self.track.source, self.time_s)
        return replace(self, track=self.track.frames(chosen), time_s=self.time_s[chosen],
                       repetitions=self.repetitions[chosen])

    @cached_property
    def angle(self) -> PlateAngle | None:
        """The angle at these times; None if too few frames can be used."""
        if usable(self.track).sum() < FEWEST_FRAMES:
            return None
        return continuous_angle(self.track, self.time_s, rough_rate(self.track, self.time_s))

    @cached_property
    def levels(self) -> AngleLevels:
        """The jumps of the angle at these times, numbered as the track's frames, and their odds."""
        if self.angle is None:
            none = np.zeros(0, np.intp)
            return AngleLevels(none, none > 0, -np.inf)
        levels = angle_levels(self.angle)
        return replace(levels, jumps=self.angle.index[levels.jumps])

    @cached_property
    def scatter_rad(self) -> float:
        """Robust sd of the angles about a rotation that drifts evenly within every two turns, rad.

        Infinite if too few frames can be used.
        """
        return np.inf if self.angle is None else scatter_about_even(self.angle)

    @property
    def leaps(self) -> bool:
        """Whether the angle leaps at these times, or too few frames can be used."""
        return self.angle is None or leaps(self.angle)

    @property
    def warnings(self) -> tuple[str, ...]:
        """A warning that the camera is slower than its clip."""
        if self.camera_fps is None:
            return ()
        return (
            f"{self.track.source}: the camera took {self.camera_fps:.4g} frames per second and the "
            f"recorder repeated {self.repetitions.sum()} of them to fill the clip. The frames are "
            f"timed by the camera, evenly. Record with the frame rate that the camera has in this "
            f"light, or with more light.",
        )


def frame_times(track: PhaseTrack, stamp_s: FloatArray) -> FrameTimes:
    """Times of the frames: as stamped, or evenly for a camera slower than its clip.

    Parameters
    ----------
    track : PhaseTrack
    stamp_s : array, shape (f,)
        Stamps of every frame.
    """
    stamped = FrameTimes(track, stamp_s, track.duplicate.astype(np.int64))
    fresh = np.flatnonzero(~track.duplicate)
    if len(fresh) == len(stamp_s) or len(fresh) < FEWEST_FRAMES:
        return stamped
    clip_s = frame_time(track, stamp_s)
    once = replace(track, phase_rad=np.where(track.duplicate, np.nan, track.phase_rad))
    seen = replace(stamped, track=once)
    even, runs = _by_camera(track, stamp_s, fresh, clip_s)
    if even is None:
        return stamped
    ours = even.levels.log_probability + runs * np.log(JUMPS)
    return even if ours > seen.levels.log_probability else seen


def _by_camera(
    track: PhaseTrack, stamp_s: FloatArray, fresh: NDArray[np.intp], clip_s: float
) -> tuple[FrameTimes | None, int]:
    """The frames that are not repetitions, timed evenly; and the runs of their stamps.

    None if these are not even.
    """
    late_s = float(np.ptp(stamp_s - clip_s * np.arange(len(stamp_s))))
    repetitions = np.diff(fresh, append=len(stamp_s)) - 1
    even, runs = None, 0
    jumps = np.zeros(0, np.intp)
    for _ in range(2):  # a jump is known once there are times
        # The first frame may have been taken long before the clip begins.
        slope = _slope_within(stamp_s[fresh[1:]], clip_s + late_s, jumps - 1)
        # A plate at rest repeats itself too, and for longer than a camera does.
        if slope is None or (repetitions > np.ceil(slope[0] / clip_s)).any():
            return None, 0
        camera_s, sd_s, runs = slope
        even = FrameTimes(track.frames(~track.duplicate),
                          stamp_s[0] + camera_s * np.arange(len(fresh)), repetitions,
                          1 / camera_s, sd_s / camera_s)
        jumps = even.levels.jumps
    return even, runs


def _slope_within(
    values: FloatArray, width: float, jumps: NDArray[np.intp]
) -> tuple[float, float, int] | None:
    """Mean and sd of the slope of lines with 0 ≤ values - line ≤ width, and their number.

    None without one. There is a line for each run of values, as long as it fits and between jumps;
    they have one slope.
    """
    slopes, start, runs = [], 0, 0
    while start < len(values):
        later = jumps[jumps > start]
        end = int(later[0]) if len(later) else len(values)
        shorter, longest, stop = start + 1, end, end
        while shorter < longest:
            if _slope(values[start:stop], width) is None:
                longest = stop - 1
            else:
                shorter = stop
            stop = (shorter + longest + 1) // 2
        # The last values of a run that ends before a jump belong to another line that just fits.
        stop = end - SPREAD * (end < len(values)) if longest == end else (start + longest) // 2
        begin = start + SPREAD * (start > 0)
        if stop - begin >= FEWEST_FRAMES:
            slopes.append(_slope(values[begin:stop], width))
        start, runs = longest, runs + 1
    known = [slope for slope in slopes if slope is not None]
    if not known:
        return None
    mean, sd = np.array(known).T
    best = float(np.average(mean, weights=sd**-2))
    scatter = float((((mean - best) / sd) ** 2).sum()) / max(len(mean) - 1, 1)
    return best, float(np.sqrt(max(scatter, 1.0) / (sd**-2).sum())), runs


def _slope(values: FloatArray, width: float) -> tuple[float, float] | None:
    """Mean and sd of the slopes of one such line; None without one."""
    number = np.arange(len(values))
    middle, reach = float(values[-1] - values[0]) / number[-1], width / number[-1]
    low, high = middle - reach, middle + reach
    for _ in range(ZOOMS):  # the range of the intercept is concave in the slope
        tried = np.linspace(low, high, SLOPES)
        room = width - np.ptp(values - np.outer(tried, number), axis=1)
        within = np.flatnonzero(room >= min(room.max(), 0.0))
        low, high = tried[max(within[0] - 1, 0)], tried[min(within[-1] + 1, SLOPES - 1)]
    if room.max() < -1e-9 * width:
        return None
    weight = np.maximum(room, 0.0) + 1e-9 * width  # never all zero
    mean = float(np.average(tried, weights=weight))
    return mean, float(np.sqrt(np.average((tried - mean) ** 2, weights=weight)))
