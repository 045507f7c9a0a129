"""The clock of a table: a column of times and its unit, a counter, or a rate."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.logs.clock import (
    ASSUMED_HZ,
    EPOCH_S,
    SLOWEST_HZ,
    USUAL_HZ,
    USUAL_STEPS,
    continued_clock,
    likely_units,
    makes_sense,
    unwrapped_ticks,
    within_the_log,
)
from pipeline.logs.columns import SECONDS_PER, TIME, TimeUnit, our_name
from pipeline.logs.head import FEWEST_NUMBERS
from pipeline.logs.header_words import read_name
from pipeline.logs.read import newest_first, repeats

INTERVALS = {"dt", "deltat", "deltatime", "looptime", "interval", "period", "steptime"}
"""Names of a column of the times since the row before."""
FIRST = 2  #: fact: leading columns that may hold seconds and their parts, before those of a triad


@dataclass(frozen=True, eq=False)
class ClockGuess:
    """The clock of a table, as a configuration states it.

    ``column`` in the file with its ``unit``, or ``rate_hz``; ``time_s`` (t,) are the times by them.
    ``lacks`` says why there is no column; ``unused`` is the one that cannot be used.
    """

    column: str | None
    unit: TimeUnit | None
    rate_hz: float | None
    time_s: FloatArray
    because: str
    doubt: str = ""
    lacks: str = "the file holds no times"
    unused: str = ""

    @property
    def is_known(self) -> bool:
        """Whether the file or the user states it."""
        return self.column is not None or self.rate_hz is not None

    def at(self, rate_hz: float, shown: str) -> "ClockGuess":
        """The clock of a file without times at a rate that its readings show."""
        return replace(self, rate_hz=rate_hz, time_s=self.time_s * ASSUMED_HZ / rate_hz,
                       because="its readings agree at it", doubt=f"{self.lacks}; {shown}")

    def overlaps(self, other: "ClockGuess") -> bool:
        """Whether their times overlap by more than half of the shorter one."""
        a, b = self.time_s, other.time_s
        common = min(a[-1], b[-1]) - max(a[0], b[0])
        return bool(common > 0.5 * min(a[-1] - a[0], b[-1] - b[0]))


def guess_clock(
    columns: Mapping[str, FloatArray], stated_hz: float | None, file_hz: float | None
) -> ClockGuess:
    """The clock of ``columns``; the user states ``stated_hz``, the file's head ``file_hz``."""
    rows = len(next(iter(columns.values())))
    note, lacks, unused = "", ClockGuess.lacks, ""
    if stated_hz is None:
        for name in _candidates(columns):
            ticks, _ = continued_clock(unwrapped_ticks(columns[name]))  # `run` tells of its steps
            ours, factor = our_name(name)
            if ours == TIME and (np.diff(ticks) > 0).all() and (
                    rows < 2 or "s" in likely_units(float(np.median(np.diff(ticks))) * factor)):
                unit = next((unit for unit in SECONDS_PER if SECONDS_PER[unit] == factor), None)
                return ClockGuess(name, unit, None, ticks * factor, "its name is a known program's")
            step = np.diff(ticks)
            if len(step) and not step.any():
                lacks = f"'{name}' reads {ticks[0]:.10g} in every row, a clock that stands still"
                unused = name
            unit, because, doubt = _unit(name, ticks)
            if unit is not None and (step > 0).all():
                return ClockGuess(name, unit, None, ticks * SECONDS_PER[unit], because, doubt)
            is_named = read_name(name).quantity == "time" or bool(_epoch_units(ticks[0]))
            if unit is not None and is_named and (step > 0).any():
                ticking = int((step > 0).sum())
                if 2 * (step < 0).sum() > ticking:
                    continue  # noise steps back as often
                rate = 1 / (_row_step(step) * SECONDS_PER[unit])
                repeated = int((step <= 0).sum())
                note = (f"'{name}' repeats or goes back {repeated} times, so it is not used")
                unused = name
                file_hz = file_hz or float(f"{rate:.4g}")
    intervals = "" if stated_hz or file_hz else _intervals(columns)
    if intervals:
        unit = _unit(intervals, np.cumsum(columns[intervals]))[0]
        file_hz = float(f"{1 / (columns[intervals].mean() * SECONDS_PER[unit or 's']):.4g}")
    rate_hz = stated_hz or file_hz
    if rate_hz is None:
        return ClockGuess(None, None, None, np.arange(rows) / ASSUMED_HZ, "",
                          f"{lacks}, and nothing states the sample rate; state it by --rate-hz",
                          lacks, unused)
    because = ("--rate-hz" if stated_hz else "the mean of the times" if note else
               f"the mean of '{intervals}'" if intervals else "the file's head")
    return ClockGuess(None, None, rate_hz, np.arange(rows) / rate_hz, because, note, lacks, unused)


