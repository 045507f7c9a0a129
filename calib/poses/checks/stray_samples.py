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

import numpy as np

from calib.errors import Undetermined
from calib.poses.checks.levels import LEAST_REPEATS, Levels, are_resampled
from calib.poses.imu_log import TRIADS, BoolArray, FloatArray, ImuLog, IntArray, Triad

FAR = 6.0
"""Sds of the noise. Derived: normal noise goes so far once in 5·10⁸ samples; a wave goes up to 1.0
of the scale that its median deviation shows, a random walk up to about 4."""

OF_FEW = 3.5
"""Over the root of the number of samples, what is added to one times ``FAR``. Derived: three sds of
a median deviation, which shows the noise of 14 samples as half of it once in a thousand times."""

OFTEN = 10.0
"""Multiple of the chance rate at which a tuple of three independent axes repeats. Derived: axes
that move together, as noise of the supply makes them, repeat theirs some times as often."""

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
    axes = [Levels.of(axis) for axis in values.T if np.ptp(axis) > 0]
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
    return _far([Levels.of(axis) for axis in values.T if np.ptp(axis) > 0], len(values))


def _far(axes: Sequence["Levels"], count: int, sds: float = FAR) -> BoolArray:
    return np.asarray(np.any([np.zeros(count, bool), *(a.distance > sds for a in axes)], axis=0))


def _alone(some: BoolArray) -> bool:
    """Whether ``some`` samples are scattered over the log as if by chance."""
    count = int(some.sum())
    runs = int(np.count_nonzero(np.diff(np.concatenate([[False], some]).astype(np.int8)) > 0))
    return runs >= count * (1 - count / len(some)) * 2 / 3


def _again(values: FloatArray, axes: Sequence[Levels]) -> BoolArray:
    """Samples whose tuple, or whose value on one axis, repeats more often than noise explains."""
    stray = np.zeros(len(values), dtype=bool)
    if axes and are_resampled(axes):
        return stray
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
