"""The plate's angle against time: whole turns, lost pictures, rate from turn to turn.

A picture lost by a recorder that stamps as if none were makes the angle jump by rate x frame time;
n pictures by n times that. The jumps are exact multiples, far above the noise, so they are counted
and the time they stand for is put back.
"""


import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle, RateHistory

POOR_MATCH = 0.6  # of the usual correlation with the template; poorer pictures are left out
UNEXPLAINED = 3.0  # times the usual share that the template leaves; more is something in the way
SMALLEST_LEFT = 0.01  # share left in a picture without noise to speak of
AT_REST = 0.75  # of the usual step: slower before or after pictures that repeat is a plate at rest
NEAR_WHOLE = 0.25  # of rate x frame time: how close to a multiple a jump must be
CLEAR = 6.0  # times the noise of one step, for a jump to be told from it
STAYS = 8  # pictures on either side of a jump, from which it is told
TIDIED = 0.6  # of the angles' spread about a jump, that is left where it is put back
SPREAD = (1, 2, 3)  # steps that a jump may be spread over
STRAY = 10.0  # times the median distance from the neighbours' median
STRAY_RAD = 0.1  # and this at least, as a plate that stops may leave it
REST = 2.5  # times a neighbouring half turn; one that takes longer is no half turn but a rest
BURST = 8.0  # times the usual step, that two steps take; else they take two
REGULAR = 0.1  # of the usual step: what belongs to it
LOCAL_STEPS = 31  # pictures over which the usual step is taken,
LOCAL_S = 1.0  # and time, at least


def usable(track: PhaseTrack) -> BoolArray:
    """Pictures on which the plate was seen well and which are no repetition, shape (f,)."""
    seen = np.isfinite(track.phase_rad) & np.isfinite(track.quality)
    usual = float(np.median(track.quality[seen])) if seen.any() else 0.0
    left = 1 - track.quality**2
    clear = left <= UNEXPLAINED * max(1 - usual**2, SMALLEST_LEFT)
    return seen & clear & (track.quality > POOR_MATCH * usual) & ~_repeated(track, seen)


def _repeated(track: PhaseTrack, seen: BoolArray) -> BoolArray:
    """Pictures delivered again, shape (f,).

    A plate at rest repeats itself too, and must not vanish: before and after its rest it is slow.
    A picture that is delivered again stands between pictures of a plate at its usual rate.
    """
    fresh = np.flatnonzero(seen & ~track.duplicate)
    if len(fresh) < 2:
        return track.duplicate
    step = np.abs(np.angle(np.exp(1j * np.diff(track.phase_rad[fresh]))))
    slow = step < AT_REST * np.median(step)
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
    """Usual time from picture to picture, finer than the stamps: Matroska rounds them to 1 ms."""
    step = np.diff(time_s)
    usual = float(np.quantile(step, 0.5, method="lower"))  # one of the steps, never between two
    pair = float(np.median(time_s[2:] - time_s[:-2]))
    if pair > BURST * usual:  # two pictures come at once, then none for long
        return pair / 2
    return float(step[np.abs(step - usual) <= REGULAR * usual].mean())


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


def plate_angle(track: PhaseTrack, time_s: FloatArray, rate_rad_s: float) -> PlateAngle:
    """Make the angle continuous, near ``rate_rad_s``, and count lost pictures."""
    good = np.flatnonzero(usable(track))
    time, phase = time_s[good], track.phase_rad[good]
    period = 2 * np.pi / track.plate.symmetry
    step_s = np.diff(time)
    expected = rate_rad_s * step_s
    surprise = np.diff(phase) - expected
    step = expected + surprise - period * np.round(surprise / period)
    frame_s = frame_time(time_s)
    lost = _lost(step, step_s, frame_s)
    return PlateAngle(
        time_s=time,
        angle_rad=phase[0] + np.concatenate([[0.0], np.cumsum(step)]),
        index=good,
        dropped=np.concatenate([[0], lost]),
        frame_s=frame_s,
    )


