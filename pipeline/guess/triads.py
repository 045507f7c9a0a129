"""Which columns of a table are the accelerometer's and the gyroscope's, and in what unit."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import FloatArray
from pipeline.guess.magnitudes import (
    FORCE_UNITS,
    GRAVITY_TOLERANCE,
    LEAST_AGREEMENT,
    LOOSEST,
    RATE_UNITS,
    GravityUnit,
    decoded,
    gravity_unit,
    rate_scale,
    typical_length,
)
from pipeline.logs.header_words import read_name, whole_triples

AXIS_COUNT = 3  #: fact: of a triad
BITS = 16  #: fact: of the converters in use; a smaller one gives words of 16 bits too
UNIT_WORDS = {"m_s2": "m/s²", "rad_s": "rad/s", "deg_s": "°/s", "mrad_s": "mrad/s",
              "mdeg_s": "m°/s"}
LEAST_SCATTER = 0.03
"""Axes of one sensor scatter alike, by noise or by attitude; a magnetometer's beside it do not."""

SURE_AGREEMENT = 0.8
"""Correlation of turns by three columns and by gravity that makes them a gyroscope whatever they
are called. A judgement: those of sound logs in ``tests`` are 0.9 or more."""
NEARLY_ALL = 0.99  #: share of rows; a few may be written while the sensor starts
UNIT_LENGTH = 2e-3
"""What the length of a computed attitude or direction errs by, relative: it is written with three
decimals at least. A sensor's noise and scale errors are larger."""

Columns = Mapping[str, FloatArray]
Triple = tuple[str, str, str]


@dataclass(frozen=True)
class TriadGuess:
    """What the numbers of a triad are.

    Parameters
    ----------
    columns : tuple of str
        Their names in the file, x, y, z.
    sheet : tuple of (str, value) pairs
        What a configuration states under ``sensor:``.
    unit : str
        The same in words.
    because : str
        Why.
    si_per_unit : float
        Roughly, SI units per unit of the log.
    doubt : str
        What is not sure of it; empty where nothing is.
    is_open : bool
        Whether its range is only the most usual one.
    """

    columns: Triple
    sheet: tuple[tuple[str, str | float], ...]
    unit: str
    because: str
    si_per_unit: float
    doubt: str = ""
    is_open: bool = False

    def ranged(self, per_deg: float, because: str) -> "TriadGuess":
        """The gyroscope with ``per_deg`` counts per °/s."""
        encoding = str(dict(self.sheet).get("encoding", ""))
        return rate_triad(self.columns, "counts", per_deg, encoding,
                          f"{self.because}; {because}", "")


def triples_by_name(columns: Sequence[str], quantity: str) -> list[Triple]:
    """All x, y, z of one quantity whose names differ in nothing but the axis, the best first."""
    whole = whole_triples([read_name(name) for name in columns], quantity)
    return [(columns[x], columns[y], columns[z])
            for _, (x, y, z) in sorted(whole, key=lambda triple: triple[0])]


def neighbours(columns: Sequence[str]) -> Iterator[Triple]:
    """Every three columns in a row; in the order x, y, z where their names say which is which."""
    for i in range(len(columns) - AXIS_COUNT + 1):
        x, y, z = columns[i : i + AXIS_COUNT]
        axes = [read_name(name).axis for name in (x, y, z)]
        if sorted(-1 if axis is None else axis for axis in axes) == [0, 1, 2]:
            x, y, z = (columns[i + axes.index(axis)] for axis in range(AXIS_COUNT))
        yield x, y, z


def stacked(columns: Columns, triple: Triple) -> FloatArray:
    """The readings of three columns, (t, 3), in their units."""
    return np.column_stack([columns[name] for name in triple])


