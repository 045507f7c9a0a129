"""The values that occur on an axis of a pose, and how often: repeated ones and limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

ONE_LEVEL = 0.74
"""Steps. Derived: normal noise of this sd leaves half of the samples on one level, and their median
deviation shows no less."""

FINEST = 1e-3
"""Median deviations of an axis, below which two levels are one. Derived: equal values come out of
an interpolation 1e-5 of a step apart, and of a hundred samples hardly two meet in so small a one.
"""

NEIGHBOURS, REACH = 3.0, 4
"""Multiple of the frequency of the values of its axis within so many levels. Derived: away from the
middle smooth noise repeats an inner neighbour more; converters with uneven steps skip up to three
codes of four."""

LEAST_REPEATS = 12
"""Samples. Derived: where one is expected, so many occur by chance once in 10¹⁰ poses."""

AWAY = 2.0
"""Sds of the noise by which a value of one axis is outside of the middle, and steps of noise from
which on neighbouring values are about as frequent. Derived: in a log of few levels the middle one
repeats more than its neighbours, the second from it does not."""

LARGEST_GAP = 0.5
"""Share of the quartiles' distance, between the nearer half of the samples beside a limit. Derived:
of 24 samples of normal noise one set in sixty has a larger gap; what lies apart is no noise."""

BETWEEN, EQUAL = 1.5, 0.1
"""Least ratio of the step between levels that repeat to the finest one, and error of the ratio of
two such steps. Derived: one level between two of them halves the step, and noise passes over one at
most; the biases by which failed readings lie off two axes are so alike in one of five pairs."""

TOGETHER = 0.5
"""Least share of the samples at a repeated level of one of two axes that are at one of the other's
too, if a reading failed. Derived: levels that hold two of three samples share half by chance, and
failed readings are at one in all axes."""


@dataclass(frozen=True, eq=False)
class Levels:
    """The values that occur on one axis, relative to its median, in sds of its noise.

    Attributes
    ----------
    value : array, shape (l,)
        The levels, ascending.
    place : array of int, shape (t,)
        The level of each sample.
    noise : float
        The noise, in the unit of the readings.
    step : float
        The distance that most samples have to the next level: what noise moves them by.
    """

    value: FloatArray
    place: IntArray
    noise: float
    step: float

    @classmethod
    def of(cls, values: FloatArray) -> "Levels":
        """The levels of the readings (t,) of one axis, in any unit."""
        half = (len(values) - 1) // 2
        middle = float(np.partition(values, half)[half])
        deviation = float(np.median(np.abs(values - middle)))
        finest = FINEST * deviation
        cell = np.rint((values - middle) / finest) if finest > 0 else values
        _, first, place = np.unique(cell, return_index=True, return_inverse=True)
        level = values[first]
        gap = np.concatenate([[np.inf], np.diff(level), [np.inf]])
        step = float(np.median(np.minimum(gap[:-1], gap[1:])[place]))
        # ``middle`` was read: half-way between two levels the deviation of most is half a step.
        noise = max(deviation, _beside_a_limit(level, place)) / MEDIAN_OF_NORMAL
        noise = max(noise, ONE_LEVEL * step)
        return cls((level - middle) / noise, place, noise, step / noise)

    @property
    def distance(self) -> FloatArray:
        """Distance of each sample from the median, (t,), in sds of the noise."""
        return np.asarray(np.abs(self.value)[self.place])

    def repeated(self, counted: BoolArray) -> BoolArray:
        """Levels away from the middle that occur more often than their neighbours explain, (l,).

        Levels where the axis is cut off are excluded: their samples are limits of the measurement.

        Parameters
        ----------
        counted : array of bool, shape (t,)
            The samples that count.
        """
        often = self._often(counted)
        return often & ~self.limits if often.any() else often

    @property
    def limits(self) -> BoolArray:
        """Levels where the axis is cut off: nothing lies beyond, and they hold what would, (l,)."""
        from scipy.special import ndtr  # measuring a clip loads this package and needs no SciPy

        often = self._often(np.ones(len(self.place), dtype=bool))
        often[1:-1] = False
        if not often.any():
            return often
        times = np.bincount(self.place, minlength=len(self.value))
        beyond = len(self.place) * ndtr(-np.abs(self.value))
        return np.asarray(often & (times < LEAST_REPEATS + NEIGHBOURS * beyond))

    def _often(self, counted: BoolArray) -> BoolArray:
        away = (np.abs(self.value) > AWAY) | (AWAY * self.step < 1)
        return away & self.more_than_beside(counted)

    def more_than_beside(self, counted: BoolArray) -> BoolArray:
        """Levels that occur more often than their neighbours explain, in the middle too, (l,)."""
        times = np.bincount(self.place[counted], minlength=len(self.value))
        if times.max() <= LEAST_REPEATS:
            return np.zeros(len(times), dtype=bool)
        nothing = np.zeros(REACH, dtype=times.dtype)
        around = np.concatenate([nothing, times, nothing])
        beside = np.maximum.reduce([around[first : first + len(times)]
                                    for first in range(2 * REACH + 1) if first != REACH])
        return np.asarray(times > LEAST_REPEATS + NEIGHBOURS * beside)


def _beside_a_limit(level: FloatArray, place: IntArray) -> float:
    """Median distance of the other samples from an end where most are; 0 where it is no limit.

    Noise that is cut off in its middle goes on without a gap where it is not cut off.
    """
    most = int(np.bincount(place).argmax())
    if most not in (0, len(level) - 1):
        return 0.0
    beside = np.sort(np.abs(level[place[place != most]] - level[most]))
    if len(beside) < LEAST_REPEATS:
        return 0.0
    first, middle, third = np.quantile(beside, [0.25, 0.5, 0.75])
    gap = np.diff(beside[beside <= middle], prepend=0.0).max()
    return float(middle) if gap <= LARGEST_GAP * (third - first) else 0.0


def cut_off(values: FloatArray) -> BoolArray:
    """Samples of one axis, (t,), at a value where noise accumulates because it is a limit.

    None where the noise is less than two steps of the converter.
    """
    low, high = values.min(), values.max()
    if low == high or max(np.sum(values == low), np.sum(values == high)) <= LEAST_REPEATS:
        return np.zeros(len(values), dtype=bool)
    axis = Levels.of(values)
    return np.asarray(axis.limits[axis.place])


def are_resampled(axes: Sequence[Levels]) -> bool:
    """Whether the levels that repeat are a coarse reading's that was interpolated at other times.

    They stand in equal steps with others between, or lie in the noise and repeat on each axis in
    other samples. Failed readings lie off each axis by its own bias, in the same samples.
    """
    every = [np.ones(len(axis.place), dtype=bool) for axis in axes]
    often = [axis.more_than_beside(one) for axis, one in zip(axes, every, strict=True)]
    if all((np.abs(axis.value[one]) < AWAY).all() for axis, one in zip(axes, often, strict=True)):
        there = [one[axis.place] for axis, one in zip(axes, often, strict=True) if one.any()]
        if any((one & other).sum() < TOGETHER * (one | other).sum()
               for one, other in combinations(there, 2)):
            return True
    steps = np.concatenate([axis.noise * np.diff(axis.value[one])
                            for axis, one in zip(axes, often, strict=True)])
    finest = max(axis.noise * axis.step for axis in axes)
    if len(steps) < 2 or steps.min() < BETWEEN * finest:
        return False
    whole = steps / steps.min()
    return bool(whole.max() < 1 + BETWEEN and (np.abs(whole - np.rint(whole)) < EQUAL).all())
