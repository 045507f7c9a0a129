"""Sample times from what a log states: a column in some unit, a counter, or a rate.

A clock that makes no sense is refused with the unit that would: a column of milliseconds read as
seconds makes a log of 100 Hz one of 0.1 Hz whose poses last an hour.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import COUNTER, SECONDS_PER, TIME, TimeUnit

COUNTER_PERIOD = 65536  #: the Xsens packet counter has 16 bits; others never jump that far
#: Where counters of 8 to 32 bits begin again, the parts of a second, and the clock at midnight.
PERIODS = (2.0**32, 1e9, 2.0**24, 1e6, 2.0**16, 1e3, 2.0**8, 86_400.0, 86_400_000.0)
EPOCH_S = (1e9, 5e9)  #: seconds since 1970 from 2001 to 2128
FEWEST_ROWS = 100
"""Rows of a clock between two steps back. A judgement: a board that is reset, a phone whose clock
is set and poses below each other count on for a second or more, a misplaced row takes one row."""
MOST_WRAPS = 3.0  #: times a counter begins again, over how often its usual step makes it; judgement
USUAL_STEPS = 20.0  #: a wrapped step is this many usual steps at most

SECONDS_AT_A_TURN = 58  #: fact: of a clock that shows minutes, before the next minute, to a second

SLOWEST_HZ, FASTEST_HZ = 0.4, 40_000.0
"""The slowest sketch prints twice a second; no MEMS sensor gives more than 32 kHz."""
SLOW_HZ, LONGEST_SLOW_S = 5.0, 1800.0
"""Slow logs exist, and long ones; one that is both is a faster one in milliseconds. At 1 kHz that
already shows in a log of two seconds, at 250 Hz the rate itself does."""
ASSUMED_HZ = 100.0
"""Sample rate of poses without a clock: the usual rate of a logger. It decides only whether poses
count as too short for their sds."""
USUAL_HZ = (5.0, 20_000.0)
"""What the likely unit would make of a clock that is out of these bounds."""


@dataclass(frozen=True)
class StatedClock:
    """What the configuration or the caller says of a log's time.

    ``rate_hz`` where there is no column of times; ``unit`` of that column, which settles it.
    Where the clock is not ``needed`` and there is none, samples count as :data:`ASSUMED_HZ`.
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
    """Sample times in seconds, shape (t,), and what was changed in them, in words.

    Parameters
    ----------
    label : str
        What messages call the log.
    values : mapping of str to array, shape (t,)
        The log's columns as they stand in the file, by our names.
    factor : float
        Seconds per unit of the column of times by its name.
    stated : StatedClock
    head_rate_hz : float or None
        The sample rate that the file's head states.
    place : callable
        File and line of a row, for messages.

    Raises
    ------
    UnreadableInput
        No clock, two clocks, one that goes backwards, or one that makes no sense.
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
    """Times (t,) of a clock that was set back or began again, as if it had gone on.

    Every stretch between two steps has to be long, or a step is a misplaced row; such times are
    returned as they are.

    Returns
    -------
    time_s : array, shape (t,)
    notes : tuple of str
        Where the steps are, in words that end a sentence.
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


def unwrapped_ticks(ticks: FloatArray) -> FloatArray:
    """A counter's values as if it never began again.

    A step back is a wrap where it is one whole period of a counter (or a day) short of a usual
    step; any other step back is left for the caller to refuse.

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
    back = np.flatnonzero(step < 0)
    if back.size == 0 or back.size == len(step):
        return ticks
    usual = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
    turned = np.zeros(len(ticks))
    for i in back:
        period = next((p for p in PERIODS if 0 < step[i] + p <= USUAL_STEPS * usual), None)
        if period is None or len(back) > 1 + MOST_WRAPS * usual * len(step) / period:
            return ticks  # noise, which steps back in every second row
        turned[i + 1] = period
    return np.asarray(ticks + np.cumsum(turned))


def _without_clock_face(ticks: FloatArray) -> FloatArray:
    """Seconds of the day of times (t,) like 100059.99, which is followed by 100100.00, as
    receivers of satellites write them; other times as they are."""
    hours, minutes, seconds = ticks // 10_000, ticks // 100 % 100, ticks % 100
    turns = np.flatnonzero(np.diff(minutes))
    is_face = len(turns) and (minutes < 60).all() and (seconds < 60).all() and (hours < 24).all()
    if not is_face or np.median(np.diff(ticks)) > 1 or (seconds[turns] < SECONDS_AT_A_TURN).any():
        return ticks
    return np.asarray(3600 * hours + 60 * minutes + seconds)


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


def _require_sense(label: str, time_s: FloatArray, factor: float) -> None:
    """Refuse a clock that no logger has, and name the unit that the column is likely in."""
    if len(time_s) < 3:
        return
    length = float(time_s[-1] - time_s[0])
    step_s = float(np.median(np.diff(time_s)))
    rate_hz = 1 / step_s
    slow_and_long = rate_hz < SLOW_HZ and length > LONGEST_SLOW_S
    if SLOWEST_HZ < rate_hz < FASTEST_HZ and not slow_and_long:
        return
    units = likely_units(step_s / factor)
    likely = (f"The column is likely in {' or '.join(units)}: write `time_unit: {units[0]}` beside "
              f"the file" if units else "Write `time_unit: ms` (or us, ns) beside the file where "
              "the column is in another unit")
    raise UnreadableInput(
        f"{label}: its clock makes no sense: {len(time_s)} samples in {length:.4g} s are "
        f"{rate_hz:.3g} samples per second; sensors are logged at {USUAL_HZ[0]:g} to "
        f"{USUAL_HZ[1]:g}. "
        f"{likely}, or `time_unit: s` if the seconds are right."
    )
