"""The guess of one table: its clock, its triads, whether its rows are pose means."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.log_units import CELSIUS
from calib.poses.imu_log import TEMPERATURE, TRIADS, FloatArray, ImuLog
from pipeline.devices.line_pattern import WORD_0_C, WORDS_PER_K
from pipeline.errors import UnreadableInput
from pipeline.guess.clocks import (
    ClockGuess,
    guess_clock,
    oldest_first,
    without_ends,
    without_repeats,
)
from pipeline.guess.magnitudes import MPU_PER_G
from pipeline.guess.pool import FEWEST_MEANS, REST_S, are_apart, begins_of, pooled, usual_step
from pipeline.guess.raw_tables import RawTable
from pipeline.guess.sensor_files import names_of_sensors, sensors_of_files
from pipeline.guess.triads import AXIS_COUNT, chosen_triads
from pipeline.guess.turns import Turn, turn_of
from pipeline.guess.units import (
    TriadGuess,
    accelerometer_in,
    clocked_by_turns,
    gyroscope_in,
    per_sample,
)
from pipeline.logs.clock import USUAL_STEPS
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, MINUS, SECONDS_PER, SKIP, TIME, our_name
from pipeline.logs.header import our_names
from pipeline.logs.header_words import read_name
from pipeline.logs.join import join_logs
from pipeline.text.formatting import count

SHOWN = 8  #: columns that a message names
MOST_MEANS = 500  #: largest number of pose means: at ten seconds each, an hour and a half; tuned
INDOORS_C = (5.0, 60.0)
"""Range of °C without heating or cooling; counts are 0 at 25 °C, or thousands. A judgement."""
#: Median rate of a gyroscope, rad/s, above which it is on a turning plate.
TURNING_RAD_S = 0.3


@dataclass(frozen=True, eq=False)
class TableGuess:
    """Guess of one table.

    ``theirs`` maps our names to those in the file; ``are_means``: each row is the mean of a pose.
    ``rate_bias`` (3,), rad/s, is the gyroscope's reading at rest, if other tables show it.
    """

    table: RawTable
    clock: ClockGuess
    accelerometer: TriadGuess | None
    gyroscope: TriadGuess | None
    theirs: dict[str, str]
    are_means: bool
    rate_bias: FloatArray | None = None

    @property
    def path(self) -> Path:
        """The path by which a configuration names it."""
        return self.table.path

    @property
    def doubts(self) -> Iterator[str]:
        """The doubts about it, one sentence each."""
        for triad in (self.accelerometer, self.gyroscope):
            if triad is not None and triad.doubt:
                yield triad.doubt
        if self.clock.doubt and not self.are_means:
            yield self.clock.doubt
        if self.clock.column is not None and not self.are_means:
            step = np.diff(self.clock.time_s)
            pauses = np.flatnonzero(step > max(REST_S, USUAL_STEPS * usual_step(self.clock.time_s)))
            if len(pauses):
                longest = pauses[step[pauses].argmax()]
                at_s = self.clock.time_s[longest] - self.clock.time_s[0]
                yield (f"its clock pauses {count(len(pauses), 'time')}, for "
                       f"{step[pauses].sum():.3g} s in all; the longest pause begins after "
                       f"{at_s:.3g} s and lasts {step[longest]:.3g} s. Nothing is logged in it")
        force = self.accelerometer
        per_g = dict(force.sheet).get("counts_per_g") if force and force.encoding else None
        for name in self.further if per_g in MPU_PER_G else ():
            words = self.table.columns[name]
            warmth = words / WORDS_PER_K + WORD_0_C
            if read_name(name).quantity == "temperature" and _is_within(warmth, INDOORS_C):
                yield (f"its column {name} is in counts and used as it is. By the register map of "
                       f"an MPU-6050 they are {np.nanmedian(warmth):.1f} °C: add a column "
                       f"temperature_c with {name} / {WORDS_PER_K} + {WORD_0_C} for sizes per "
                       f"kelvin")
        if self.table.lost:
            yield (f"lines that are no samples and are left out: {self.table.lost} of "
                   f"{self.table.lost + self.table.rows}")

    @property
    def misses(self) -> Iterator[str]:
        """A sentence on columns that may be a gyroscope and are not taken for one."""
        if self.accelerometer and not self.gyroscope and len(self.further) >= AXIS_COUNT:
            yield (f"no columns turn gravity as a gyroscope's would, or are called so; left are "
                   f"{', '.join(self.further[:SHOWN])}")

    @property
    def further(self) -> list[str]:
        """Columns of numbers that are not readings and may be covariates.

        None without a name, beside others with one: the zone behind a time.
        """
        return [name for name in self.table.columns
                if name not in (*self.theirs.values(), self.clock.column, self.clock.unused)
                and (self.table.positions or not name.isdecimal())]

    @property
    def turning_rad_s(self) -> float:
        """Rate of the gyroscope in most of the table; 0 at rest or without a gyroscope."""
        if self.gyroscope is None:
            return 0.0
        return self.usual_rad_s if self.usual_rad_s > TURNING_RAD_S else 0.0

    @property
    def usual_rad_s(self) -> float:
        """Median length of the gyroscope's reading."""
        return float(np.median(np.linalg.norm(self.rate(), axis=1)))

    def turns_clockwise(self, beside: "TableGuess") -> bool:
        """Whether the rate points down by the accelerometer of ``beside``; False without one."""
        log = joined_log(beside, self)
        if log is None:
            return False
        rate = log.gyroscope - (0.0 if self.rate_bias is None else self.rate_bias)
        # Sample by sample, since a log may hold many attitudes.
        return bool(np.median((rate * log.accelerometer).sum(axis=1)) < 0)

    def turn(self, tables: Sequence["TableGuess"]) -> Turn | None:
        """Turns of gravity in its accelerometer, or in that of another of ``tables`` at the same
        times, compared with its gyroscope in SI units; None if nothing shows them."""
        if self.gyroscope is None or self.are_means or not self.clock.is_known:
            return None
        beside = self if self.accelerometer else next(
            (other for other in tables if other.accelerometer and not other.are_means
             and other.clock.is_known and self.clock.overlaps(other.clock)), None)
        log = joined_log(beside, self) if beside else None
        if log is None or len(log.time_s) < 2:
            return None
        steps = np.diff(log.time_s, append=log.time_s[-1] + usual_step(log.time_s))
        parts = np.cumsum(begins_of(log.time_s), dtype=np.int64)
        return turn_of(log.gyroscope, log.accelerometer, parts, steps)

    def rate(self) -> FloatArray:
        """The readings (t, 3) of the gyroscope without its bias, rad/s."""
        assert self.gyroscope is not None
        rate = self.si(self.gyroscope)
        return rate if self.rate_bias is None else rate - self.rate_bias

    def si(self, triad: TriadGuess) -> FloatArray:
        """The complete readings (t, 3) of a triad, in SI units by its guess."""
        values = self._stacked(triad)
        return triad.si(values[np.isfinite(values).all(axis=1)])

    def _stacked(self, triad: TriadGuess) -> FloatArray:
        return np.column_stack([self.table.columns[name] for name in triad.columns])

    def log(self) -> ImuLog | None:
        """The table as a log in SI units; None if readings are missing."""
        absent = np.full((self.table.rows, 3), np.nan)
        triads: list[FloatArray] = []
        for triad in (self.accelerometer, self.gyroscope):
            values = absent if triad is None else self._stacked(triad)
            if triad is not None and not np.isfinite(values).all():
                return None
            triads.append(values if triad is None else triad.si(values))
        return ImuLog(self.path.name, self.clock.time_s, triads[0], triads[1])

    @property
    def columns(self) -> list[str] | dict[str, str] | None:
        """Value of ``columns`` in a configuration; None if the names in the file are ours."""
        ours = {theirs: name for name, theirs in self.theirs.items()}
        if self.table.positions:
            return [ours.get(name, SKIP) for name in self.table.positions]
        header = self.table.header
        read = dict(zip(our_names(header), header, strict=True))
        time_unused = self.clock.column is None and any(name == TIME for name, _ in read)
        known = all(read.get(our_name(name)) == theirs for name, theirs in self.theirs.items())
        if known and not time_unused:
            return None
        return [ours.get(name, SKIP) for name in header] if time_unused else self.theirs


