"""At which rate the tables of a session turn, and what range of the gyroscope follows from it.

The range shows where the true rate is known from elsewhere: a clip, gravity that goes round once
per turn in the accelerometer of a plate that leans, the speeds of record players, or the user.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.clock import gravity_wave
from calib.numbers import RPM
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from pipeline.guess.magnitudes import COUNTS_PER_DEG_S, RECORD_RPM, RPM_TOLERANCE, record_rpm
from pipeline.guess.table_guess import TURNING_RAD_S, TableGuess

SI = TriadSpec(float("inf"), 0, "si")
RANGES_DEG_S = (250.0, 500.0, 1000.0, 2000.0)  #: fact: of 16 bits, by COUNTS_PER_DEG_S
NEAR_RANGE = math.log(1.3)
"""Logarithm of a gyroscope's gain over that of its range: ranges are a factor of two apart."""
APART = 3.0
"""Times the reading at rest that one on the plate is at least: a bias of 20 °/s, and 16 rpm."""
NEAR_CLIP = math.log(1.15)
"""Logarithm of the gyroscope's rate over a clip's: its gain may be 10 % off. Also of tables of one
speed."""


@dataclass(frozen=True)
class MeasuredClip:
    """A clip and the rate of the plate in it, rad/s, positive counter-clockwise as filmed."""

    path: Path
    rate_rad_s: float


@dataclass(frozen=True)
class RangeChoice:
    """A range that nothing rules out, and the speed of the plate that it stands for."""

    deg_s: float
    rpm: float


@dataclass(frozen=True, eq=False)
class Settled:
    """The tables with the range of their gyroscope.

    ``because`` says what decided, empty where there was nothing to decide; ``choices`` are the
    ranges among which nothing decides.
    """

    tables: tuple[TableGuess, ...]
    because: str = ""
    choices: tuple[RangeChoice, ...] = ()


def settle_range(
    tables: Sequence[TableGuess], clips: Sequence[MeasuredClip], stated_deg_s: float | None
) -> Settled:
    """Decide the range of a gyroscope in counts, by the first evidence that there is.

    Parameters
    ----------
    tables : sequence of TableGuess
    clips : sequence of MeasuredClip
    stated_deg_s : float or None
        The full scale as the user states it.
    """
    undecided = [table for table in tables if table.gyroscope and table.gyroscope.is_open]
    if not undecided:
        return Settled(tuple(tables))
    decided = [table.gyroscope for table in tables if table.gyroscope
               and "counts_per_deg_s" in dict(table.gyroscope.sheet)
               and not table.gyroscope.is_open]
    if stated_deg_s is not None:
        return _settled_range(tables, stated_deg_s, "as it is stated")
    if decided:
        per_deg = float(dict(decided[0].sheet)["counts_per_deg_s"])
        return _settled_range(tables, RANGES_DEG_S[0] * COUNTS_PER_DEG_S[0] / per_deg,
                           "as in the other files")
    turning = _turning(undecided)
    if not turning:
        return Settled(tuple(tables))
    lengths = np.array([_length(table) for table in turning])
    if clips:
        factor = _factor_by_clips(lengths, np.array([abs(clip.rate_rad_s) for clip in clips]))
        if factor is not None:
            rpm = ", ".join(f"{abs(clip.rate_rad_s) / RPM:.4g}" for clip in clips)
            return _settled_range(tables, RANGES_DEG_S[0] * factor,
                               f"the plate turns at {rpm} rpm in the clip")
    if (rate := _rate_by_gravity(turning, lengths)) is not None:
        factor = _nearest_factor(rate / float(np.median(lengths)))
        if factor is not None:
            return _settled_range(tables, RANGES_DEG_S[0] * factor, (
                f"gravity goes round at {rate / RPM:.4g} rpm in the accelerometer"))
    choices = tuple(_ranges_by_speed(lengths))
    if len(choices) == 1:
        return _settled_range(tables, choices[0].deg_s, (
            f"the plate then turns at {choices[0].rpm:.3g} rpm, and no other range makes a speed "
            f"of record players"))
    return Settled(tuple(tables), "", choices or tuple(
        RangeChoice(deg_s, float(np.median(lengths)) * deg_s / RANGES_DEG_S[0] / RPM)
        for deg_s in RANGES_DEG_S))


def _length(table: TableGuess) -> float:
    """Median length of the gyroscope's reading at the first range, rad/s."""
    assert table.gyroscope is not None
    return float(np.median(np.linalg.norm(table.si(table.gyroscope), axis=1)))


def _turning(tables: Sequence[TableGuess]) -> list[TableGuess]:
    """Tables from the turning plate: they read clearly more than others, or more than a bias."""
    lengths = np.array([_length(table) for table in tables])
    order = np.sort(lengths)
    steps = order[1:] / np.maximum(order[:-1], np.finfo(float).tiny)
    limit = TURNING_RAD_S
    if steps.size and steps.max() > APART:
        above = order[int(np.argmax(steps)) + 1]
        if above > TURNING_RAD_S * RANGES_DEG_S[0] / RANGES_DEG_S[-1]:
            limit = min(limit, 0.99 * float(above))
    return [table for table, length in zip(tables, lengths, strict=True) if length > limit]


