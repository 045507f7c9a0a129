"""Selection of the columns of the accelerometer and of the gyroscope in a table.

Candidates are pairs of three columns as accelerometer and three as gyroscope; one of the two may be
absent. The pair with the strongest evidence is chosen: first that the gyroscope predicts the turns
of gravity, then the names of columns and files, then that readings at rest have gravity's length.
A magnetic field has one length in every attitude too, and turns as the gyroscope says: only names
or gravity's length in a known unit exclude it, and without them the choice stays open.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import FloatArray, IntArray
from pipeline.guess.magnitudes import (
    FORCE_UNITS,
    LOOSEST,
    UNIT_LENGTH,
    GravityUnit,
    encoding_of,
    gravity_unit,
    is_direction,
    sample_noise_sd,
    signed,
    typical_length,
)
from pipeline.guess.pool import FEWEST_MEANS, MEANS_APART, STILL, PooledTables, still_means
from pipeline.guess.turns import OWN, Turn, is_along_gravity, turn_of
from pipeline.logs.header_words import ACC, GYR, Words, read_name, whole_triples

AXIS_COUNT = 3  #: fact: number of axes of a triad
LEAST_SCATTER = 0.03
"""Least ratio of the scatters of two axes of one sensor, by noise or attitude; with an axis of a
magnetometer it is smaller."""

MOST_LOOKED_AT = 8  #: number of candidate accelerometers that are paired with gyroscopes

Triple = tuple[str, str, str]


def triples_by_name(columns: Sequence[str], quantity: str) -> list[Triple]:
    """All x, y, z of one quantity whose names differ only in the axis, the best first."""
    whole = whole_triples([read_name(name) for name in columns], quantity)
    return [(columns[x], columns[y], columns[z])
            for _, (x, y, z) in sorted(whole, key=lambda triple: triple[0])]


def possible_triples(columns: Sequence[str]) -> list[Triple]:
    """All triples of columns that may be x, y, z of one sensor, by name or by position."""
    words = {name: read_name(name) for name in columns}
    free = [name for name, word in words.items() if word.quantity in ("", "acc", "gyr")]
    by_name = [triple for quantity in ("acc", "gyr", "")
               for triple in triples_by_name(free, quantity)]
    unnamed = [name for name in free if words[name].axis is None]  # or x, x, y, y, z, z of two
    rows = (triple for names in (free, unnamed[::2], unnamed[1::2])
            for triple in _in_a_row(names, words))
    sensor = {name: triple for triple in by_name for name in triple}
    return list(dict.fromkeys([*by_name, *(
        triple for triple in rows if len({*map(sensor.get, triple)}) == 1)]))


def _in_a_row(names: Sequence[str], words: dict[str, Words]) -> Iterator[Triple]:
    """Triples of adjacent columns, in the order of x, y, z if their names state all three axes."""
    for i in range(len(names) - AXIS_COUNT + 1):
        x, y, z = names[i : i + AXIS_COUNT]
        axes = [words[name].axis for name in (x, y, z)]
        if sorted(-1 if axis is None else axis for axis in axes) == [0, 1, 2]:
            x, y, z = (names[i + axes.index(axis)] for axis in range(AXIS_COUNT))
        yield x, y, z


def called(words: Words) -> str:
    """``acc`` or ``gyr`` if a name states its sensor, with or without an axis; else empty."""
    stem = words.stem.rstrip("0123456789")
    return words.quantity or ("acc" if stem in ACC else "gyr" if stem in GYR else "")


@dataclass(frozen=True, eq=False)
class PossibleTriad:
    """Three columns of a pool as the candidate of a triad."""

    pool: PooledTables
    columns: Triple

    @cached_property
    def words(self) -> Words:
        """The meaning of the first column's name."""
        return read_name(self.columns[0])

    @cached_property
    def _whole(self) -> tuple[FloatArray, IntArray, str]:
        values, table = self.pool.readings(self.columns)
        encoding = encoding_of(values)
        return signed(values, encoding), table, encoding

    @property
    def values(self) -> FloatArray:
        """Signed readings (t, 3) in their unit, complete rows only."""
        return self._whole[0]

    @property
    def encoding(self) -> str:
        """The encoding of counts; empty for numbers that are not counts."""
        return self._whole[2]

    @cached_property
    def is_sensor(self) -> bool:
        """Whether the three may be one sensor: all or no whole numbers, and similar scatter."""
        if not len(self.values):
            return False
        whole = [np.array_equal(axis, np.rint(axis)) for axis in self.values.T]
        scatter = self.values.std(axis=0)
        return len(set(whole)) == 1 and bool(scatter.min() >= LEAST_SCATTER * scatter.max() > 0)

    @cached_property
    def gravity(self) -> GravityUnit | None:
        """The unit in which they are gravity; None if they are not.

        A unit stated by the names is accepted if it gives gravity within a factor of
        :data:`LOOSEST`; the calibration determines the scale error.
        """
        if not len(self.values) or is_direction(self.values):
            return None
        unit = gravity_unit(self.values, self._whole[1], self.pool.step_s, self.encoding)
        stated = self.words.unit if self.words.unit in FORCE_UNITS else ""
        length = unit.length if unit else typical_length(self.values)
        if stated and length > 0:
            per_g = STANDARD_GRAVITY_M_S2 / FORCE_UNITS[stated]
            if abs(math.log(length / per_g)) < math.log(LOOSEST):
                return GravityUnit(stated, per_g, "", length, True)
            unit = unit if unit and unit.is_sure else None
        return unit if self.is_sensor else None

    @cached_property
    def is_alike(self) -> bool:
        """Whether their mean is the same in every attitude, as of a gyroscope at rest."""
        means = still_means(self.values, self._whole[1], self.pool.step_s)
        return bool(means.std(axis=0).max() < STILL * sample_noise_sd(self.values))

    def turns(self, force: "PossibleTriad") -> Turn | None:
        """Turns of ``force`` by them; None if it does not turn, or they are not a sensor."""
        steps = self.pool.steps(self.columns + force.columns)
        return turn_of(*self._beside(force), steps) if self.is_sensor else None

    def is_along(self, force: "PossibleTriad") -> bool:
        """Whether they are parallel to ``force`` on a turning plate."""
        return self.is_sensor and is_along_gravity(*self._beside(force), self.pool.step_s)

    def is_parallel(self, other: "PossibleTriad") -> bool:
        """Whether both are one vector: a second reading of the same sensor, or its mean."""
        one, two, _ = self._beside(other)
        length = np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)
        along = np.abs((one * two).sum(axis=1)) / np.maximum(length, np.finfo(float).tiny)
        return bool(np.median(along) > math.cos(MEANS_APART))

    def _beside(self, force: "PossibleTriad") -> tuple[FloatArray, FloatArray, IntArray]:
        """Signed readings (t, 3) of both in rows where both are complete, and the tables (t,)."""
        both, table = self.pool.readings([*self.columns, *force.columns])
        one, other = np.hsplit(both, 2)
        return signed(one, self.encoding), signed(other, force.encoding), table


