"""Readings that the sensor itself did not deliver: frozen, cut off, or brought to one length.

**Frozen**: the sensor, a triad or an axis stood still for longer than its noise allows.

**Cut off** below the converter's range, by a filter, an amplifier, or another full scale: noise is
densest in its middle, and a wave is at its crest for less than half of the time. If a log stays at
its own largest (or smallest) value more often, that value is a limit. A quiet sensor on a coarse
converter has few values; an axis that stays at a single value while the other logs scatter is
frozen.

**Normalised**: an attitude filter needs only the direction of gravity. Such unit vectors fit every
model of bias, scale and misalignment without a residual, and contain no information on the sensor.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Remedy, Undetermined
from calib.numbers import NO_LENGTH
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.checks.levels import cut_off
from calib.poses.data_sheet import TriadSpec
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
        values, shown = ((np.hstack([log.readings(triad)[:, axes] + 0.0 for triad, axes in columns])
                          for log in every if all(log.has(triad) for triad, _ in columns))
                         for every in (logs, others))
        if with_all and (stretches := _stretches(of, with_all, [*values], shown)):
            return stretches
    return []


def _stretches(
    of: str, index: Sequence[int], logs: Sequence[FloatArray], others: Iterable[FloatArray]
) -> list[FrozenStretch]:
    """Find frozen stretches in some columns, (t, k) of each log."""
    again = [(values[1:] == values[:-1]).all(axis=1) for values in logs]
    stretches = [_longest_stretch(equal) for equal in again]
    equal = sum(int(each.sum()) for each in again)
    inside = sum(count - 1 for _, count in stretches)
    rows = sum(map(len, logs))
    shortest = SHORTEST_OF_ONE if logs[0].shape[1] == 1 else 0.0
    least = [max(shortest * len(values), np.sqrt(len(values))) for values in logs]
    if all(count <= each for (_, count), each in zip(stretches, least, strict=True)):
        return []  # of nearly all sessions
    noisy = logs if inside < rows - len(logs) else (*logs, *others)
    stays = max((equal - inside + 1) / (rows + 2), _stays_in_a_step(noisy))
    by_chance = 1 + np.log(FALSE_ALARM / rows) / np.log(min(stays, 1 - 1 / rows))
    return [
        FrozenStretch(i, start, count, of)
        for i, each, (start, count) in zip(index, least, stretches, strict=True)
        if count > max(by_chance, each)
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


def require_running(runs: Sequence[Sequence[ImuLog]]) -> None:
    """Refuse poses in which the sensor froze.

    Parameters
    ----------
    runs : sequence of sequence of ImuLog
        The logs of each run: the noise of one shows how long a reading of another may stay
        constant; for a run without any noise that of all. A motor shakes some runs and not all.

    Raises
    ------
    Undetermined
        Naming the samples of the first log, and all other logs.
    """
    every = [log for logs in runs for log in logs]
    stood = [(logs[one.index], one) for logs in runs for one in find_frozen(logs, every)]
    if not stood:
        return
    (log, first), *others = stood
    of_one_axis = first.of.endswith(tuple(f" {axis}" for axis in AXES))
    why = ("The axis is cut off at that reading, or stuck" if of_one_axis else
           "The sensor or its connection had stopped")
    part = "" if first.count == len(log.time_s) else ", or cut the log to the part before"
    labels = dict.fromkeys(other.label for other, _ in others)
    raise Undetermined(
        f"{log.label}: {'stands still' if of_one_axis else 'froze'}: its samples {first.start + 1} "
        f"to {first.start + first.count} are one and the same reading of {first.of}, where the "
        f"other logs scatter. {why}. Record the pose again{part}."
        + (f" The same is to be done with {', '.join(labels)}." if labels else ""),
        Remedy("exclude_pose"))


def _longest_stretch(equal: BoolArray) -> tuple[int, int]:
    """Start and length of the longest run of rows that are ``equal`` to their predecessor."""
    edges = np.r_[0, np.flatnonzero(~equal) + 1, len(equal) + 1]
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    return int(edges[longest]), int(lengths[longest])


CLIPPED_SHARE = 0.45
"""Share of a log's samples at its extreme. Derived: a wave of a few steps has up to 0.30 at its
crest, 0.40 in one and a half turns; noise that is cut off in its middle has half."""

FEWEST_LEVELS = 4
"""Number of values of an axis. Derived: noise of fewer can have a third of them at its end."""


def require_unclipped(logs: Sequence[ImuLog], triad: Triad, spec: TriadSpec) -> None:
    """Refuse logs of ``triad`` in which an axis is cut off below the full scale of ``spec``.

    Samples at the ends of the range are refused where the pose is averaged.

    Parameters
    ----------
    logs : sequence of ImuLog
    triad : str
    spec : TriadSpec
        The data sheet of the triad.

    Raises
    ------
    Undetermined
        Naming log, axis and value.
    """
    rails = spec.count_range
    for log in logs:
        if not log.has(triad):
            continue
        for name, axis in zip(AXES, log.readings(triad).T, strict=True):
            for extreme in _limits(axis):
                if not rails[0] < extreme < rails[1]:
                    continue
                share = float((axis == extreme).mean())
                raise Undetermined(
                    f"{log.label}: {triad} {name} stands at {extreme:g} in {100 * share:.0f} % of "
                    f"its samples and never goes beyond: the axis is clipped there, or stuck. The "
                    f"true value is unknown; choose a larger full scale or a slower plate, and "
                    f"record the pose again.", Remedy("exclude_pose"),
                )


def _limits(axis: FloatArray) -> Iterator[float]:
    """The extremes of the readings (t,) of an axis at which it is cut off."""
    at_limit = cut_off(axis)
    for extreme in (axis.max(), axis.min()):
        there = axis == extreme
        if at_limit[there].any() or (
                there.mean() > CLIPPED_SHARE and len(np.unique(axis)) >= FEWEST_LEVELS):
            yield float(extreme)


def levels_of_cut(log: ImuLog, others: Sequence[ImuLog], triad: Triad) -> FloatArray:
    """Levels at which the axes of a log are cut off, and beyond which no other log goes.

    Parameters
    ----------
    log : ImuLog
    others : sequence of ImuLog
        All other logs of the session.
    triad : str

    Returns
    -------
    array, shape (3,)
        Signed counts; NaN for an axis that is not cut off, or merely stuck.
    """
    levels = np.full(3, np.nan)
    values, *shown = (one.readings(triad) for one in (log, *others) if one.has(triad))
    if _stretches(triad, [0], [values], shown):
        return levels  # all axes at once: the sensor stopped
    for k, axis in enumerate(values.T):
        stood = _stretches(triad, [0], [axis[:, None]], [other[:, k : k + 1] for other in shown])
        for level in (*_limits(axis), *(float(axis[stretch.start]) for stretch in stood)):
            beyond = [np.sign(other[:, k] - level) for other in (values, *shown)]
            if min(map(np.min, beyond)) >= 0 or max(map(np.max, beyond)) <= 0:
                levels[k] = level
    return levels


SAME_LENGTH = 0.1
"""Scatter of the samples' length over that of their axes. Derived: if the noise of one axis is
three times less than that of the others it is 0.3; at a constant length only the steps scatter."""

FEWEST_STEPS = 4.0
"""Scatter of the axes, steps, from which one step is less than SAME_LENGTH of it. Derived."""


def require_raw(logs: Sequence[ImuLog], spec: TriadSpec) -> None:
    """Refuse logs of poses at rest whose accelerometer samples all have one length.

    Raises
    ------
    Undetermined
        Naming the first log, where most of them are so.
    """
    alike = []
    for log in logs:
        if not log.has("accelerometer"):
            continue
        counts = log.accelerometer
        values = spec.nominal(counts)
        axes = float(np.sqrt(values.var(axis=0).mean()))
        step = float((value_steps(counts) * spec.nominal_scale).min())
        length = float(np.linalg.norm(values, axis=1).std())
        if axes > FEWEST_STEPS * step and length < SAME_LENGTH * axes:
            alike.append((log.label, length, axes))
    if 2 * len(alike) > len(logs):
        label, length, axes = alike[0]
        raise Undetermined(
            f"{label}: the accelerometer's samples have one length (sd {length:.2g} m/s², of each "
            f"axis {axes:.2g} m/s²), as have {len(alike) - 1} other logs: something brought them "
            f"to it, as filters of attitude do. Such vectors say nothing of bias and scale; log "
            f"what the sensor itself delivers."
        )
