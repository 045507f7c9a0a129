"""Rates at which the tables of a session turn, and the range of the gyroscope by them.

The range follows from a true rate of another origin: a clip, gravity that rotates once per turn in
the accelerometer on a tilted plate, the speeds of record players, or the user.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.clock import gravity_wave
from calib.numbers import RPM
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from pipeline.config.units import UNIT_WORDS
from pipeline.guess.magnitudes import (
    CODES,
    COUNTS_PER_DEG_S,
    OFFSET_BINARY,
    RARE_COUNTS_PER_DEG_S,
    ST_SHARE,
    USUAL_COUNTS_PER_DEG_S,
    near_scales,
    record_rpm,
)
from pipeline.guess.pool import FEWEST_MEANS, common_mean, sphere_through
from pipeline.guess.speeds import NEAR_CLIP, speeds_in, speeds_of
from pipeline.guess.table_guess import TURNING_RAD_S, TableGuess
from pipeline.guess.units import TriadGuess, rate_unit
from pipeline.logs.clock import ASSUMED_HZ

SI = TriadSpec(float("inf"), 0, "si")
APART = 3.0
"""Least ratio of a reading on the plate to one at rest: a bias of 20 °/s, and 16 rpm."""
CALLED = re.compile(r"(\d+(?:[.,]\d+)?)[ _-]?rpm|(?<!\d)(33)(?!\d)", re.IGNORECASE)
"""A speed in a name; 33 is one alone too: no day, no hour and no usual angle."""
LARGEST_MISFIT = 0.05
"""Largest scatter of the mean rates about a sphere, over its radius: axes of a gyroscope differ by
3 %. A judgement."""


@dataclass(frozen=True)
class MeasuredClip:
    """A clip and the rate of the plate in it, rad/s, positive counter-clockwise as filmed."""

    path: Path
    rate_rad_s: float


@dataclass(frozen=True)
class ScaleChoice:
    """A possible unit or range of the gyroscope, with ``per_deg`` units per °/s.

    ``rpm`` is the speed of the plate that follows from it, None at rest.
    """

    per_deg: float
    rpm: float | None

    @property
    def unit(self) -> str:
        """The unit; empty for counts."""
        return rate_unit(self.per_deg)

    @property
    def answer(self) -> str:
        """Value of the option: the unit, or the full scale in °/s of a sensor of 16 bits."""
        return self.unit or f"{CODES / 2 / self.per_deg:g}"

    @property
    def says(self) -> str:
        """The unit or the range, and the speed that would follow from it."""
        name = UNIT_WORDS.get(self.unit) or f"±{self.answer} °/s"
        return name + ("" if self.rpm is None else f" would be {self.rpm:.3g} rpm")


Settled = tuple[list[TableGuess], tuple[ScaleChoice, ...]]
"""Tables, and the possible scales of their gyroscope that remain."""


def settle_scale(
    tables: Sequence[TableGuess], clips: Sequence[MeasuredClip], stated_per_deg: float | None
) -> Settled:
    """Decide the unknown scale of a gyroscope by the first evidence that is available.

    Parameters
    ----------
    tables : sequence of TableGuess
    clips : sequence of MeasuredClip
    stated_per_deg : float or None
        Units per °/s, stated by the user; those of a range are 13 % fewer in ST's parts.
    """
    if stated_per_deg is not None:
        stated = (stated_per_deg,) if rate_unit(stated_per_deg) else (
            stated_per_deg, ST_SHARE * stated_per_deg)
        tables = [replace(table, gyroscope=replace(table.gyroscope, choices=stated))
                  if table.gyroscope else table for table in tables]
    undecided = [table for table in tables if table.gyroscope and table.gyroscope.choices]
    if not undecided:
        return [*tables], ()
    gyroscope = undecided[0].gyroscope
    assert gyroscope is not None
    for table in undecided:
        turn = table.turn(tables)
        if turn is not None and turn.is_exact:
            shown = math.radians(1) / (gyroscope.si_per_unit * turn.si_per_unit)
            able = near_scales(shown, gyroscope.choices)
            if not able and gyroscope.encoding == OFFSET_BINARY:  # raw counts with their own gain
                able = (float(f"{shown:.3g}"),)
            if len(able) != 1:
                continue
            return _settled(tables, able[0], (
                f"between the rests gravity then turns as far as in the accelerometer "
                f"(correlation {turn.agreement:.2f})"), [table])
    turning = _turning(undecided)
    # Lengths are in rad/s at the first scale; at another they are multiplied by the ratio.
    first = math.radians(1) / gyroscope.si_per_unit
    lengths = np.array([_plate_rad_s(table) for table in turning])
    usual = gyroscope.choices if stated_per_deg or gyroscope.encoding in ("", OFFSET_BINARY) else (
        *gyroscope.choices, *USUAL_COUNTS_PER_DEG_S[len(COUNTS_PER_DEG_S):])
    for factors, because, seen, may_be_unusual in (
            _known_factors(turning, lengths, clips) if turning else ()):
        near = [(abs(math.log(first / factor / scale)), scale) for factor in factors
                for scale in near_scales(first / factor, usual)]
        if near or (may_be_unusual and not stated_per_deg):
            return _settled(
                tables, min(near)[1] if near else float(f"{first / factors[0]:.3g}"), because, seen)
    rates_of = [(per_deg, lengths * first / per_deg) for per_deg in usual]
    at_speed = [(per_deg, rates) for per_deg, rates in rates_of
                if turning and all(map(record_rpm, rates))]
    if len(at_speed) == 1:
        because = "the plate then turns at a speed of record players, as by no other usual range"
        return _settled(tables, at_speed[0][0], because, turning, _rare_ranges(lengths * first))
    if stated_per_deg is not None:
        return _settled(tables, stated_per_deg, "as it is stated", tables)
    return [*tables], tuple(
        ScaleChoice(per_deg, nominal_rpm(float(np.median(rates))) if turning else None)
        for per_deg, rates in at_speed or rates_of[: len(gyroscope.choices)])


def _rare_ranges(rates: FloatArray) -> str:
    """The doubt whether a range that few sensors have is its own, by which the plate turns as a
    record player too; ``rates`` (n,) are rad/s at 1 count per °/s."""
    rare = [ScaleChoice(choice, rpm) for choice in RARE_COUNTS_PER_DEG_S
            if (rpm := record_rpm(float(np.median(rates)) / choice))]
    return "".join(f"only the speed of the plate shows its range, and {one.says}; if that is its "
                   f"speed, state --gyroscope-range {one.answer}" for one in rare)


def clocked_by_plate(tables: Sequence[TableGuess]) -> list[TableGuess]:
    """Tables, and those without a clock at the sample rate at which gravity goes round on the
    plate as fast as the gyroscope says, or the record player whose speed that is."""
    unclocked = [table for table in tables if not table.clock.is_known and not table.are_means
                 and table.gyroscope and not table.gyroscope.choices]
    turning = _turning(unclocked) if unclocked else []
    shown = _rate_by_gravity(
        turning, np.array([table.usual_rad_s for table in turning])) if turning else None
    if shown is None:
        return [*tables]
    rpm = nominal_rpm(shown[1])
    hz = float(f"{ASSUMED_HZ * rpm * RPM / shown[0]:.3g}")
    return [replace(table, clock=table.clock.at(hz, (
        f"at {hz:g} Hz gravity goes round at the {rpm:.3g} rpm of the gyroscope. State another "
        f"rate by --rate-hz"))) if table in unclocked else table for table in tables]


def _plate_rad_s(table: TableGuess) -> float:
    """The fastest speed of the plate in a log of many poses, else the usual rate in a table."""
    many = speeds_in(table, table) if table.rate_bias is None else []
    return max((speed for speed, _ in many), default=table.usual_rad_s)


def _known_factors(
    tables: Sequence[TableGuess], lengths: FloatArray, clips: Sequence[MeasuredClip]
) -> Iterator[tuple[FloatArray, str, Sequence[TableGuess], bool]]:
    """Ratios of the true rates to the gyroscope's, with their origin and the tables that show it,
    the best evidence first, and whether it shows an unusual range too."""
    speeds = np.array(sorted({*speeds_of(list(lengths))}))
    rates = np.array([abs(clip.rate_rad_s) for clip in clips])
    every = (rates[:, None] / speeds).ravel()
    shown = [factor for factor in every if all(
        np.abs(np.log(rate / (speeds * factor))).min() < NEAR_CLIP for rate in rates)]
    if shown:
        rpm = ", ".join(f"{rate / RPM:.4g}" for rate in rates)
        yield np.array(shown), f"the plate turns at {rpm} rpm in the clip", tables, True
    if (shown_by := _rate_by_gravity(tables, lengths)) is not None:
        rate, measured, seen = shown_by
        yield np.array([rate / measured]), (
            f"gravity goes round at {rate / RPM:.4g} rpm in the accelerometer"), seen, True
    names = [CALLED.search("/".join(table.path.parts[-3:])) for table in tables]
    named = [nominal_rpm(float((name[1] or name[2]).replace(",", ".")) * RPM) * RPM
             for name in names if name]
    if len(named) == len(names):
        factors = np.array(named) / lengths
        if float(np.ptp(np.log(factors))) < NEAR_CLIP:
            called = "as the speed by which the files are called"
            yield np.array([np.median(factors)]), called, tables, all(
                name and name[1] for name in names)


def _turning(tables: Sequence[TableGuess]) -> list[TableGuess]:
    """Tables from the turning plate: their rates are clearly above those of others or a bias."""
    lengths = np.array([table.usual_rad_s for table in tables])
    order = np.sort(lengths)
    steps = order[1:] / np.maximum(order[:-1], np.finfo(float).tiny)
    limit = TURNING_RAD_S
    if steps.size and steps.max() > APART:
        above = order[int(np.argmax(steps)) + 1]
        scales = [scale for table in tables[:1] if table.gyroscope
                  for scale in table.gyroscope.choices] or COUNTS_PER_DEG_S
        if above > TURNING_RAD_S * min(scales) / scales[0]:
            limit = min(limit, 0.99 * float(above))
    return [table for table, length in zip(tables, lengths, strict=True) if length > limit]


def _rate_by_gravity(
    tables: Sequence[TableGuess], lengths: FloatArray
) -> tuple[float, float, list[TableGuess]] | None:
    """Rate of rotation of gravity in the tables of the most frequent speed, that of the gyroscope
    in them, rad/s, and these tables; None if unclear."""
    speeds = speeds_of(list(lengths))
    typical = max(speeds, key=speeds.count)
    ways = [table.turns_clockwise(table) for table in tables]
    near = [table for table, speed, way in zip(tables, speeds, ways, strict=True)
            if table.accelerometer and speed == typical and way == (2 * sum(ways) > len(ways))]
    logs = [log for table in near if (log := table.log()) is not None]
    if not logs:
        return None
    waves = [gravity_wave(logs, np.full(len(logs), typical * COUNTS_PER_DEG_S[0] / per_deg), SI)
             for per_deg in COUNTS_PER_DEG_S]
    clear = [wave for wave in waves if wave is not None and wave.is_clear]
    return (abs(max(clear, key=lambda wave: wave.share).rate), typical, near) if clear else None


def _settled(
    tables: Sequence[TableGuess], per_deg: float, because: str, seen: Sequence[TableGuess],
    doubt: str = "",
) -> Settled:
    """The tables with ``per_deg`` units per °/s where this was unknown, because of what is ``seen``
    in some of them, with its ``doubt``, and rescaled biases."""
    return [
        replace(table, gyroscope=(scaled := table.gyroscope.scaled(
                    per_deg, because if table in seen else "as in the other files", doubt)),
                rate_bias=None if table.rate_bias is None else
                table.rate_bias * scaled.si_per_unit / table.gyroscope.si_per_unit)
        if table.gyroscope and table.gyroscope.choices else table for table in tables], ()


def without_rate_bias(tables: Sequence[TableGuess]) -> list[TableGuess]:
    """Tables with the bias of their gyroscope, if they determine it together.

    On the plate the mean rates of poses lie on a sphere about the bias; at rest they equal it.
    """
    groups: dict[TriadGuess, list[TableGuess]] = {}
    for table in tables:
        if table.gyroscope is not None and not table.are_means:
            groups.setdefault(table.gyroscope, []).append(table)
    biases = {gyroscope: _rate_bias(np.array([np.median(table.si(gyroscope), axis=0)
                                              for table in group]))
              for gyroscope, group in groups.items() if len(group) >= FEWEST_MEANS}
    return [table if table.gyroscope is None else
            replace(table, rate_bias=biases.get(table.gyroscope)) for table in tables]


def _rate_bias(means: FloatArray) -> FloatArray | None:
    """The bias by the mean rates (n, 3) of poses; None if they do not show one."""
    sphere = sphere_through(means)
    if sphere is not None and sphere.misfit < LARGEST_MISFIT:
        return sphere.centre
    return common_mean(means)


def matching_clip(rate_rad_s: float, clips: Sequence[MeasuredClip]) -> MeasuredClip | None:
    """The clip with a signed rate of the plate, else one with the same speed; None if none."""
    near = [clip for clip in clips
            if abs(math.log(abs(clip.rate_rad_s / rate_rad_s))) < NEAR_CLIP]
    return min(near, key=lambda clip: (clip.rate_rad_s * rate_rad_s < 0, abs(math.log(
        abs(clip.rate_rad_s / rate_rad_s)))), default=None)


def nominal_rpm(rate_rad_s: float) -> float:
    """The nominal speed of record players near a rate, rpm; else the rate in four digits."""
    return record_rpm(abs(rate_rad_s)) or float(f"{abs(rate_rad_s) / RPM:.4g}")