def _attitudes(pool: PooledTables) -> set[str]:
    """Columns of computed attitudes: four adjacent columns whose length is 1 in all rows."""
    names = list(pool.columns)
    computed: set[str] = set()
    for i in range(len(names) - AXIS_COUNT):
        four = names[i : i + AXIS_COUNT + 1]
        values, _ = pool.readings(four)
        length = np.linalg.norm(values, axis=1)
        moves = len(values) and np.ptp(values) > UNIT_LENGTH
        if moves and (np.abs(length - 1) < UNIT_LENGTH).all():
            computed |= {*four}
    return computed


@dataclass(frozen=True, eq=False)
class ChosenTriads:
    """The accelerometer and the gyroscope with the strongest evidence, None for an absent one.

    ``rival`` is another triad that may be the accelerometer, and this a magnetometer: nothing but
    the unit in which it may be gravity speaks for either.
    """

    force: PossibleTriad | None
    rate: PossibleTriad | None
    rival: PossibleTriad | None


def chosen_triads(pool: PooledTables) -> ChosenTriads:
    """The triads of a pool by their evidence."""
    computed = _attitudes(pool)
    every = [PossibleTriad(pool, triple) for triple in possible_triples(list(pool.columns))
             if not {*triple} & computed]
    forces = sorted((force for force in every if _may_be_accelerometer(force)),
                    key=lambda force: (_called_as(force, "acc"), _is_gravity(force)),
                    reverse=True)[:MOST_LOOKED_AT]
    pairs: list[tuple[_Evidence, PossibleTriad | None, PossibleTriad | None]] = []
    for force in forces:
        name = _called_as(force, "acc")
        if name > 0 or (name == 0 and _is_gravity(force)):
            pairs.append(((0, name, _is_gravity(force), 1, 0), force, None))
    for rate in every:
        name = _called_as(rate, "gyr")
        if name > 0 and _may_be_gyroscope(rate):
            pairs.append(((0, name, 0, 1, 0), None, rate))
        pairs += [(evidence, force, rate) for force in forces
                  if (evidence := _evidence(force, rate)) is not None]
    best, accelerometer, gyroscope = max(pairs, key=lambda pair: pair[0],
                                         default=((0, 0, 0, 0, 0), None, None))
    rival = next((force for evidence, force, rate in pairs if force and accelerometer
                  and rate is gyroscope and evidence[:2] == best[:2]
                  and (best[2] < EXACT or evidence[2] == EXACT)
                  and not {*force.columns} & {*accelerometer.columns}
                  and not called(force.words) == called(accelerometer.words) == "acc"
                  and not force.is_parallel(accelerometer)), None)
    return ChosenTriads(accelerometer, gyroscope, rival)


