"""Samples of a pose that are not measurements: left in the log by a failure of bus or sensor.

A reading that fails gives zeros, −1, an end of the converter, or whatever the register last held.
Such samples pull the mean, and since they also widen the scatter that a pose is judged by, more of
them would be judged less. So they are judged by what half of the samples cannot move: the median
and the median deviation of the pose. A sample is stray where

far
    it is further from the median than FAR noise sds, more where few samples show these, on any
    axis, and stands alone: what lies together in time is a motion, and the checks of the pose speak
    of it;
again
    its very tuple, or one value of an axis away from the middle, occurs more often than smooth
    noise repeats it, and scattered over the pose: slow noise repeats itself in stretches.

Stray samples that move the mean by more than its noise sd are left out and counted; where they are
too many, the pose is refused.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from calib.errors import Undetermined
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import TRIADS, BoolArray, FloatArray, ImuLog, IntArray, Triad

FAR = 6.0
"""Sds of the noise. Derived: normal noise goes so far once in 5·10⁸ samples; a wave goes up to 1.0
of the scale that its median deviation shows, a random walk up to about 4."""

OF_FEW = 3.5
"""Over the root of the number of samples, what is added to one times ``FAR``. Derived: three sds of
a median deviation, which shows the noise of 14 samples as half of it once in a thousand times."""

ONE_LEVEL = 0.74
"""Steps. Derived: normal noise of this sd leaves half of the samples on one level, and their median
deviation shows no less."""

OFTEN = 10.0
"""Multiple of the chance rate at which a tuple of three independent axes repeats. Derived: axes
that move together, as noise of the supply makes them, repeat theirs some times as often."""

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

FEW_VALUES = 3
"""Values, or tuples. Fact: a reading that fails gives zeros, ones, or an end of the converter."""

TOO_MANY = 1 / 3
"""Share of a pose's samples. Derived: the median of the others is then off by 0.67 of their sd."""

TUPLES_SHOWN = 3  #: it chooses words only


def without_strays(log: ImuLog) -> tuple[ImuLog, str | None]:
    """A log of one pose without its stray samples.

    Parameters
    ----------
    log : ImuLog
        Counts or physical units, still or turning.

    Returns
    -------
    log : ImuLog
    note : str or None
        A sentence on what is left out; None where nothing is.

    Raises
    ------
    Undetermined
        More than a third of the samples of a triad are stray.
    """
    stray = np.zeros(len(log.time_s), dtype=bool)
    notes = []
    for triad in TRIADS:
        if not log.has(triad):
            continue
        values = np.asarray(log.readings(triad), dtype=float)
        of_triad = stray_samples(values)
        if of_triad.any():
            _require_few(log, triad, values, of_triad)
            notes.append(f"{int(of_triad.sum())} of the {triad}, {_described(values, of_triad)}")
            stray |= of_triad
    if not notes:
        return log, None
    return log.where(~stray), (
        f"{log.label}: {int(stray.sum())} of {len(stray)} samples are no measurement "
        f"({'; '.join(notes)}) and are left out. Check wiring, bus speed and supply: a reading "
        f"that fails is logged so."
    )


def stray_samples(values: FloatArray) -> BoolArray:
    """Stray samples of one triad that move its mean, shape (t,).

    Parameters
    ----------
    values : array, shape (t, 3)
        In any unit.
    """
    axes = [_Levels.of(axis) for axis in values.T if np.ptp(axis) > 0]
    count = max(len(values), 1)
    far = _far(axes, len(values), FAR * (1 + OF_FEW / math.sqrt(count)))
    stray = _again(values, axes)
    if _alone(far) and far.mean() <= TOO_MANY:  # else the noise is of two kinds
        stray |= far
    if not stray.any() or stray.all():
        return np.zeros(len(values), dtype=bool)
    kept = values[~stray]
    shift = np.abs(values.mean(axis=0) - kept.mean(axis=0))
    matters = (shift > kept.std(axis=0) / np.sqrt(len(kept))).any()
    return stray if matters else np.zeros(len(values), dtype=bool)


def far_samples(values: FloatArray) -> BoolArray:
    """Samples (t,) of readings (t, 3) that are ``FAR`` from the median on any axis."""
    return _far([_Levels.of(axis) for axis in values.T if np.ptp(axis) > 0], len(values))


def _far(axes: Sequence["_Levels"], count: int, sds: float = FAR) -> BoolArray:
    return np.asarray(np.any([np.zeros(count, bool), *(a.distance > sds for a in axes)], axis=0))


