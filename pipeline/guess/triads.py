"""Which columns of a table are the accelerometer's and the gyroscope's.

Of every three columns as the accelerometer and three as the gyroscope, or none as either, the pair
is taken for which most speaks: that the one turns the gravity of the other, then what columns and
files are called, then that the readings at rest are as long as gravity is.
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
    GRAVITY_TOLERANCE,
    LOOSEST,
    GravityUnit,
    encoding_of,
    gravity_unit,
    sample_noise_sd,
    signed,
    typical_length,
)
from pipeline.guess.pool import STILL, PooledTables, still_means
from pipeline.guess.turns import OWN, Turn, is_along_gravity, turn_of
from pipeline.logs.header_words import ACC, GYR, OTHER, Words, read_name, whole_triples

AXIS_COUNT = 3  #: fact: of a triad
LEAST_SCATTER = 0.03
"""Axes of one sensor scatter alike, by noise or by attitude; a magnetometer's beside it do not."""

NEARLY_ALL = 0.99  #: share of rows; a few may be written while the sensor starts
UNIT_LENGTH = 2e-3
"""What the length of a computed attitude or direction errs by, relative: it is written with three
decimals at least. A sensor's noise and scale errors are larger."""

MOST_LOOKED_AT = 8  #: accelerometers whose gyroscopes are looked at

Triple = tuple[str, str, str]


def triples_by_name(columns: Sequence[str], quantity: str) -> list[Triple]:
    """All x, y, z of one quantity whose names differ in nothing but the axis, the best first."""
    whole = whole_triples([read_name(name) for name in columns], quantity)
    return [(columns[x], columns[y], columns[z])
            for _, (x, y, z) in sorted(whole, key=lambda triple: triple[0])]


def possible_triples(columns: Sequence[str]) -> list[Triple]:
    """Every three columns that may be x, y, z of one sensor: by their names, or in a row."""
    words = {name: read_name(name) for name in columns}
    free = [name for name, word in words.items() if word.quantity in ("", "acc", "gyr")]
    by_name = [triple for quantity in ("acc", "gyr", "")
               for triple in triples_by_name(free, quantity)]
    in_turn = [name for name in free if words[name].axis is None]  # x of two sensors, y of both
    return list(dict.fromkeys([*by_name, *_in_a_row(free, words),
                               *_in_a_row(in_turn[::2], words), *_in_a_row(in_turn[1::2], words)]))


def _in_a_row(names: Sequence[str], words: dict[str, Words]) -> Iterator[Triple]:
    """Three columns in a row whose names say of none or of all of them which axis it is."""
    for i in range(len(names) - AXIS_COUNT + 1):
        x, y, z = names[i : i + AXIS_COUNT]
        axes = [words[name].axis for name in (x, y, z)]
        if len({called(words[name]) for name in (x, y, z)} - {""}) > 1:
            continue
        if sorted(-1 if axis is None else axis for axis in axes) == [0, 1, 2]:
            x, y, z = (names[i + axes.index(axis)] for axis in range(AXIS_COUNT))
        yield x, y, z


def called(words: Words) -> str:
    """``acc`` or ``gyr`` where a name says which sensor it is of, whether with an axis or not."""
    stem = words.stem.rstrip("0123456789")
    return words.quantity or ("acc" if stem in ACC else "gyr" if stem in GYR else "")


