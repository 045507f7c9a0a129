"""The plate's angle against time: usable frames, whole turns, rate from turn to turn."""


import numpy as np

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray, PhaseTrack, PlateAngle, RateHistory

LOCAL_STEPS = 31  # frames of a median, for a usual step
REGULAR = 0.1  # of the usual step, or turn: largest deviation of a regular one
#: Frames over which a rate is the usual one; tuned: with one, frames shown twice are refused
#: (tests.vision.tracking.test_rests_and_gaps), with six a mark that sticks for three is not.
SHOWN = 3
#: Share of the mean rate that is not the usual one. Between two equal marks that are taken for one
#: (0.5, derived) and noise (0.2, seen in films).
LEAPS = 0.35
SECTION_TURNS = 2.0  # turns; derived: errors that repeat with every turn are separated from a drift
FEWEST_IN_SECTION = 14  # frames; derived: two per parameter


# Limit for usable frames.
UNEXPLAINED = 3.0
"""Largest ratio of the unexplained to the explained power of a frame, over the usual ratio; with
more, something is in the way."""


def usable(track: PhaseTrack) -> BoolArray:
    """Frames in which the plate was seen well, shape (f,)."""
    seen = np.isfinite(track.phase_rad) & np.isfinite(track.quality)
    usual = float(median(track.quality[seen])) if seen.any() else 0.0
    limit = UNEXPLAINED * _unexplained(usual)
    clear = (track.quality > 0) & (_unexplained(track.quality) <= limit)
    return seen & clear


def _unexplained(correlation: FloatArray | float) -> FloatArray:
    """Power of a frame that the template does not explain, over the explained power."""
    square = np.square(correlation)
    return np.asarray((1 - square) / np.maximum(square, 1e-12))


def frame_time(track: PhaseTrack, time_s: FloatArray) -> float:
    """Usual time from frame to frame, s, finer than the stamps: Matroska rounds them to 1 ms.

    ``time_s`` (f,) are those of every frame of the track.
    """
    if stamped_in_pairs(track, time_s):
        return float(median(time_s[2:] - time_s[:-2])) / 2
    step = np.diff(time_s)
    return float(step[_near(step)].mean())  # the sum of neighbours is free of what lies between


def stamped_in_pairs(track: PhaseTrack, time_s: FloatArray) -> bool:
    """Whether frames come in pairs and the plate turns on evenly: no stamp is a frame's time.

    Lost frames leave fewer pairs of steps regular than steps, and the plate turns farther in them.
    """
    step, pair = np.diff(time_s), time_s[2:] - time_s[:-2]
    short = _near(step)
    usual_pair = float(median(pair))
    if (np.abs(pair - usual_pair) <= REGULAR * usual_pair).mean() <= short.mean():
        return False
    seen = usable(track)
    shown = seen[1:] & seen[:-1]
    turns = np.exp(1j * track.plate.symmetry * np.diff(track.phase_rad))
    in_short, in_long = turns[short & shown].sum(), turns[~short & shown].sum()
    longer = float(step[~short].mean() / step[short].mean()) - 1
    by_stamps = np.angle(np.exp(1j * longer * np.angle(in_short)))
    return bool(abs(np.angle(in_long * np.conj(in_short))) < abs(by_stamps) / 2)


def _near(step: FloatArray) -> BoolArray:
    """Which steps (n,) are nearly the usual one."""
    return np.asarray(np.abs(step / _usual_step(step) - 1) < 0.5)