@dataclass(frozen=True, eq=False)
class _Levels:
    """The values that occur on one axis, relative to its median, in sds of its noise.

    Attributes
    ----------
    value : array, shape (l,)
        The levels, ascending.
    place : array of int, shape (t,)
        The level of each sample.
    step : float
        The distance that most samples have to the next level: what noise moves them by.
    """

    value: FloatArray
    place: IntArray
    step: float

    @classmethod
    def of(cls, values: FloatArray) -> "_Levels":
        level, place = np.unique(values, return_inverse=True)
        gap = np.concatenate([[np.inf], np.diff(level), [np.inf]])
        step = float(np.median(np.minimum(gap[:-1], gap[1:])[place]))
        # One that was read: half-way between two levels the deviation of most is half a step.
        middle = float(np.quantile(values, 0.5, method="lower"))
        noise = max(float(np.median(np.abs(values - middle))), _beside_a_limit(level, place)
                    ) / MEDIAN_OF_NORMAL
        noise = max(noise, ONE_LEVEL * step)
        return cls((level - middle) / noise, place, step / noise)

    @property
    def distance(self) -> FloatArray:
        """Distance of each sample from the median, (t,)."""
        return np.asarray(np.abs(self.value)[self.place])

    def repeated(self, counted: BoolArray) -> BoolArray:
        """Levels away from the middle that occur more often than their neighbours explain, (l,).

        Levels where the axis is cut off are excluded: their samples are limits of the measurement.

        Parameters
        ----------
        counted : array of bool, shape (t,)
            The samples that count.
        """
        return self._often(counted) & ~self.limits

    @property
    def limits(self) -> BoolArray:
        """Levels where the axis is cut off: nothing lies beyond, and they hold what would, (l,)."""
        from scipy.special import ndtr  # measuring a clip loads this package and needs no SciPy

        times = np.bincount(self.place, minlength=len(self.value))
        beyond = len(self.place) * ndtr(-np.abs(self.value))
        ends = np.zeros(len(self.value), dtype=bool)
        ends[[0, -1]] = True
        return np.asarray(ends & self._often(np.ones(len(self.place), dtype=bool))
                          & (times < LEAST_REPEATS + NEIGHBOURS * beyond))

    def _often(self, counted: BoolArray) -> BoolArray:
        times = np.bincount(self.place[counted], minlength=len(self.value))
        nothing = np.zeros(REACH, dtype=times.dtype)
        around = sliding_window_view(np.concatenate([nothing, times, nothing]), 2 * REACH + 1)
        beside = np.delete(around, REACH, axis=1).max(axis=1)
        away = (np.abs(self.value) > AWAY) | (AWAY * self.step < 1)
        return np.asarray(away & (times > LEAST_REPEATS + NEIGHBOURS * beside))


def _beside_a_limit(level: FloatArray, place: IntArray) -> float:
    """Median distance of the other samples from an end where most are; 0 where it is no limit.

    Noise that is cut off in its middle goes on without a gap where it is not cut off.
    """
    most = int(np.bincount(place).argmax())
    beside = np.sort(np.abs(level[place[place != most]] - level[most]))
    if most not in (0, len(level) - 1) or len(beside) < LEAST_REPEATS:
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
    axis = _Levels.of(values)
    return np.asarray(axis.limits[axis.place])


def _alone(some: BoolArray) -> bool:
    """Whether ``some`` samples are scattered over the log as if by chance."""
    count = int(some.sum())
    runs = int(np.count_nonzero(np.diff(np.concatenate([[False], some]).astype(np.int8)) > 0))
    return runs >= count * (1 - count / len(some)) * 2 / 3


def _again(values: FloatArray, axes: Sequence[_Levels]) -> BoolArray:
    """Samples whose tuple, or whose value on one axis, repeats more often than noise explains."""
    stray = np.zeros(len(values), dtype=bool)
    if axes and all(axis.step <= 1 for axis in axes):
        key = np.zeros(len(values), dtype=np.int64)
        for axis in axes:
            key = key * len(axis.value) + axis.place
        _, first, place, times = np.unique(
            key, return_index=True, return_inverse=True, return_counts=True)
        # As often as the axes of all other samples would meet by chance.
        others = np.maximum(len(values) - times, 1)
        chance = np.prod([(np.bincount(axis.place)[axis.place[first]] - times) / others
                          for axis in axes], axis=0)
        often = times > LEAST_REPEATS + OFTEN * len(values) * chance
        stray |= _scattered(place, np.flatnonzero(often))
    for axis in axes:
        stray |= _scattered(axis.place, np.flatnonzero(axis.repeated(~stray)))
    return stray


def _scattered(place: IntArray, numbers: IntArray) -> BoolArray:
    """Samples at the levels ``numbers`` that scatter over the log, shape (t,).

    Many values that occur too often are a property of the converter: its steps are uneven.
    """
    stray = np.zeros(len(place), dtype=bool)
    if len(numbers) > FEW_VALUES:
        return stray
    for number in numbers:
        there = place == number
        if _alone(there):
            stray |= there
    return stray


def _require_few(log: ImuLog, triad: Triad, values: FloatArray, stray: BoolArray) -> None:
    if stray.mean() > TOO_MANY:
        raise Undetermined(
            f"{log.label}: {100 * stray.mean():.0f} % of the {triad}'s samples are no measurement: "
            f"{_described(values, stray)}. At most {100 * TOO_MANY:.0f} % can be left out. Check "
            f"wiring, bus speed and supply, and record the pose again."
        )


def _described(values: FloatArray, stray: BoolArray) -> str:
    """The most frequent tuples among the stray samples."""
    tuples, count = np.unique(values[stray], axis=0, return_counts=True)
    order = np.argsort(-count, kind="stable")[:TUPLES_SHOWN]
    shown = [f"({', '.join(f'{v:g}' for v in tuples[i])}) {count[i]} times" for i in order]
    more = len(tuples) - len(order)
    return ", ".join(shown) + (f" and {more} other tuples" if more > 0 else "")
