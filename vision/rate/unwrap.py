"""The plate's angle against time: usable frames, whole turns, rate from turn to turn."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle, RateHistory

LOCAL_STEPS = 31  # frames that a median is taken over, for a usual step and for strays
BURST = 8.0  # times the usual step, that two steps take; else they take two
REGULAR = 0.1  # of the usual step: what belongs to it


@dataclass(frozen=True)
class FrameThresholds:
    """Which frames are used.

    Attributes
    ----------
    unexplained : float
        Times the usual ratio of what the template does not explain of a frame to what it does; more
        is something in the way.
    least_unexplained : float
        That ratio in a frame without noise to speak of.
    at_rest : float
        Of the usual step; slower before or after frames that repeat is a plate at rest.
    stray : float
        Times the median distance from the neighbours' median; farther frames are left out of the
        rate from turn to turn.
    stray_rad : float
        And farther than this, rad, as a plate that stops may leave it.
    rest : float
        Times a neighbouring half turn; one that takes longer is a rest.
    """

    unexplained: float = 3.0
    least_unexplained: float = 0.01
    at_rest: float = 0.75
    stray: float = 10.0
    stray_rad: float = 0.1
    rest: float = 2.5


THRESHOLDS = FrameThresholds()


def usable(track: PhaseTrack) -> BoolArray:
    """Frames in which the plate was seen well and which repeat no other, shape (f,)."""
    seen = np.isfinite(track.phase_rad) & np.isfinite(track.quality)
    usual = float(np.median(track.quality[seen])) if seen.any() else 0.0
    limit = THRESHOLDS.unexplained * max(float(_unexplained(usual)), THRESHOLDS.least_unexplained)
    clear = (track.quality > 0) & (_unexplained(track.quality) <= limit)
    return seen & clear & ~_repeated(track, seen)


def _unexplained(correlation: FloatArray | float) -> FloatArray:
    """Power of a frame that the template does not explain, over that which it does."""
    square = np.square(correlation)
    return np.asarray((1 - square) / np.maximum(square, 1e-12))


def _repeated(track: PhaseTrack, seen: BoolArray) -> BoolArray:
    """Frames delivered again, shape (f,).

    A plate at rest repeats itself too, and must not vanish: before and after its rest it is slow.
    A frame that is delivered again stands between frames of a plate at its usual rate.
    """
    fresh = np.flatnonzero(seen & ~track.duplicate)
    if len(fresh) < 2:
        return track.duplicate
    step = np.abs(np.angle(np.exp(1j * np.diff(track.phase_rad[fresh]))))
    slow = step < THRESHOLDS.at_rest * np.median(step)
    repeated = track.duplicate.copy()
    edges = np.flatnonzero(np.diff(track.duplicate.astype(int), prepend=0, append=0))
    for start, stop in edges.reshape(-1, 2):
        # Not the step across the run itself: that is a jump where the recorder caught up.
        after = int(np.searchsorted(fresh, start))
        around = [i for i in (after - 2, after) if 0 <= i < len(slow)]
        if slow[around].any():
            repeated[start:stop] = False
    return repeated


def frame_time(time_s: FloatArray) -> float:
    """Usual time from frame to frame, s, finer than the stamps: Matroska rounds them to 1 ms."""
    if stamped_in_bursts(time_s):
        return float(np.median(time_s[2:] - time_s[:-2])) / 2
    step = np.diff(time_s)
    usual = _usual_step(step)
    return float(step[np.abs(step - usual) <= REGULAR * usual].mean())


def stamped_in_bursts(time_s: FloatArray) -> bool:
    """Two frames come at once, then none for long: the stamps are not the times of the frames."""
    pair = float(np.median(time_s[2:] - time_s[:-2]))
    return pair > BURST * _usual_step(np.diff(time_s))


def _usual_step(step: FloatArray) -> float:
    return float(np.quantile(step, 0.5, method="lower"))  # one of the steps, never between two


def rough_rate(track: PhaseTrack, time_s: FloatArray) -> float:
    """Usual rate in rad/s, signed, the smallest of its aliases."""
    good = np.flatnonzero(usable(track))
    step_s, step = np.diff(time_s[good]), np.diff(track.phase_rad[good])
    usual = frame_time(time_s[good])
    regular = np.abs(step_s - usual) <= REGULAR * usual
    regular |= not regular.any()
    step = step[regular] * track.plate.symmetry
    centre = np.angle(np.mean(np.exp(1j * step)))
    around = centre + np.angle(np.exp(1j * (step - centre)))
    return float(np.median(around) / track.plate.symmetry / usual)


def continuous_angle(track: PhaseTrack, time_s: FloatArray, rate_rad_s: float) -> PlateAngle:
    """Make the angle of the usable frames continuous.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Of every frame of the track, s.
    rate_rad_s : float
        Rate that the angle follows between frames, signed.

    Returns
    -------
    PlateAngle
        On the stamps as they are: no frame counted as dropped.
    """
    good = np.flatnonzero(usable(track))
    time, phase = time_s[good], track.phase_rad[good]
    period = 2 * np.pi / track.plate.symmetry
    expected = rate_rad_s * np.diff(time)
    surprise = np.diff(phase) - expected
    step = expected + surprise - period * np.round(surprise / period)
    return PlateAngle(
        time_s=time,
        angle_rad=phase[0] + np.concatenate([[0.0], np.cumsum(step)]),
        index=good,
        dropped=np.zeros(len(good), np.int64),
        frame_s=frame_time(time_s),
    )


def running_median(values: FloatArray, over: int) -> FloatArray:
    """Median over ``over`` neighbours, an odd number, mirrored at the ends; any unit, (n,)."""
    if len(values) <= over:
        return np.full_like(values, np.median(values))
    half = over // 2
    padded = np.concatenate([values[:half][::-1], values, values[-half:][::-1]])
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, over), axis=1))


def phase_noise(angle_rad: FloatArray) -> float:
    """White noise of a single angle: robust size of third differences over √20."""
    third = np.diff(angle_rad, 3)
    return float(SD_PER_MAD * np.median(np.abs(third)) / np.sqrt(20.0))


def scatter_about_even(angle: PlateAngle) -> float:
    """Robust sd of angles about an even rotation with a wave once and twice per turn, rad."""
    turned = angle.angle_rad
    waves = [f(k * turned) for k in (1, 2) for f in (np.cos, np.sin)]
    x = np.stack([np.ones_like(turned), angle.time_s - angle.time_s.mean(), *waves], axis=1)
    rest = turned - x @ np.linalg.lstsq(x, turned)[0]
    return float(SD_PER_MAD * np.median(np.abs(rest)))


def rate_history(angle: PlateAngle) -> RateHistory:
    """Mean rate over each turn (or over the clip, if that is less), half a turn apart.

    Over a whole turn every error that repeats with the plate's angle drops out. Where the plate
    stands or turns back there are no half turns; the time of the last one takes their place.
    """
    time, turned = _without_outliers(angle.repaired_time_s, angle.angle_rad)
    sign = np.sign(turned[-1]) or 1.0
    rising = np.maximum.accumulate(sign * turned)
    # Where the plate stands, angle has no inverse: keep the first time of each angle.
    keep = np.concatenate([[True], np.diff(rising) > 0])
    half_turns = np.arange(0, rising[-1], np.pi)
    mean = turned[-1] / (time[-1] - time[0])
    # Off the line, so that uneven times are no noise where their stamps tell them, and are noise
    # where these are wrong.
    noise = phase_noise(turned - mean * time)
    at = np.interp(half_turns, rising[keep], time[keep])
    at = _with_rests(at, float(time[-1]))
    if len(at) < 3:
        return RateHistory(np.array([time.mean()]), np.array([mean]), angle, noise)
    angle_at = np.interp(at, time, turned)
    rate = (angle_at[2:] - angle_at[:-2]) / (at[2:] - at[:-2])
    return RateHistory(0.5 * (at[2:] + at[:-2]), rate, angle, noise)


def _without_outliers(
    time_s: FloatArray, angle_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Time and angle since the first frame, of those that agree with their neighbours."""
    rate = (angle_rad[-1] - angle_rad[0]) / (time_s[-1] - time_s[0])
    off = angle_rad - rate * time_s
    off = np.abs(off - running_median(off, LOCAL_STEPS))
    off[: LOCAL_STEPS // 2] = off[-(LOCAL_STEPS // 2) :] = 0  # a slope leads away from its ends
    kept = off <= max(THRESHOLDS.stray * float(np.median(off)), THRESHOLDS.stray_rad)
    return time_s[kept], angle_rad[kept] - angle_rad[kept][0]


def _with_rests(at_s: FloatArray, end_s: float) -> FloatArray:
    """Times of half turns, and times as far apart where the next half turn does not come."""
    lasts = np.diff(at_s)
    times = [at_s]
    for i, (start, stop) in enumerate(zip(at_s, [*at_s[1:], end_s], strict=True)):
        beside = lasts[max(i - 1, 0) : i + 2]
        usual = float(np.min(beside, initial=np.inf, where=beside > 0))
        if stop - start > THRESHOLDS.rest * usual:
            pieces = int((stop - start) / usual)
            times.append(np.linspace(start, stop, pieces + 1)[1 : None if stop == end_s else -1])
    return np.sort(np.concatenate(times))