@dataclass(frozen=True, eq=False)
class PossibleTriad:
    """Three columns of a pool, and what they may be."""

    pool: PooledTables
    columns: Triple

    @cached_property
    def words(self) -> Words:
        """What the name of the first column says."""
        return read_name(self.columns[0])

    @cached_property
    def _whole(self) -> tuple[FloatArray, IntArray, str]:
        values, table = self.pool.readings(self.columns)
        encoding = encoding_of(values)
        return signed(values, encoding), table, encoding

    @property
    def values(self) -> FloatArray:
        """Signed readings (t, 3) in their unit, without rows that lack one."""
        return self._whole[0]

    @property
    def encoding(self) -> str:
        """How they are written as whole numbers; empty for numbers that are no counts."""
        return self._whole[2]

    @cached_property
    def is_sensor(self) -> bool:
        """Whether the three may be one sensor: all or none whole numbers, of similar scatter."""
        if not len(self.values):
            return False
        whole = [np.array_equal(axis, np.rint(axis)) for axis in self.values.T]
        scatter = self.values.std(axis=0)
        return len(set(whole)) == 1 and bool(scatter.min() >= LEAST_SCATTER * scatter.max() > 0)

    @cached_property
    def gravity(self) -> GravityUnit | None:
        """The unit in which they are gravity; None where they are not.

        A unit that the names state is believed where it makes them gravity within a factor of two:
        what a scale errs by is for the calibration to find.
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
        """Whether they read alike in every attitude, as a gyroscope at rest does."""
        means = still_means(self.values, self._whole[1], self.pool.step_s)
        return bool(means.std(axis=0).max() < STILL * sample_noise_sd(self.values))

    def turns(self, force: "PossibleTriad") -> Turn | None:
        """How they turn ``force``; None where it does not turn, or they are no sensor."""
        return turn_of(*self._beside(force), self.pool.step_s) if self.is_sensor else None

    def is_along(self, force: "PossibleTriad") -> bool:
        """Whether they read along ``force`` on a turning plate."""
        return self.is_sensor and is_along_gravity(*self._beside(force))

    def _beside(self, force: "PossibleTriad") -> tuple[FloatArray, FloatArray, IntArray]:
        """The signed readings (t, 3) of both in rows that hold them all, and their tables (t,)."""
        both, table = self.pool.readings([*self.columns, *force.columns])
        return (signed(both[:, :AXIS_COUNT], self.encoding),
                signed(both[:, AXIS_COUNT:], force.encoding), table)


def is_direction(values: FloatArray) -> bool:
    """Whether readings (t, 3) all have the length 1 while they turn: normalised, no readings."""
    length = np.linalg.norm(values, axis=1)
    turns = np.ptp(values, axis=0).max() > 2 * GRAVITY_TOLERANCE
    return bool(turns and (np.abs(length / np.median(length) - 1) < UNIT_LENGTH).mean() > NEARLY_ALL
                and abs(float(np.median(length)) - 1) < UNIT_LENGTH)


def _attitudes(pool: PooledTables) -> set[str]:
    """Columns of every four in a row whose length is 1 in all rows: a computed attitude."""
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


def chosen_triads(pool: PooledTables) -> tuple[PossibleTriad | None, PossibleTriad | None]:
    """The accelerometer and the gyroscope for which most speaks."""
    computed = _attitudes(pool)
    every = [PossibleTriad(pool, triple) for triple in possible_triples(list(pool.columns))
             if not {*triple} & computed]
    forces = sorted((force for force in every if _may_be_accelerometer(force)),
                    key=lambda force: (_called_as(force, "acc"), _is_gravity(force)),
                    reverse=True)[:MOST_LOOKED_AT]
    pairs: list[tuple[_Evidence, PossibleTriad | None, PossibleTriad | None]] = []
    for force in forces:
        name = _called_as(force, "acc")
        if name > 0 or (name == 0 and (_is_gravity(force) or len(every) == 1)):
            pairs.append(((0, name, _is_gravity(force), 1, 0), force, None))
    for rate in every:
        name = _called_as(rate, "gyr")
        if name > 0 and _may_be_gyroscope(rate):
            pairs.append(((0, name, False, 1, 0), None, rate))
        pairs += [(evidence, force, rate) for force in forces
                  if (evidence := _evidence(force, rate)) is not None]
    _, accelerometer, gyroscope = max(pairs, key=lambda pair: pair[0],
                                      default=(None, None, None))
    return accelerometer, gyroscope


_Evidence = tuple[int, int, bool, int, int]
"""What speaks for a pair, the strongest first: that one turns the gravity of the other about the
same axes or reads along it on a plate, or turns it about others; names; that gravity is as long as
in a known unit; number of sensors; that the one reads alike in all rests, else that they stand
beside each other."""


def _evidence(force: PossibleTriad, rate: PossibleTriad) -> _Evidence | None:
    """What speaks for two triads together; None where they cannot be these sensors."""
    if {*rate.columns} & {*force.columns} or called(rate.words) == "acc":
        return None
    name, force_name = _called_as(rate, "gyr"), _called_as(force, "acc")
    if not _may_be_gyroscope(rate):
        return None
    turn = rate.turns(force)
    sure = turn is not None and turn.is_sure
    turned = 2 if rate.is_along(force) or (turn and sure and turn.axes == OWN) else int(sure)
    names = list(rate.pool.columns)
    away = min(map(names.index, rate.columns)) - min(map(names.index, force.columns))
    beside = {AXIS_COUNT: 2, -AXIS_COUNT: 1}.get(away, 0)  # behind it more often than before
    plain = force_name > 0 or (force_name == 0 and _is_gravity(force))
    alike = turn is None and rate.is_alike
    believed = name > 0 or (name == 0 and turn is None and (alike or beside > 0))
    if not turned and not (plain and believed):
        return None
    return turned, name + force_name, _is_gravity(force), 2, AXIS_COUNT if alike else beside


def _is_gravity(force: PossibleTriad) -> bool:
    return force.gravity is not None and force.gravity.is_sure


def _called_as(triad: PossibleTriad, sensor: str) -> int:
    """2 where names say that columns are of a sensor, 1 where that of the file does, -1 where they
    say something else, else 0.

    A word that is not understood says something else of a gyroscope only: what has the length of
    gravity in every attitude is an accelerometer whatever it is called.
    """
    words, hint = triad.words, triad.pool.hint
    if words.stem == "g" and triad.gravity and triad.gravity.is_sure and triad.gravity.unit == "g":
        return 2 * (sensor == "acc")  # the unit and not the first letter of a gyroscope
    if name := called(words):
        return 2 if name == sensor else -1
    if hint and not OTHER & {words.stem}:
        return 1 if hint == sensor else -1
    unknown = words.stem and not words.stem.isdecimal()
    return -1 if OTHER & {words.stem} or (sensor == "gyr" and unknown) else 0


def _may_be_gyroscope(rate: PossibleTriad) -> bool:
    """Whether columns are a sensor's, or are called a gyroscope and read anything at all."""
    return rate.is_sensor or (rate.words.quantity == "gyr" and bool(rate.values.any()))


def _may_be_accelerometer(force: PossibleTriad) -> bool:
    """Whether columns are gravity in some unit and nothing says that they are something else."""
    words, unit = force.words, force.gravity
    if unit is None or (words.gravity_free and not unit.is_sure):
        return False
    name = _called_as(force, "acc")
    if force.pool.hint == "gyr" and name < 2:
        return False
    return name > 0 or words.quantity != "gyr" or not (
        words.unit or unit.unit == "counts")