def joined_log(force: TableGuess, rate: TableGuess) -> ImuLog | None:
    """The log with the accelerometer of one table and the gyroscope of another or the same one;
    None if readings or common times are missing."""
    logs = [log for table in dict.fromkeys((rate, force)) if (log := table.log()) is not None]
    try:
        log = join_logs(logs) if logs else None
    except UnreadableInput:
        return None
    return log if log and all(map(log.has, TRIADS)) else None


def guess_tables(tables: Sequence[RawTable], rate_hz: float | None) -> list[TableGuess | None]:
    """The guess of each table; None for those that hold no triad.

    Tables with the same columns come from one logger and share units and encodings.

    Parameters
    ----------
    tables : sequence of RawTable
    rate_hz : float or None
        The sample rate, stated by the user.
    """
    tables = [replace(table, columns=without_repeats(without_ends(oldest_first(
                  {name: values for name, values in table.columns.items()
                   if np.isfinite(values).any()})))) for table in tables]
    clocks = [guess_clock(table.columns, rate_hz, table.rate_hz) for table in tables]
    hints = sensors_of_files(tables, clocks)
    groups: dict[tuple[object, str, str], list[int]] = {}
    for i, (table, hint, name) in enumerate(
            zip(tables, hints, names_of_sensors(tables), strict=True)):
        groups.setdefault((tuple(table.columns), hint, name), []).append(i)
    guesses: list[TableGuess | None] = [None] * len(tables)
    for (_, hint, _), group in groups.items():
        every = _guess_group([tables[i] for i in group], [clocks[i] for i in group], hint)
        for i, guess in zip(group, every, strict=True):
            guesses[i] = guess
    return guesses