_Evidence = tuple[int, int, int, int, int]
"""Evidence for a pair, the strongest first: turns of gravity (2 about the same axes or parallel on
a plate, 3 both, 1 about other axes) or rests, in which one has gravity's length and the other reads
the same (1); names; whether gravity's length is nearly (1) or exactly (2) that of a known unit;
number of sensors; equal readings of the gyroscope in all rests, else adjacent columns."""
SURE_TURNS = 2  #: fact: the evidence of turns about the same axes
NAMED = 2  #: fact: the evidence of a name that states the sensor
EXACT = 2  #: fact: the evidence of gravity's length in a known unit


def _evidence(force: PossibleTriad, rate: PossibleTriad) -> _Evidence | None:
    """Evidence for two triads together; None if they cannot be these sensors."""
    if {*rate.columns} & {*force.columns} or not _may_be_gyroscope(rate):
        return None
    name, force_name = _called_as(rate, "gyr"), _called_as(force, "acc")
    turn = rate.turns(force)
    sure = turn is not None and turn.is_sure
    turned = (2 if rate.is_along(force) else int(sure)) + bool(turn and sure and turn.axes == OWN)
    names = list(rate.pool.columns)
    away = min(map(names.index, rate.columns)) - min(map(names.index, force.columns))
    beside = {AXIS_COUNT: 2, -AXIS_COUNT: 1}.get(away, 0)  # more often after it than before
    gravity, alike = _is_gravity(force), turn is None and rate.is_alike
    rests = alike and gravity > 0 and not force.is_alike and beside > 0 and not (
        _is_other(rate) or _is_other(force))
    swapped = rests and called(force.words) == "gyr"
    if called(rate.words) == "acc" and turned < SURE_TURNS and not swapped:
        return None
    plain = force_name > 0 or (force_name == 0 and gravity > 0)
    believed = name > 0 or (name == 0 and turn is None and (alike or beside > 0))
    if not (turned or rests) and not (plain and believed):
        return None
    return max(turned, int(rests)), name + force_name, gravity, 2, AXIS_COUNT if alike else beside


def _is_gravity(force: PossibleTriad) -> int:
    """1 if the length is nearly that of gravity in a known unit, 2 if exactly, else 0."""
    return 0 if force.gravity is None else force.gravity.is_sure + force.gravity.is_exact


def _called_as(triad: PossibleTriad, sensor: str) -> int:
    """``NAMED`` if the columns' names state the sensor, 1 if the file's name does, -1 if they state
    another one, else 0.

    An unknown word counts against a gyroscope only: columns with gravity's length in every attitude
    are an accelerometer, whatever their names.
    """
    words, hint = triad.words, triad.pool.hint
    if words.stem == "g" and triad.gravity and triad.gravity.is_sure and triad.gravity.unit == "g":
        return NAMED * (sensor == "acc")  # the unit and not the first letter of a gyroscope
    if name := called(words):
        return NAMED if name == sensor else -1
    if _is_other(triad):
        return -1
    if hint:
        return 1 if hint == sensor else -1
    return -1 if sensor == "gyr" and words.stem and not words.stem.isdecimal() else 0


def _is_other(triad: PossibleTriad) -> bool:
    """Whether a name states another quantity than an inertial one."""
    return any(read_name(column).is_other for column in triad.columns)


def _may_be_gyroscope(rate: PossibleTriad) -> bool:
    """Whether columns may be a sensor, or are named as a gyroscope and are not all 0."""
    return rate.is_sensor or (rate.words.quantity == "gyr" and bool(rate.values.any()))


def _may_be_accelerometer(force: PossibleTriad) -> bool:
    """Whether columns are gravity in some unit and no name states another quantity."""
    words, unit = force.words, force.gravity
    name, poses = _called_as(force, "acc"), force.pool.table[-1] + 1
    if unit is None or _is_other(force) or (words.gravity_free and not unit.is_sure) or (
            name == 0 and (unit.may_be_ut or (poses >= FEWEST_MEANS and force.is_alike))) or (
            force.pool.hint == "gyr" and name < NAMED):
        return False
    return name > 0 or words.quantity != "gyr" or not (words.unit or unit.unit == "counts")