def guess_accelerometer(
    columns: Columns, hint: str, time_s: FloatArray | None
) -> TriadGuess | None:
    """The accelerometer among ``columns``; ``hint`` is what the file's name says it holds.

    Columns without names are the accelerometer's where they are as long as gravity, and surest
    where the next three turn it: ``time_s`` (t,) shows that, None where no clock is known.
    """
    named = triples_by_name(list(columns), "acc")
    if named:
        guesses = [_accelerometer(columns, triple, "their names", len(named) > 1)
                   for triple in named]
        return next(filter(None, guesses), None)
    if time_s is not None and (miscalled := _called_rates(columns, time_s)):
        return _accelerometer(columns, miscalled, (
            "their readings are as long as gravity, and other columns turn them"), False)
    free = _free(columns)
    units = {triple: unit for triple in neighbours(free) if (unit := _unit(columns, triple))}
    sure = next((triple for triple, unit in units.items() if unit.is_sure), None)
    gyroscope_alone = hint == "gyr" or (
        hint != "acc" and bool(triples_by_name(list(columns), "gyr")))
    if hint == "gyr" or (sure is None and gyroscope_alone):
        return None
    loose = next(iter(units), None) if hint == "acc" or len(free) >= 2 * AXIS_COUNT else None
    turned = None if time_s is None else _turned(columns, free, list(units), time_s)
    triple = turned or sure or loose
    if triple is None:
        return None
    return _accelerometer(columns, triple, "their readings are as long as gravity", False)


def _called_rates(columns: Columns, time_s: FloatArray) -> Triple | None:
    """Columns called like a gyroscope's (``Gx`` for g along x) that other columns turn."""
    for triple in triples_by_name(list(columns), "gyr"):
        unit = _unit(columns, triple)
        if unit and unit.is_sure and unit.unit != "counts" and not read_name(triple[0]).unit:
            force = TriadGuess(triple, (), "", "", 1.0)
            turned = turning_triples(columns, list(columns), force, time_s)
            if max(turned.values(), default=0.0) > SURE_AGREEMENT:
                return triple
    return None


def turning_triples(
    columns: Columns, names: Sequence[str], accelerometer: TriadGuess, time_s: FloatArray
) -> dict[Triple, float]:
    """Every three columns in a row of ``names`` that turn gravity as a gyroscope does.

    With the correlation of their turns and those of the accelerometer.
    """
    return {triple: seen[1] for triple in neighbours(names)
            if not {*triple} & {*accelerometer.columns}
            and (seen := turns_beside(columns, accelerometer, triple, time_s)) is not None}


def _turned(
    columns: Columns, free: list[str], triples: list[Triple], time_s: FloatArray
) -> Triple | None:
    """The triple that the three columns behind it turn as a gyroscope would."""
    agreement: dict[Triple, float] = {}
    for triple in triples:
        at = free.index(triple[0]) + AXIS_COUNT
        if len(behind := free[at : at + AXIS_COUNT]) == AXIS_COUNT and _are_alike(
                stacked(columns, (behind[0], behind[1], behind[2]))):
            guess = TriadGuess(triple, (), "", "", 1.0)
            turns = turns_beside(columns, guess, (behind[0], behind[1], behind[2]), time_s)
            if turns is not None:
                agreement[triple] = turns[1]
    return max(agreement, key=lambda triple: agreement[triple], default=None)


def _free(columns: Columns) -> list[str]:
    """Columns whose names and numbers say nothing against being the accelerometer."""
    computed = {name for four in _quaternions(columns) for name in four}
    return [name for name in columns if read_name(name).quantity == "" and name not in computed]


def _quaternions(columns: Columns) -> Iterator[tuple[str, ...]]:
    """Every four columns in a row whose length is 1 in all rows: an attitude, no reading."""
    names = list(columns)
    for i in range(len(names) - 3):
        four = tuple(names[i : i + 4])
        length = np.sqrt(sum(columns[name] ** 2 for name in four))
        length = length[np.isfinite(length)]
        moves = any(np.ptp(columns[name]) > UNIT_LENGTH for name in four)
        if length.size and moves and (np.abs(length - 1) < UNIT_LENGTH).all():
            yield four


def _unit(columns: Columns, triple: Triple) -> GravityUnit | None:
    values = stacked(columns, triple)
    values = values[np.isfinite(values).all(axis=1)]
    if not len(values) or not _are_alike(values) or is_direction(values):
        return None
    return gravity_unit(values)


def is_direction(values: FloatArray) -> bool:
    """Whether readings (t, 3) all have the length 1 while they turn: normalised, no readings."""
    length = np.linalg.norm(values, axis=1)
    turns = np.ptp(values, axis=0).max() > 2 * GRAVITY_TOLERANCE
    return bool(turns and (np.abs(length / np.median(length) - 1) < UNIT_LENGTH).mean() > NEARLY_ALL
                and abs(float(np.median(length)) - 1) < UNIT_LENGTH)


