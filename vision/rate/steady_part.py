"""The part of a clip in which the plate turns steadily: between the motor's start and its stop.

The rate from turn to turn stays within a small range there, has no trend besides the even drift of
the clip, and no other part of the clip is steady at another rate.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import RPM, median
from vision.phase_track import RateHistory
from vision.rate.slow_changes import LONGEST, MovingEnds

FEWEST_FRAMES = 12  #: frames of a part; two per parameter of the phase's model


# Limits for a steady part.
WITHIN = 0.002
"""Relative range of the rate from turn to turn. Fact: belt drives wow by up to 0.2 %."""
LEAST_TURNS = 3.0
"""Least number of turns. Derived: errors that repeat with every turn are separated from a trend
over three."""
TREND = 0.001
"""Largest relative change of the rate from its beginning to its end, beyond four sds of it, and in
a clip without a warning; a larger one of most of the clip is a drift. Fact: ten times a poor clock
(100 ppm)."""
OTHER_SPEED = 0.01
"""Relative difference from which another steady part has another speed, and change in a clip that
is refused. Fact: the scale of a sensor calibrated against a mean rate errs by as much."""
PEAK_TO_PEAK = 8.0
"""Sds between the extremes of a hundred overlapping turns of white noise. Derived: 5 for
independent values (Tippett), and a margin for the heavy tails of late stamps."""


@dataclass(frozen=True)
class ClipPart:
    """The measured seconds of a clip.

    Attributes
    ----------
    start_s, stop_s : float or None
        By the time stamps of the clip; None is its beginning or its end.
    """

    start_s: float | None = None
    stop_s: float | None = None

    def frames(self, source: str, time_s: FloatArray) -> NDArray[np.bool_]:
        """Whether each of the frames with these times, shape (f,), lies in the part.

        Raises
        ------
        RateRefused
            The clip, ``source``, has too few frames there.
        """
        stop_s = np.inf if self.stop_s is None else self.stop_s
        chosen = (time_s >= (self.start_s or 0.0)) & (time_s <= stop_s)
        if self != WHOLE and chosen.sum() < FEWEST_FRAMES:
            raise RateRefused(
                f"{source}: choose a part within the clip, which lasts to {time_s[-1]:.1f} "
                f"s: {chosen.sum()} of its frames are in the stated part."
            )
        return np.asarray(chosen)


WHOLE = ClipPart()


@dataclass(frozen=True)
class SteadyPart:
    """Seconds of the clip, the mean rate between them, signed, and whether it drifts evenly."""

    start_s: float
    stop_s: float
    rate_rad_s: float
    drifts: bool

    def moving_ends(self, history: RateHistory) -> MovingEnds:
        """Whether the first and the last turn of the clip have another rate: a start, a stop."""
        other = np.abs(history.rate_rad_s[[0, -1]] / self.rate_rad_s - 1) > OTHER_SPEED
        return bool(other[0]), bool(other[1]), self.drifts

    def warning(self, source: str, clip_s: float) -> str:
        """A warning that only this part of a clip is measured."""
        return (
            f"{source}: the plate turns steadily from {self.start_s:.1f} s to {self.stop_s:.1f} s "
            f"of {clip_s:.1f} s, and the rate is that of this part. To measure another part, state "
            f"it (--from, --to, or from_s, to_s)."
        )


def noise_of_turns(history: RateHistory) -> float:
    """Relative range of the rate from turn to turn due to the noise of the angles alone."""
    return float(PEAK_TO_PEAK * 2 * history.phase_noise_rad / (2 * np.pi))


def steady_parts(history: RateHistory) -> list[SteadyPart]:
    """Parts that are steady for some turns, the longest first; they do not overlap."""
    within = max(WITHIN, noise_of_turns(history))
    # The rates are means over a turn, half a turn apart.
    fewest = round(2 * LEAST_TURNS) - 1
    free = np.ones(len(history.rate_rad_s), bool)
    even = _without_drift(history.rate_rad_s)
    parts = []
    while (run := _longest(even, within, free)) is not None:
        first, last = run
        free[max(first - 1, 0) : last + 2] = False
        if last - first + 1 < fewest:
            break
        rate = float(history.rate_rad_s[first : last + 1].mean())
        # The first and last turns of a part contain the ends of a start and a stop.
        begins, ends = float(history.angle.time_s[0]), float(history.angle.time_s[-1])
        start = begins if first == 0 else float(history.time_s[first])
        stop = ends if last == len(free) - 1 else float(history.time_s[last])
        if not _has_trend(even[first : last + 1]):
            parts.append(SteadyPart(start, stop, rate, even is not history.rate_rad_s))
    return parts


def the_steady_part(history: RateHistory) -> SteadyPart | None:
    """The longest steady part of a clip; None without one, or with two of different rates."""
    parts = steady_parts(history)
    if not parts:
        return None
    others = np.array([part.rate_rad_s for part in parts]) / parts[0].rate_rad_s
    return None if (np.abs(others - 1) > OTHER_SPEED).any() else parts[0]


def steady_advice(history: RateHistory) -> str:
    """Advice, with the usable parts if there are any."""
    parts = steady_parts(history)
    if not parts:
        return "Let the plate settle and film again."
    named = " and ".join(
        f"from {part.start_s:.1f} s to {part.stop_s:.1f} s ({part.rate_rad_s / RPM:+.2f} rpm)"
        for part in sorted(parts, key=lambda part: part.start_s)
    )
    return f"It is steady {named}: measure one such part alone (--from, --to, or from_s, to_s)."


def _without_drift(rate: FloatArray) -> FloatArray:
    """Rates without an even drift of most of the clip, as far as it is no wow and no start."""
    later, usual = max(len(rate) // 4, 1), abs(float(median(rate)))
    near = np.abs(np.abs(rate) - usual) < OTHER_SPEED * usual
    change = (rate[later:] - rate[:-later])[near[later:] & near[:-later]]
    if near.mean() < 1 - LONGEST or not len(change):
        return rate
    trend = float(median(change)) / later * (np.arange(len(rate)) - len(rate) / 2)
    is_drift = TREND < np.ptp(trend) / usual < OTHER_SPEED
    return rate - trend if is_drift else rate


def _longest(
    rate: FloatArray, within: float, free: NDArray[np.bool_]
) -> tuple[int, int] | None:
    """First and last of the longest run of free rates whose range is small, None without one."""
    best: tuple[int, int] | None = None
    start = 0
    for stop in range(len(rate)):
        if not free[stop]:
            start = stop + 1
            continue
        while np.ptp(rate[start : stop + 1]) > within * abs(rate[stop]):
            start += 1
        if best is None or stop - start > best[1] - best[0]:
            best = (start, stop)
    return best


def _has_trend(rate: FloatArray) -> bool:
    x = np.linspace(-0.5, 0.5, len(rate))
    slope = float(x @ rate / (x @ x))
    rest = rate - rate.mean() - slope * x
    sd = float(np.sqrt(2 * (rest @ rest) / max(len(rate) - 2, 1) / (x @ x)))  # turns overlap
    return abs(slope) > max(TREND * abs(float(rate.mean())), 4 * sd)