def _guess_group(
    tables: Sequence[RawTable], clocks: list[ClockGuess], hint: str
) -> list[TableGuess | None]:
    """Guesses of tables with the same columns; ``hint`` is the sensor by the files' names."""
    if hint == "else":
        return [None] * len(tables)
    pool = pooled(tables, clocks, hint)
    chosen = chosen_triads(pool)
    force, rate = chosen.force, chosen.rate
    # Few logs may differ in their units; of a pose alone few levels show no sensor, or another one.
    if force is None and rate is None and 1 < len(tables) < FEWEST_MEANS:
        return [_guess_group([table], [clock], hint)[0]
                for table, clock in zip(tables, clocks, strict=True)]
    accelerometer = accelerometer_in(force, chosen) if force else None
    gyroscope = gyroscope_in(rate, force, accelerometer) if rate else None
    if accelerometer and gyroscope and pool.has_clock:
        accelerometer, gyroscope = per_sample(accelerometer, gyroscope, pool.step_s)
    if force and rate and gyroscope and not pool.has_clock:
        clocks = clocked_by_turns(clocks, rate, force, gyroscope)
    if accelerometer is None and gyroscope is None:
        return [None] * len(tables)
    return [_table_guess(table, clock, accelerometer, gyroscope)
            for table, clock in zip(tables, clocks, strict=True)]


def _table_guess(
    table: RawTable, clock: ClockGuess, accelerometer: TriadGuess | None,
    gyroscope: TriadGuess | None,
) -> TableGuess:
    """The guess of one table from the clock and the triads of its group."""
    theirs: dict[str, str] = {}
    if clock.column is not None:
        unit = clock.unit or "s"
        theirs[TIME if SECONDS_PER[unit] == 1 else f"time_{unit}"] = clock.column
    for names, triad in ((ACCELEROMETER, accelerometer), (GYROSCOPE, gyroscope)):
        if triad is not None:
            sign = MINUS if triad.si_per_unit < 0 else ""
            theirs |= dict(zip([sign + name for name in names], triad.columns, strict=True))
    theirs |= dict(_further(table, accelerometer, gyroscope))
    guess = TableGuess(table, clock, accelerometer, gyroscope, theirs, False)
    if accelerometer is None:
        return guess
    values = guess.si(accelerometer)
    return replace(guess, are_means=len(values) <= MOST_MEANS and are_apart(values))


def _further(
    table: RawTable, accelerometer: TriadGuess | None, gyroscope: TriadGuess | None
) -> Iterator[tuple[str, str]]:
    """Our names and the file's of temperature, sds and numbers of samples."""
    every = [(name, read_name(name)) for name in table.columns]
    for name, words in every:
        bounds = {"celsius": CELSIUS, "": INDOORS_C}.get(words.unit)
        if words.quantity == "temperature" and bounds and _is_within(table.columns[name], bounds):
            yield TEMPERATURE, name
            break
    for name, words in every:
        if words.quantity == "samples":
            yield "samples", name
        if words.quantity == "sd" and words.axis is not None:
            of_gyroscope = "gyr" in words.stem and gyroscope is not None
            if of_gyroscope or accelerometer is not None:
                yield f"sd_{(GYROSCOPE if of_gyroscope else ACCELEROMETER)[words.axis]}", name


def _is_within(values: FloatArray, bounds: tuple[float, float]) -> bool:
    """Whether the median is within ``bounds``, as of °C, unlike counts; False without values."""
    known = values[np.isfinite(values)]
    return bool(known.size) and bounds[0] < float(np.median(known)) < bounds[1]