def _row_step(step: FloatArray) -> float:
    """Mean step (t - 1,) of a clock that ticks every few rows: from its first tick to the last.

    A board that was reset begins again far back; a misplaced row goes back by as much as on.
    """
    ticks = np.flatnonzero(step > 0)
    between = step[ticks[0] + 1 : ticks[-1] + 1]
    usual = between[np.abs(between) <= USUAL_STEPS * np.median(step[step > 0])]
    mean = float(usual.mean()) if usual.size else 0.0
    return mean if mean > 0 else float(step[step >= 0].mean())


def _intervals(columns: Mapping[str, FloatArray]) -> str:
    """The column of the times since the row before, as ``dt``; empty if there is none."""
    return next((name for name, values in columns.items() if read_name(name).stem in INTERVALS
                 and (values >= 0).all() and _unit(name, np.cumsum(values))[0]), "")


def _candidates(columns: Mapping[str, FloatArray]) -> list[str]:
    """Columns that may be times: by name or as time since 1970, else a leading one that grows."""
    named = [name for name in columns if read_name(name).quantity == "time"]
    # A unit in the name settles it; of several, the time of the sample comes before others.
    named.sort(key=lambda name: (read_name(name).unit == "", "sample" not in name.lower(),
                                 "tick" in name.lower()))
    since_1970 = [name for name, values in columns.items() if name not in named and len(values) > 1
                  and _epoch_units(values[0]) and np.median(np.diff(values)) > 0]
    if named or since_1970:
        return [*named, *since_1970]
    # Leading columns that no name calls another quantity, except a row number, even one that begins
    # again after 255.
    return [name for name in islice(columns, FIRST) if len(columns) > FEWEST_NUMBERS
            and not read_name(name).quantity
            and (step := np.diff(continued_clock(unwrapped_ticks(columns[name]))[0])
                 ).min(initial=1) > 0 and not (step == 1).all()]


def without_ends(columns: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Columns without a first or last row whose time stands apart from the others."""
    clocks = _candidates({name: values[1:-1] for name, values in columns.items()})
    kept = [within_the_log(columns[name]) for name in clocks[:1]]
    return {name: values[kept[0]] for name, values in columns.items()} if kept else columns


def oldest_first(columns: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Columns whose times grow: of a table that begins with its newest row in the other order."""
    backward = any(newest_first(columns[name]) for name in _candidates(columns)[:1])
    return {name: values[::-1] for name, values in columns.items()} if backward else columns


def without_repeats(columns: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Columns without the rows that are there twice, if only these repeat a time."""
    for name in _candidates(columns):
        others = [values for called, values in columns.items()
                  if called != name and read_name(called).quantity != "counter"]
        again = repeats([columns[name], *others])
        if again.any() and len(np.unique(columns[name][~again])) == (~again).sum():
            return {called: values[~again] for called, values in columns.items()}
    return columns


def _epoch_units(ticks: float) -> list[TimeUnit]:
    """The units in which a time may be counted from 1970."""
    return [unit for unit in SECONDS_PER
            if unit != "d" and EPOCH_S[0] < ticks * SECONDS_PER[unit] < EPOCH_S[1]]


def _unit(name: str, ticks: FloatArray) -> tuple[TimeUnit | None, str, str]:
    """The unit of a column of times, the reason and the doubts."""
    steps = np.diff(ticks)
    forward = steps[steps >= 0]  # most are 0 for a clock in whole seconds
    usual = float(np.median(forward) or forward.mean()) if forward.any() else 0.0
    if not usual > 0:
        return None, "", ""
    likely = likely_units(usual)
    since_1970 = [unit for unit in _epoch_units(ticks[0])
                  if not likely or usual * SECONDS_PER[unit] < 1 / SLOWEST_HZ]
    stated = next((unit for unit in SECONDS_PER if unit == read_name(name).unit), None)
    rate = f"rows {float(f'{usual:.4g}'):.10g} apart"
    if stated is not None and (stated in likely or not likely or (
            usual * SECONDS_PER[stated] * USUAL_HZ[0] > 1  # slow, as of a file for each pose
            and (steps > 0).all() and makes_sense(ticks * SECONDS_PER[stated])) or (
            stated == "min" and "s" in likely_units(usual * SECONDS_PER[stated]))):
        return stated, "its name states the unit", ""
    if since_1970:
        return since_1970[0], "it counts from 1970", ""
    if not likely:
        return "s", rate, f"{rate} make no usual sample rate in any unit"
    doubt = ""
    if stated is not None:
        doubt = f"its name states {stated}, but {rate} are usual in {likely[0]} only"
    elif len(likely) > 1:
        doubt = f"{rate} are usual in {' and in '.join(likely)}"
    return likely[0], rate, doubt
