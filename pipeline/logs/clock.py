"""Sample times from a column in some unit, a counter, or a sample rate.

An implausible clock is refused with the unit that would be plausible: milliseconds read as seconds
turn a log of 100 Hz into one of 0.1 Hz whose poses last an hour.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import BoolArray, FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import COUNTER, SECONDS_PER, TIME, TimeUnit

COUNTER_PERIOD = 65536  #: the Xsens packet counter has 16 bits; others never jump that far
#: Periods of counters of 8 to 32 bits, of the parts of a second, and of the time of the day.
PERIODS = (2.0**32, 1e9, 2.0**24, 1e6, 2.0**16, 1e3, 2.0**8, 86_400.0, 86_400_000.0)
EPOCH_S = (1e9, 5e9)  #: seconds since 1970 from 2001 to 2128
FEWEST_ROWS = 100
"""Least number of rows between two backward steps of a clock. A judgement: after a reset, a new
time or the next pose it runs on for a second or more; a misplaced row is one row."""
MOST_WRAPS = 3.0  #: largest number of wraps over that expected by the usual step; a judgement
USUAL_STEPS = 20.0  #: largest step that is no pause, in usual steps
FEWEST_TO_SHOW = 10  #: least number of rows that show a sensor, or which row stands apart; chosen

CLOCK_FACES = (1.0, 1e3, 1e6)  #: facts: parts of a second in which a clock face is written
SECONDS_AT_A_TURN = 58  #: fact: least seconds shown just before a new minute, to a second

SLOWEST_HZ, FASTEST_HZ = 0.4, 40_000.0
"""Range of rates: the slowest sketch prints twice a second; no MEMS sensor exceeds 32 kHz."""
SLOW_HZ, LONGEST_SLOW_S = 5.0, 1800.0
"""Limits of sample rate and duration: a log both slower and longer has times in milliseconds. At
1 kHz this already shows in a log of two seconds, at 250 Hz by the rate itself."""
ASSUMED_HZ = 100.0
"""Sample rate of poses without a clock: the usual rate of a logger. It decides only whether poses
count as too short for their sds."""
USUAL_HZ = (4.0, 20_000.0)
"""Range of sample rates by which the likely unit of an implausible clock is found."""


@dataclass(frozen=True)
class StatedClock:
    """The clock of a log as the configuration or the caller states it.

    ``rate_hz`` replaces a missing column of times; ``unit`` is the unit of that column.
    If the clock is not ``needed`` and there is none, the rate is :data:`ASSUMED_HZ`.
    """

    rate_hz: float | None = None
    unit: TimeUnit | None = None
    needed: bool = True


def sample_times(
    label: str,
    values: Mapping[str, FloatArray],
    factor: float,
    stated: StatedClock,
    head_rate_hz: float | None,
    place: Callable[[int], str],
) -> tuple[FloatArray, tuple[str, ...]]:
    """Sample times in seconds, shape (t,), and notes on the changes made to them.

    Parameters
    ----------
    label : str
        Name of the log in messages.
    values : mapping of str to array, shape (t,)
        The log's columns as in the file, by our names.
    factor : float
        Seconds per unit of the column of times, by its name.
    stated : StatedClock
    head_rate_hz : float or None
        The sample rate that the file's head states.
    place : callable
        File and line of a row, for messages.

    Raises
    ------
    UnreadableInput
        No clock, two clocks, a clock that goes backwards, or an implausible one.
    """
    if TIME in values and stated.rate_hz is not None:
        raise UnreadableInput(f"{label}: the log has {TIME}, and sample_rate_hz is given as "
                              "well. Delete sample_rate_hz from the configuration.")
    if TIME in values:
        seconds = SECONDS_PER[stated.unit] if stated.unit else factor
        time_s, notes = continued_clock(unwrapped_ticks(values[TIME]) * seconds)
        _require_increasing(time_s, place)
        if stated.unit is None:
            _require_sense(label, time_s, seconds)
        return time_s, notes
    rate_hz = stated.rate_hz or head_rate_hz or (None if stated.needed else ASSUMED_HZ)
    if rate_hz is None:
        raise UnreadableInput(
            f"{label}: there is no column {TIME} (columns: {', '.join(values)}), and no sample "
            "rate is known. Add or rename the column (`columns: {time_s: its name}`, with "
            "`time_unit: ms` where it is not in seconds), or give sample_rate_hz beside the file "
            "in the configuration."
        )
    if COUNTER in values:
        lost_or_next = np.diff(values[COUNTER]) % COUNTER_PERIOD
        time_s = np.concatenate([[0.0], np.cumsum(lost_or_next)]) / rate_hz
    else:
        time_s = np.arange(len(next(iter(values.values())))) / rate_hz
    _require_increasing(time_s, place)
    return time_s, ()


def continued_clock(time_s: FloatArray) -> tuple[FloatArray, tuple[str, ...]]:
    """Times (t,) of a clock that was set back or restarted, continued without the step.

    Every part between two steps must be long; a short part is a misplaced row, and such times are
    returned unchanged.

    Returns
    -------
    time_s : array, shape (t,)
    notes : tuple of str
        Places of the steps, as the end of a sentence.
    """
    step = np.diff(time_s)
    back = np.flatnonzero(step < 0)
    stretches = np.split(time_s, back + 1)
    if not len(back) or min(map(len, stretches)) < FEWEST_ROWS:
        return time_s, ()
    usual = float(np.median(step[step > 0]))
    shift = np.zeros(len(time_s))
    shift[back + 1] = usual - step[back]
    more = f" and {len(back) - 1} times below it" if len(back) > 1 else ""
    return np.asarray(time_s + np.cumsum(shift)), (
        f"its clock steps back at row {back[0] + 2}{more}, and is continued there",)


def within_the_log(ticks: FloatArray) -> BoolArray:
    """Whether each of ``ticks`` (t,) of a clock belongs to the log, (t,).

    The first or the last does not if it is back, or more than :data:`USUAL_STEPS` usual steps,
    from its neighbour: the first stamp of a phone may be of an earlier event, and the first row of
    a copy may begin in the middle of a number. A single sample before a pause is no loss.
    """
    kept = np.ones(len(ticks), dtype=bool)
    step = np.diff(ticks)
    if len(ticks) >= FEWEST_TO_SHOW and (step > 0).any():
        ends = step[[0, -1]]
        kept[[0, -1]] = (ends >= 0) & (ends <= USUAL_STEPS * np.median(step[step > 0]))
    return kept


def unwrapped_ticks(ticks: FloatArray) -> FloatArray:
    """Values of a counter without its wraps.

    A backward step is a wrap if it is one period of a counter (or a day) short of a usual step; any
    other backward step is left for the caller to refuse.

    Parameters
    ----------
    ticks : array, shape (t,)

    Returns
    -------
    array, shape (t,)
        In the same unit.
    """
    ticks = _without_clock_face(ticks)
    step = np.diff(ticks)
    back = step < 0
    usual = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
    wraps = back.sum()
    for period in PERIODS if wraps else ():
        forward = step[back] + period
        if (forward > 0).all() and (forward <= USUAL_STEPS * usual).all():
            is_noise = wraps > 1 + MOST_WRAPS * usual * len(step) / period
            return ticks if is_noise else np.asarray(ticks + period * np.cumsum(np.r_[False, back]))
    return ticks


def _without_clock_face(ticks: FloatArray) -> FloatArray:
    """Seconds of the day for times (t,) like 100059.99, followed by 100100.00, as satellite
    receivers write them, or their thousandths or millionths; other times unchanged."""
    for parts in CLOCK_FACES:
        seconds, whole = ticks / parts % 100, ticks // parts // 100
        hours, minutes = whole // 100, whole % 100
        turns = np.flatnonzero(np.diff(minutes))
        is_face = len(turns) and (minutes < 60).all() and (seconds < 60).all() and (
            hours < 24).all() and np.median(np.diff(ticks)) <= parts
        if is_face and (seconds[turns] >= SECONDS_AT_A_TURN).all():
            return np.asarray(parts * (3600 * hours + 60 * minutes + seconds))
    return ticks


def likely_units(step: float) -> list[TimeUnit]:
    """The units in which a ``step`` of the column of times makes a usual sample rate."""
    return [unit for unit, seconds in SECONDS_PER.items()
            if step > 0 and USUAL_HZ[0] <= 1 / (step * seconds) <= USUAL_HZ[1]
            and unit != "min"]


def _require_increasing(time_s: FloatArray, place: Callable[[int], str]) -> None:
    backwards = np.flatnonzero(np.diff(time_s) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise UnreadableInput(
            f"{place(row)}: time does not increase: {time_s[row]:.9g} s after "
            f"{time_s[row - 1]:.9g} s. Delete repeated or misplaced lines, or record the log again."
        )


def makes_sense(time_s: FloatArray) -> bool:
    """Whether a logger may have times (t,) that grow, by their step and their length."""
    if len(time_s) < 3:
        return True
    step_s, length = float(np.median(np.diff(time_s))), float(time_s[-1] - time_s[0])
    return (SLOWEST_HZ < 1 / step_s < FASTEST_HZ
            and (1 / step_s >= SLOW_HZ or length <= LONGEST_SLOW_S))


def _require_sense(label: str, time_s: FloatArray, factor: float) -> None:
    """Refuse a clock that no logger has, and name the likely unit of the column."""
    if makes_sense(time_s):
        return
    length = float(time_s[-1] - time_s[0])
    step_s = float(np.median(np.diff(time_s)))
    rate_hz = 1 / step_s
    units = likely_units(step_s / factor)
    likely = (f"The column is likely in {' or '.join(units)}: write `time_unit: {units[0]}` beside "
              f"the file" if units else "Write `time_unit: ms` (or us, ns) beside the file where "
              "the column is in another unit")
    right = ", or `time_unit: s` if the seconds are right" * (units[:1] != ["s"])
    raise UnreadableInput(
        f"{label}: its clock makes no sense: {len(time_s)} samples in {length:.4g} s are "
        f"{rate_hz:.3g} samples per second; sensors are logged at {USUAL_HZ[0]:g} to "
        f"{USUAL_HZ[1]:g}. "
        f"{likely}{right}."
    )