def _usual_step(step: FloatArray) -> float:
    return float(np.sort(step)[(len(step) - 1) // 2])  # one of the steps, never between two


def _usual_mean(step: FloatArray) -> float:
    usual = _usual_step(step)
    return float(step[np.abs(step - usual) <= REGULAR * usual].mean())


def rough_rate(track: PhaseTrack, time_s: FloatArray) -> float:
    """Usual rate in rad/s, signed, the smallest of its aliases."""
    good = np.flatnonzero(usable(track))
    step_s, step = np.diff(time_s[good]), np.diff(track.phase_rad[good])
    usual = frame_time(track, time_s)
    regular = np.abs(step_s - usual) <= REGULAR * usual
    regular |= not regular.any()
    step = step[regular] * track.plate.symmetry
    centre = np.angle(np.mean(np.exp(1j * step)))
    around = centre + np.angle(np.exp(1j * (step - centre)))
    return float(median(around) / track.plate.symmetry / usual)


def continuous_angle(track: PhaseTrack, time_s: FloatArray, rate_rad_s: float) -> PlateAngle:
    """Make the angle of the usable frames continuous.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Times of every frame of the track, s.
    rate_rad_s : float
        Rate that the angle follows between frames, signed.

    Returns
    -------
    PlateAngle
        On the stamps unchanged: no frame counted as dropped.
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
        dropped=np.zeros(len(good)),
        stepped=np.zeros(len(good), bool),
        frame_s=frame_time(track, time_s),
    )


def usual_rate(angle: PlateAngle) -> float:
    """Usual rate over three frames, rad/s, signed: a recorder may show each three times."""
    turned, frames = (x[SHOWN:] - x[:-SHOWN] for x in (angle.angle_rad, angle.index))
    return float(median(turned / frames)) / angle.frame_s


def leaps(angle: PlateAngle) -> bool:
    """Whether much of the way is none of the usual rate, as from one equal mark to another."""
    mean = mean_rate(angle)
    return bool((mean - usual_rate(angle)) * np.sign(mean) > LEAPS * abs(mean))


def mean_rate(angle: PlateAngle) -> float:
    """Rate from the first frame to the last, rad/s, signed."""
    return float((angle.angle_rad[-1] - angle.angle_rad[0]) / np.ptp(angle.repaired_time_s))


def running_median(values: FloatArray, over: int) -> FloatArray:
    """Median over ``over`` neighbours, an odd number, mirrored at the ends; any unit, (n,)."""
    if len(values) <= over:
        return np.full_like(values, median(values))
    half = over // 2
    padded = np.concatenate([values[:half][::-1], values, values[-half:][::-1]])
    return np.asarray(median(np.lib.stride_tricks.sliding_window_view(padded, over), axis=1))


def phase_noise(angle_rad: FloatArray) -> float:
    """White noise of a single angle: robust size of third differences over √20."""
    third = np.diff(angle_rad, 3)
    return float(SD_PER_MAD * median(np.abs(third)) / np.sqrt(20.0))


def waves_per_turn(angle_rad: FloatArray, orders: tuple[int, ...] = (1, 2)) -> FloatArray:
    """Cosine and sine, no unit, of each order of an angle (n,), shape (n, 2 orders)."""
    return np.stack([f(k * angle_rad) for k in orders for f in (np.cos, np.sin)], axis=1)


def scatter_about_even(angle: PlateAngle) -> float:
    """Robust sd of angles about a rotation that drifts evenly within every two turns, rad.

    Beside a wave once and twice per turn. A motor that starts or stops is no scatter.
    """
    turned = angle.angle_rad
    turns = float(np.ptp(turned)) / (2 * np.pi)
    sections = max(1, min(int(turns / SECTION_TURNS), len(turned) // FEWEST_IN_SECTION))
    rest = []
    for part in np.array_split(np.arange(len(turned)), sections):
        time, y = angle.time_s[part] - angle.time_s[part].mean(), turned[part]
        x = np.column_stack([np.ones_like(y), time, time**2, waves_per_turn(y)])
        rest.append(y - x @ np.linalg.lstsq(x, y)[0])
    return float(SD_PER_MAD * median(np.abs(np.concatenate(rest))))


def rate_history(angle: PlateAngle, stray: BoolArray | None = None) -> RateHistory:
    """Mean rate in the time of a turn (or over the clip, if that is less), half of it apart.

    The turn is the usual one: over a whole turn every error that repeats with the plate's angle
    cancels, and a plate that rests or turns back has a rate nevertheless. Stray frames, (u,), are
    ignored.
    """
    shown = angle if stray is None else angle.without(stray)
    time, turned = shown.repaired_time_s, shown.angle_rad - shown.angle_rad[0]
    span_s = float(time[-1] - time[0])
    mean = turned[-1] / span_s
    # Relative to the line, so that uneven times are not noise if their stamps are right, and are
    # noise if these are wrong.
    noise = phase_noise(turned - mean * (time - time[0]))
    rising = np.maximum.accumulate((np.sign(turned[-1]) or 1.0) * turned)
    passed = np.interp(np.arange(0, rising[-1], np.pi), rising, time)
    # In an off-centre view one half of every turn is the longer one.
    half_s = _usual_mean(passed[2:] - passed[:-2]) / 2 if len(passed) > 2 else np.inf
    if 2 * half_s > span_s:
        return RateHistory(np.array([time.mean()]), np.array([mean]), angle, noise)
    starts = np.arange(time[0], time[-1] - 2 * half_s + 1e-9, half_s)
    starts += (time[-1] - 2 * half_s - starts[-1]) / 2
    turn = np.interp(starts + 2 * half_s, time, turned) - np.interp(starts, time, turned)
    return RateHistory(starts + half_s, turn / (2 * half_s), angle, noise)