def _lost(step: FloatArray, step_s: FloatArray, frame_s: float) -> NDArray[np.int64]:
    """Whole frame times missing in each step, shape (u - 1,).

    An encoder that blends pictures spreads a jump over two or three steps.
    """
    # Of a fast camera, more steps: each has all the noise and less of the motion.
    rate = _running_median(step / step_s, max(LOCAL_STEPS, 2 * round(LOCAL_S / frame_s / 2) + 1))
    whole = rate * frame_s
    left = step - rate * step_s  # beyond the usual rate, and not yet taken for lost pictures
    clear = np.abs(whole) > CLEAR * 1.4826 * float(np.median(np.abs(left)))
    lost = np.zeros(len(step), np.int64)
    for width in SPREAD:
        if width > 1:
            clear &= np.abs(whole) > CLEAR * _shift_noise(left)
        for at, count in _jumps(left, np.where(clear, whole, np.inf), width):
            lost[at] += count
            left[at] -= count * whole[at]
    return lost


def _jumps(left: FloatArray, whole: FloatArray, width: int) -> list[tuple[int, int]]:
    """Steps in which whole frame times are missing, and how many, by sums over ``width`` steps.

    One too few is a picture shown again. It has its time: recorders put it in where the camera is
    slower than the film, and taken out it would leave the plate as much too fast.
    """
    if len(left) < width:
        return []
    total = np.convolve(left, np.ones(width), "valid")
    ratio = total / whole[: len(total)]
    count = np.round(ratio).clip(0).astype(int)
    off = np.abs(ratio - count)
    near = np.flatnonzero((off < NEAR_WHOLE) & (count > 0))
    apart: list[int] = []
    for i in near[np.argsort(off[near])]:
        if all(abs(i - other) >= width for other in apart):
            apart.append(int(i))
    steps = [(i + int(np.abs(left[i : i + width]).argmax()), int(count[i])) for i in apart]
    put_back = left.copy()
    for at, lost in steps:
        put_back[at] -= lost * whole[at]
    beyond = np.concatenate([[0.0], np.cumsum(put_back)])
    found = []
    for i, (at, lost) in zip(apart, steps, strict=True):
        old, new = beyond[max(0, i + 1 - STAYS) : i + 1], beyond[i + width : i + width + STAYS]
        # An angle that jumps there and back, or creeps back, was mismeasured.
        without = np.concatenate([old, new + lost * whole[at]])
        if _spread(np.concatenate([old, new])) < TIDIED * _spread(without):
            found.append((at, lost))
    return found


def _spread(values: FloatArray) -> float:
    return float(np.abs(values - np.median(values)).sum())


def _shift_noise(left: FloatArray) -> float:
    """By how much the level of some pictures differs from the next ones', jumps left aside."""
    beyond = np.concatenate([[0.0], np.cumsum(left)])
    if len(beyond) < 2 * STAYS:
        return np.inf
    level = np.median(np.lib.stride_tricks.sliding_window_view(beyond, STAYS), axis=1)
    return float(np.quantile(np.abs(level[STAYS:] - level[:-STAYS]), 0.25)) / 0.3186


def _running_median(values: FloatArray, over: int = LOCAL_STEPS) -> FloatArray:
    if len(values) <= over:
        return np.full_like(values, np.median(values))
    half = over // 2
    padded = np.concatenate([values[:half][::-1], values, values[-half:][::-1]])
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, over), axis=1))


def phase_noise(angle_rad: FloatArray) -> float:
    """White noise of a single angle: robust size of third differences over √20."""
    third = np.diff(angle_rad, 3)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))


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
    """Time and angle since the first picture, of those that go with their neighbours."""
    rate = (angle_rad[-1] - angle_rad[0]) / (time_s[-1] - time_s[0])
    off = angle_rad - rate * time_s
    off = np.abs(off - _running_median(off))
    off[: LOCAL_STEPS // 2] = off[-(LOCAL_STEPS // 2) :] = 0  # a slope leads away from its ends
    kept = off <= max(STRAY * float(np.median(off)), STRAY_RAD)
    return time_s[kept], angle_rad[kept] - angle_rad[kept][0]


def _with_rests(at_s: FloatArray, end_s: float) -> FloatArray:
    """Times of half turns, and times as far apart where the next half turn does not come."""
    lasts = np.diff(at_s)
    times = [at_s]
    for i, (start, stop) in enumerate(zip(at_s, [*at_s[1:], end_s], strict=True)):
        beside = lasts[max(i - 1, 0) : i + 2]
        usual = float(np.min(beside, initial=np.inf, where=beside > 0))
        if stop - start > REST * usual:
            pieces = int((stop - start) / usual)
            times.append(np.linspace(start, stop, pieces + 1)[1 : None if stop == end_s else -1])
    return np.sort(np.concatenate(times))