def _nearest_factor(ratio: float) -> float | None:
    """The range over the first one that is nearest to a ratio; None where none is near."""
    factors = [deg_s / RANGES_DEG_S[0] for deg_s in RANGES_DEG_S]
    nearest = min(factors, key=lambda factor: abs(math.log(ratio / factor)))
    return nearest if abs(math.log(ratio / nearest)) < NEAR_RANGE else None


def _factor_by_clips(lengths: FloatArray, rates: FloatArray) -> float | None:
    """The factor with which every table turns as one of the clips does."""
    cost = {deg_s / RANGES_DEG_S[0]: max(
        float(np.abs(np.log(rates / (length * deg_s / RANGES_DEG_S[0]))).min())
        for length in lengths) for deg_s in RANGES_DEG_S}
    best = min(cost, key=lambda factor: cost[factor])
    return best if cost[best] < NEAR_RANGE else None


def _rate_by_gravity(tables: Sequence[TableGuess], lengths: FloatArray) -> float | None:
    """The rate at which gravity goes round in tables of the median rate, rad/s; None if unclear."""
    typical = float(np.median(lengths))
    ways = [table.turns_clockwise for table in tables]
    near = [table for table, length, way in zip(tables, lengths, ways, strict=True)
            if table.accelerometer and abs(math.log(length / typical)) < NEAR_CLIP
            and way == (2 * sum(ways) > len(ways))]
    logs = [log for table in near if (log := table.log()) is not None]
    if not logs:
        return None
    waves = [gravity_wave(logs, np.full(len(logs), typical * deg_s / RANGES_DEG_S[0]), SI)
             for deg_s in RANGES_DEG_S]
    clear = [wave for wave in waves if wave is not None and wave.is_clear]
    return abs(max(clear, key=lambda wave: wave.share).rate) if clear else None


def _ranges_by_speed(lengths: FloatArray) -> Iterator[RangeChoice]:
    """Ranges at which every table turns at a speed of record players."""
    for deg_s in RANGES_DEG_S:
        speeds = [record_rpm(length * deg_s / RANGES_DEG_S[0]) for length in lengths]
        if all(speed is not None for speed in speeds):
            median = float(np.median(lengths)) * deg_s / RANGES_DEG_S[0] / RPM
            yield RangeChoice(deg_s, min(RECORD_RPM, key=lambda rpm: abs(rpm - median)))


def _settled_range(tables: Sequence[TableGuess], deg_s: float, because: str) -> Settled:
    per_deg = COUNTS_PER_DEG_S[0] * RANGES_DEG_S[0] / deg_s
    return Settled(tuple(
        replace(table, gyroscope=table.gyroscope.ranged(per_deg, because))
        if table.gyroscope and table.gyroscope.is_open else table
        for table in tables), because)


def matching_clip(rate_rad_s: float, clips: Sequence[MeasuredClip]) -> MeasuredClip | None:
    """The clip in which the plate turns at a signed rate, else at the same speed; None if none."""
    near = [clip for clip in clips
            if abs(math.log(abs(clip.rate_rad_s / rate_rad_s))) < NEAR_CLIP]
    return min(near, key=lambda clip: (clip.rate_rad_s * rate_rad_s < 0, abs(math.log(
        abs(clip.rate_rad_s / rate_rad_s)))), default=None)


def nominal_rpm(rate_rad_s: float) -> float:
    """The speed of record players that a filmed rate is, else the rate itself, to 0.1 %."""
    rpm = abs(rate_rad_s) / RPM
    nearest = min(RECORD_RPM, key=lambda speed: abs(rpm / speed - 1))
    return nearest if abs(rpm / nearest - 1) < RPM_TOLERANCE else float(f"{rpm:.4g}")


def speeds_of(rates_rad_s: Sequence[float]) -> list[float]:
    """The speed of each table, rad/s: the median of all tables of about its rate; 0 at rest.

    A bias makes the tables of one speed read differently from attitude to attitude.
    """
    speeds = [0.0] * len(rates_rad_s)
    order = [i for i in np.argsort(rates_rad_s) if rates_rad_s[i] > 0]
    begins = [k for k, i in enumerate(order)
              if k == 0 or math.log(rates_rad_s[i] / rates_rad_s[order[k - 1]]) > NEAR_CLIP]
    ends = [*begins[1:], len(order)] if begins else []
    for begin, end in zip(begins, ends, strict=True):
        group = order[begin:end]
        median = float(np.median([rates_rad_s[i] for i in group]))
        for i in group:
            speeds[i] = median
    return speeds
