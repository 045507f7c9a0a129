"""Logs in which the sensor, a triad or an axis stood still: it froze, or is stuck or cut off."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.numbers import NO_LENGTH
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import AXES, TRIADS, BoolArray, FloatArray, ImuLog, Triad
from calib.poses.samples.converter_steps import value_steps

FEW_LEVELS = 0.28
"""Variance in squares of a step: that of rounded noise of half a step, where both formulas for its
sd meet. Derived."""

QUIETER = 0.7
"""Share of the noise estimated from the mean variance of a session that is assumed. Derived: of 18
logs in random places of their steps the mean variance is up to 1.4 times its expectation."""

SHORTEST_OF_ONE = 0.5
"""Share of a log for which a single axis is constant. A judgement: noise of a quarter of a step
that stays correlated over many samples keeps one axis constant for a fifth of a pose."""

STILL_PARTS: Mapping[str, Sequence[tuple[Triad, slice]]] = {
    "all axes": [(triad, slice(0, 3)) for triad in TRIADS],
    **{f"the {triad}": [(triad, slice(0, 3))] for triad in TRIADS},
    **{f"{triad} {axis}": [(triad, slice(k, k + 1))]
       for triad in TRIADS for k, axis in enumerate(AXES)},
}
"""Parts of a log that can freeze, in words, and their columns."""


@dataclass(frozen=True)
class FrozenStretch:
    """Rows ``start : start + count`` of log ``index``, which hold one and the same reading.

    ``of`` is the frozen part in words: all axes, those of a triad, or one.
    """

    index: int
    start: int
    count: int
    of: str


def find_frozen(logs: Sequence[ImuLog], others: Sequence[ImuLog] = ()) -> list[FrozenStretch]:
    """Stretches of one constant reading, too long unless the sensor or logger had stopped.

    A stretch of r equal rows enters the mean of n rows with the noise of one row times r/n; from
    ``r = √n`` on that is more than the noise of the whole mean. Where the steps of the converter
    are larger than the noise, a reading in the middle of a step stays constant for long: how long
    follows from the noise of the other readings, those of ``others`` where no log of the run shows
    any. Sensors of two chips stop one at a time, and an axis that is stuck or cut off freezes
    alone.
    """
    for of, columns in STILL_PARTS.items():
        with_all = [i for i, log in enumerate(logs) if all(log.has(triad) for triad, _ in columns)]
        values, shown = ([np.hstack([log.readings(triad)[:, axes] + 0.0 for triad, axes in columns])
                          for log in every if all(log.has(triad) for triad, _ in columns)]
                         for every in (logs, others))
        if values and (stretches := _stretches(of, with_all, values, shown)):
            return stretches
    return []


def _stretches(
    of: str, index: Sequence[int], logs: Sequence[FloatArray], others: Sequence[FloatArray]
) -> list[FrozenStretch]:
    """Find frozen stretches in some columns, (t, k) of each log."""
    again = [(values[1:] == values[:-1]).all(axis=1) for values in logs]
    stretches = [_longest_stretch(equal) for equal in again]
    equal = sum(int(each.sum()) for each in again)
    inside = sum(count - 1 for _, count in stretches)
    rows = sum(map(len, logs))
    shortest = SHORTEST_OF_ONE if logs[0].shape[1] == 1 else 0.0
    noisy = logs if inside < rows - len(logs) else (*logs, *others)
    stays = max((equal - inside + 1) / (rows + 2), _stays_in_a_step(noisy))
    by_chance = 1 + np.log(FALSE_ALARM / rows) / np.log(min(stays, 1 - 1 / rows))
    return [
        FrozenStretch(i, start, count, of)
        for i, values, (start, count) in zip(index, logs, stretches, strict=True)
        if count > max(by_chance, shortest * len(values), np.sqrt(len(values)))
    ]


def _stays_in_a_step(logs: Sequence[FloatArray]) -> float:
    """Probability that a reading in the middle of a step repeats in the next row.

    The scatter of the logs in steps, averaged over where in a step they happen to lie, gives the
    sd of the noise: ``σ/√π`` where it is below half a step (∫ Φ(1 − Φ) = 1/√π), else σ² + 1/12.
    """
    from scipy.special import ndtr  # measuring a clip loads this package and needs no SciPy

    step = np.min([value_steps(values) for values in logs], axis=0)
    # Of neighbouring rows, where a wave of the turning plate does not count.
    square = [(np.diff(values, axis=0) ** 2).mean(axis=0) / 2 for values in logs]
    variance = np.mean(square, axis=0) / step**2
    noise = np.where(variance < FEW_LEVELS, np.sqrt(np.pi) * variance,
                     np.sqrt(np.maximum(variance - 1 / 12, 0.0)))
    half_step = 0.5 / np.maximum(QUIETER * noise, NO_LENGTH)
    return float(np.prod(2 * ndtr(half_step) - 1))


def require_running(logs: Sequence[ImuLog], others: Sequence[ImuLog] = ()) -> None:
    """Refuse poses in which the sensor froze.

    Parameters
    ----------
    logs : sequence of ImuLog
        Of one run: the noise of one shows how long a reading of another may stay constant.
    others : sequence of ImuLog
        Of all runs, for a run that shows no noise at all. A motor shakes some runs and not all.

    Raises
    ------
    Undetermined
        Naming the log and the samples.
    """
    for frozen in find_frozen(logs, others):
        raise Undetermined(
            f"{logs[frozen.index].label}: froze: its samples {frozen.start + 1} to "
            f"{frozen.start + frozen.count} are one and the same reading of {frozen.of}, where the "
            f"other logs scatter. The sensor or its connection had stopped, or an axis is stuck or "
            f"cut off there. Record the pose again, or cut the log to the part before."
        )


def _longest_stretch(equal: BoolArray) -> tuple[int, int]:
    """Start and length of the longest run of rows that are ``equal`` to their predecessor."""
    edges = np.r_[0, np.flatnonzero(~equal) + 1, len(equal) + 1]
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    return int(edges[longest]), int(lengths[longest])