def _are_alike(values: FloatArray) -> bool:
    """Whether three columns may be one sensor: all or none whole numbers, similar scatter."""
    whole = [np.array_equal(axis, np.rint(axis)) for axis in values.T]
    scatter = decoded(values)[0].std(axis=0)
    return len(set(whole)) == 1 and bool(scatter.min() >= LEAST_SCATTER * scatter.max() > 0)


def _accelerometer(
    columns: Columns, triple: Triple, because: str, several: bool
) -> TriadGuess | None:
    unit, words = _unit(columns, triple), read_name(triple[0])
    if words.gravity_free and (unit is None or not unit.is_sure):
        return None
    doubts = ["other columns may be an accelerometer's too"] if several else []
    stated = _stated_unit(words.unit, columns, triple)
    if unit is None and stated is None:  # as long as gravity in no unit
        return None
    unit = stated or unit
    assert unit is not None
    if stated is None and words.unit in FORCE_UNITS and words.unit != unit.unit:
        doubts.append(f"their names say {words.unit}, in which the median reading would be "
                      f"{unit.length * FORCE_UNITS[words.unit]:.4g} m/s²; they are taken "
                      f"for {_unit_text(unit)}")
    elif not unit.is_sure:
        doubts.append(f"a typical reading is {unit.length:.4g} long, which is gravity in no known "
                      f"unit; {_unit_text(unit)} is the nearest")
    why = f"{because}; the median reading is {unit.length:.4g} long"
    return TriadGuess(triple, _sheet(unit), _unit_text(unit), why, unit.si_per_unit,
                      "; ".join(doubts))


def _stated_unit(unit: str, columns: Columns, triple: Triple) -> GravityUnit | None:
    """The unit that the names state, where the readings are gravity in it within a factor of two.

    What a scale errs by is for the calibration to find, and no reason to doubt a name.
    """
    if unit not in FORCE_UNITS:
        return None
    values = stacked(columns, triple)
    values = values[np.isfinite(values).all(axis=1)]
    length = typical_length(values) if len(values) else 0.0
    per_g = STANDARD_GRAVITY_M_S2 / FORCE_UNITS[unit]
    near = length > 0 and abs(math.log(length / per_g)) < math.log(LOOSEST)
    return GravityUnit(unit, per_g, "", length, True) if near else None


def _sheet(unit: GravityUnit) -> tuple[tuple[str, str | float], ...]:
    if unit.unit != "counts":
        return (("unit", unit.unit),)
    return _counts("counts_per_g", unit.per_g, unit.encoding)


def _counts(key: str, value: float, encoding: str) -> tuple[tuple[str, str | float], ...]:
    """Counts with their converter; means of counts have none."""
    stated: tuple[tuple[str, str | float], ...] = ((key, value),)
    return (*stated, ("bits", BITS), ("encoding", encoding)) if encoding else stated


def _unit_text(unit: GravityUnit) -> str:
    if unit.unit != "counts":
        return UNIT_WORDS.get(unit.unit, unit.unit)
    return f"counts, {unit.per_g:g} per g" + (f", {unit.encoding}" if unit.encoding else "")


def turns_beside(
    columns: Columns, accelerometer: TriadGuess, gyroscope: Triple, time_s: FloatArray
) -> tuple[float, float] | None:
    """rad/s per unit of the gyroscope by the turns of gravity, and their correlation."""
    force, rate = stacked(columns, accelerometer.columns), stacked(columns, gyroscope)
    finite = np.isfinite(force).all(axis=1) & np.isfinite(rate).all(axis=1)
    if finite.sum() < 2:
        return None
    measured = rate_scale(decoded(rate[finite])[0], decoded(force[finite])[0], time_s[finite])
    return measured if measured is not None and measured[1] >= LEAST_AGREEMENT else None


def rate_triad(
    triple: Triple, unit: str, per_deg: float | None, encoding: str, because: str, doubt: str
) -> TriadGuess:
    """A gyroscope in a unit, or in counts of which ``per_deg`` are 1 °/s."""
    if per_deg is not None:
        return TriadGuess(triple, _counts("counts_per_deg_s", per_deg, encoding),
                          f"counts, {per_deg:g} per °/s" + (f", {encoding}" if encoding else ""),
                          because, math.radians(1) / per_deg, doubt)
    return TriadGuess(triple, (("unit", unit),), UNIT_WORDS[unit], because, RATE_UNITS[unit], doubt)
