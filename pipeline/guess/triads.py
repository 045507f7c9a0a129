"""Which columns of a table are the accelerometer's and the gyroscope's.

A hypothesis is three columns as the accelerometer and three as the gyroscope, or none as either.
Physics weighs it: at rest an accelerometer reads one length in every attitude, and a gyroscope
turns the direction of gravity. What columns and files are called is the prior. The weights add up
as the logarithms of odds do, and the heaviest hypothesis is the guess.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import AXES, FloatArray, IntArray
from pipeline.guess.magnitudes import (
    FORCE_UNITS,
    GRAVITY_TOLERANCE,
    LEAST_AGREEMENT,
    LOOSEST,
    GravityUnit,
    encoding_of,
    gravity_unit,
    rate_scale,
    signed,
    typical_length,
)
from pipeline.guess.pool import PooledTables
from pipeline.logs.header_words import ACC, GYR, OTHER, Words, read_name, whole_triples

AXIS_COUNT = 3  #: fact: of a triad
LEAST_SCATTER = 0.03
"""Axes of one sensor scatter alike, by noise or by attitude; a magnetometer's beside it do not."""

SURE_AGREEMENT = 0.8
"""Correlation of turns by three columns and by gravity that makes them a gyroscope whatever they
are called. A judgement: those of sound logs in ``tests`` are 0.9 or more."""
NEARLY_ALL = 0.99  #: share of rows; a few may be written while the sensor starts
UNIT_LENGTH = 2e-3
"""What the length of a computed attitude or direction errs by, relative: it is written with three
decimals at least. A sensor's noise and scale errors are larger."""

CALLED = 4.0
"""Weight of a name that says which sensor it is, of a column or of a file. This and the weights
below are judgements: gravity and its turns together outweigh a name, neither does alone."""
OF_GRAVITY, NEARLY_GRAVITY = 3.0, -1.0
"""Weight of readings of one length that is gravity in a known unit, and of those that come near."""
TURNING = 8.0
"""Weight of columns that turn gravity as a gyroscope does, times the correlation."""
NOT_TURNING = -3.0  #: weight of columns that do not while gravity turns, whatever their axes are
BEHIND, BEFORE = 1.5, 1.0  #: weight of a gyroscope that stands beside the accelerometer
ALONE = 1.5  #: weight of an accelerometer in the only three columns that there are
UNKNOWN_WORD = -3.0  #: weight of a gyroscope in columns of which a word is not understood
MOST_WEIGHED = 4  #: accelerometers whose gyroscopes are looked at; the others weigh less by far

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
        return unit if self.is_sensor else None

    def turns(
        self, force: "PossibleTriad", about: FloatArray | None = None
    ) -> tuple[float, float] | None:
        """rad/s per unit in which they turn ``force``, and the correlation; None without turns.

        ``about`` (3, 3) are other axes than their own, no unit.
        """
        both, table = self.pool.readings([*self.columns, *force.columns])
        rate = signed(both[:, :AXIS_COUNT], self.encoding)
        gravity = signed(both[:, AXIS_COUNT:], force.encoding)
        return rate_scale(rate if about is None else rate @ about.T, gravity, table,
                          self.pool.step_s)

    def turns_about(self, force: "PossibleTriad") -> tuple[str, float]:
        """The axes of ``force`` about which they turn it best, of either hand, and the
        correlation."""
        every = {}
        rotations = Rotation.create_group("O").as_matrix().round()
        for axes in (*rotations, *-rotations):
            seen = self.turns(force, axes)
            every[", ".join(f"{'-' if row.sum() < 0 else '+'}{AXES[int(np.abs(row).argmax())]}"
                            for row in axes.T)] = seen[1] if seen else 0.0
        return max(every.items(), key=lambda item: item[1])


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


def weighed_triads(pool: PooledTables) -> tuple[PossibleTriad | None, PossibleTriad | None]:
    """The accelerometer and the gyroscope of the heaviest hypothesis."""
    computed = _attitudes(pool)
    every = [PossibleTriad(pool, triple) for triple in possible_triples(list(pool.columns))
             if not {*triple} & computed]
    forces = sorted(((weight, force) for force in every
                     if (weight := _as_accelerometer(force, len(every))) is not None),
                    key=lambda item: -item[0])[:MOST_WEIGHED]
    hypotheses: list[tuple[float, PossibleTriad | None, PossibleTriad | None]] = [(0.0, None, None)]
    for weight, force in [*forces, (0.0, None)]:
        rates = [(_as_gyroscope(rate, force), rate) for rate in every
                 if force is None or not {*rate.columns} & {*force.columns}]
        most, best = max(rates, key=lambda item: item[0], default=(0.0, None))
        hypotheses.append((weight + most, force, best) if most > 0 else (weight, force, None))
    _, accelerometer, gyroscope = max(hypotheses, key=lambda hypothesis: hypothesis[0])
    return accelerometer, gyroscope


def _as_accelerometer(force: PossibleTriad, every: int) -> float | None:
    """The weight of columns as the accelerometer; None where they cannot be it."""
    words, hint, unit = force.words, force.pool.hint, force.gravity
    if unit is None or hint == "gyr" or (words.gravity_free and not unit.is_sure):
        return None
    if words.quantity == "gyr" and (words.unit or unit.unit == "counts"):
        return None
    weight = {"acc": CALLED, "gyr": -CALLED}.get(called(words), 0.0)
    if weight == 0 and OTHER & {words.stem}:
        weight = -CALLED
    elif weight == 0 and hint == "acc":
        weight = CALLED
    alone = ALONE if every == 1 and weight == 0 else 0.0
    return weight + alone + (OF_GRAVITY if unit.is_sure else NEARLY_GRAVITY)


def _as_gyroscope(rate: PossibleTriad, force: PossibleTriad | None) -> float:
    """The weight of columns as the gyroscope beside an accelerometer, or without any."""
    words, hint = rate.words, rate.pool.hint
    weight = {"acc": -np.inf, "gyr": CALLED}.get(called(words), 0.0)
    if weight == 0 and hint == "gyr":
        weight = CALLED
    elif weight == 0 and words.stem and not words.stem.isdecimal():
        weight = UNKNOWN_WORD
    if not rate.is_sensor and words.quantity != "gyr":
        return -np.inf
    if force is None:
        return weight
    names = list(rate.pool.columns)
    away = min(map(names.index, rate.columns)) - min(map(names.index, force.columns))
    weight += {AXIS_COUNT: BEHIND, -AXIS_COUNT: BEFORE}.get(away, 0.0)
    seen = rate.turns(force) if rate.is_sensor else None
    if seen is None:
        return weight
    if seen[1] >= LEAST_AGREEMENT:
        return weight + TURNING * seen[1]
    if words.quantity == "gyr" or rate.turns_about(force)[1] > SURE_AGREEMENT:
        return weight
    return weight + NOT_TURNING
