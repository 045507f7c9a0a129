"""One pose to one mean with an honest sd.

The samples of a pose are autocorrelated, so the sd of their mean comes from batch means: the pose
is cut into ``BATCHES`` equal stretches and the scatter of the stretch means is what counts; once
more with half as many, twice as long ones, to see what correlation the shorter left out
(:func:`calib.poses.mean_noise.correlation_factor`).

On the turning plate the mean is taken over whole turns, and what comes back once and twice per
turn (plate tilt, wow) is taken out first: it averages to nothing but would look like noise.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from calib.errors import Remedy, Undetermined, UnusableLog
from calib.poses.batches import BATCHES, COARSE_BATCHES, batch_means, batch_variance
from calib.poses.creep import creep_rate
from calib.poses.data_sheet import TriadSpec
from calib.poses.envelope import envelope
from calib.poses.imu_log import (
    AXES,
    SI_UNIT,
    TRIADS,
    FloatArray,
    ImuLog,
    Triad,
)

SHORT_BATCHES = 2 * BATCHES
MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""

RAIL_SHARE = 1e-3
HARMONICS = (1, 2)
LARGEST_SHIFT_SD = 10.0
LARGEST_STILL_SHIFT = {"accelerometer": 0.02, "gyroscope": 0.02}
"""m/s² and rad/s: a tilt of 0.1°, a turn of 1°/s. Smaller shifts are drift, not motion."""

LARGEST_RATE_CHANGE = 0.005
SHORTEST_SAMPLES = 2 * BATCHES
MOST_DECIMALS = 9
PRINTED_TOLERANCE = 1e-6
"""Of the last decimal: far above the rounding of a double, far below one."""


@dataclass(frozen=True, eq=False)
class TriadMean:
    """Mean of one triad over one pose, in nominal SI units.

    ``mean`` (3,), ``variance`` and ``coarse_variance`` (3,) of that mean from BATCHES and from
    COARSE_BATCHES batches, ``scatter`` (3,) variance of the samples about it, ``step`` (3,) between
    neighbouring values of the log (infinite where there was one value only), ``unit`` (3,) the
    least step that its converter or its decimals can have; all NaN where the triad was not logged.
    ``envelope`` (e, 2, 3) lowest and highest sample of equal stretches.
    """

    mean: FloatArray
    variance: FloatArray
    coarse_variance: FloatArray
    scatter: FloatArray
    step: FloatArray = field(default_factory=lambda: np.full(3, np.inf))
    unit: FloatArray = field(default_factory=lambda: np.zeros(3))
    envelope: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 3)))


@dataclass(frozen=True, eq=False)
class PoseMean:
    """One averaged pose: both triads, the time it was taken and every logged column.

    ``creep_rad_s`` is how fast it turned although at rest, as far as gravity shows that.
    ``stated``: the mean and its sd come from a table; an sd that was not stated there is NaN.
    """

    label: str
    accelerometer: TriadMean
    gyroscope: TriadMean
    time_s: float
    duration_s: float
    columns: dict[str, float]
    creep_rad_s: float = 0.0
    stated: bool = False


_NOT_LOGGED = TriadMean(*(np.full(3, np.nan) for _ in range(4)))


def value_steps(values: FloatArray) -> FloatArray:
    """The step between neighbouring values of each axis of a log (t, 3), in its units, (3,).

    A converter steps by one count, or by more where the log was shifted or rounded; of a log in
    physical units the values themselves show it. Infinite where all are the same.
    """
    steps = []
    for axis in values.T:
        whole = np.rint(axis)
        if np.array_equal(axis, whole):
            step = float(np.gcd.reduce((whole - whole[0]).astype(np.int64)))
        else:
            gaps = np.diff(np.unique(axis))
            step = float(gaps.min()) if gaps.size else 0.0
        steps.append(step or np.inf)
    return np.array(steps)


def least_steps(values: FloatArray, spec: TriadSpec) -> FloatArray:
    """One count, or the unit of the last decimal that the first of ``values`` (t, 3) has, (3,)."""
    if spec.encoding != "si":
        return np.ones(3)
    decimals = np.arange(MOST_DECIMALS)
    scaled = values[0][:, None] * 10.0**decimals
    is_whole = np.abs(scaled - np.rint(scaled)) < PRINTED_TOLERANCE
    return np.where(is_whole.any(axis=1), 10.0 ** -np.argmax(is_whole, axis=1).astype(float), 0.0)


def _halves(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Means of both halves and the sd their difference has by noise alone, each (k,).

    That sd comes from the median second difference of ``SHORT_BATCHES`` batch means, which neither
    one jump nor a steady creep enters: measured by the motion itself, no motion would be large.
    The axes share it, since a median of so few would often come out far too small.
    """
    half = len(values) // 2
    second = np.diff(batch_means(values, SHORT_BATCHES), n=2, axis=0)
    of_batch = np.median(np.abs(second), axis=0) / MEDIAN_OF_NORMAL / math.sqrt(6)
    noise = np.full(len(of_batch), math.sqrt(np.mean(of_batch**2) * 4 / SHORT_BATCHES))
    return values[:half].mean(axis=0), values[half:].mean(axis=0), noise


def _check_counts(label: str, triad: str, counts: FloatArray, spec: TriadSpec) -> None:
    low, high = spec.count_range
    if counts.min() < low or counts.max() > high:
        span = f"{counts.min():g} to {counts.max():g}"
        other = "twos-complement" if counts.min() < 0 else "unsigned-twos-complement, offset-binary"
        raise UnusableLog(
            f"{label}: {triad} counts run from {span}, but {spec.bits} bit {spec.encoding} spans "
            f"{low:g} to {high:g}. Is the encoding {other}, or the number of bits another? "
            f"State encoding and bits as the data sheet has them.",
            Remedy("data_sheet", triad),
        )
    at_rail = (counts <= low) | (counts >= high)
    share = at_rail.mean(axis=0)
    if share.max() > RAIL_SHARE:
        axis = AXES[int(np.argmax(share))]
        raise Undetermined(
            f"{label}: {triad} {axis} is saturated: {100 * share.max():.1f} % of its samples "
            f"stand at the end of the range ({low:g} or {high:g} counts). The true value is "
            f"unknown there; choose a larger full scale or a slower plate, and record the pose "
            f"again."
        )


def _whole_turns(log: ImuLog, rate_rad_s: float) -> int:
    step_s = (log.time_s[-1] - log.time_s[0]) / (len(log.time_s) - 1)
    turn_s = 2 * math.pi / rate_rad_s
    turns = math.floor(len(log.time_s) * step_s / turn_s + 1e-9)
    if turns < 1:
        raise Undetermined(
            f"{log.label}: lasts {log.time_s[-1] - log.time_s[0]:.1f} s, less than one turn of the "
            f"plate ({turn_s:.2f} s). Log at least three whole turns in every pose."
        )
    return round(float(turns * turn_s / step_s))


def _without_harmonics(values: FloatArray, time_s: FloatArray, rate_rad_s: float) -> FloatArray:
    """``values`` less what comes back HARMONICS times per turn; the mean is not touched."""
    angle = rate_rad_s * (time_s - time_s[0])
    waves = np.column_stack([f(h * angle) for h in HARMONICS for f in (np.cos, np.sin)])
    design = np.column_stack([np.ones(len(angle)), waves])
    # Normal equations: whole turns make the design orthogonal, so nothing is lost by them.
    solution = np.linalg.solve(design.T @ design, design.T @ values)
    return np.asarray(values - waves @ solution[1:])


def _check_still(label: str, triad: str, values: FloatArray, largest_shift: float) -> None:
    first, second, noise = _halves(values)
    shift = np.abs(second - first)
    limit = np.maximum(largest_shift, LARGEST_SHIFT_SD * noise)
    axis = int(np.argmax(shift / limit))
    if shift[axis] > limit[axis]:
        unit = SI_UNIT[triad]
        raise Undetermined(
            f"{label}: the sensor moved: {triad} {AXES[axis]} differs by {shift[axis]:.3g} {unit} "
            f"between the first and the second half of the pose; still poses agree within "
            f"{limit[axis]:.2g} {unit}. Record the pose again, or cut the log to the part in "
            f"which it lay still."
        )


def _check_steady(label: str, values: FloatArray) -> None:
    first, second, noise = _halves(values)
    start, end = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    change = end - start
    limit = max(LARGEST_RATE_CHANGE * start, LARGEST_SHIFT_SD * float(noise.max()))
    if abs(change) > limit:
        verb = "sped up" if change > 0 else "slowed down"
        raise Undetermined(
            f"{label}: the plate {verb} during the pose: the gyro reads {start:.4g} rad/s in the "
            f"first half and {end:.4g} rad/s in the second ({100 * change / start:+.2f} %, at most "
            f"{100 * limit / start:.1f} % expected). Start the log when the plate has reached its "
            f"speed, or cut the log to the steady part."
        )


def average_pose(
    log: ImuLog,
    accelerometer: TriadSpec | None,
    gyroscope: TriadSpec | None,
    rate_rad_s: float = 0.0,
    largest_shift: Mapping[str, float] = LARGEST_STILL_SHIFT,
) -> PoseMean:
    """Average one pose, still or turning.

    Parameters
    ----------
    log : ImuLog
        Counts of this pose alone.
    accelerometer, gyroscope : TriadSpec or None
        Data sheets; a triad without one is left out.
    rate_rad_s : float
        Approximate rate of the plate, 0 for a still pose.
    largest_shift : mapping of triad to float
        By how much the halves of a still pose may differ, SI.

    Returns
    -------
    PoseMean

    Raises
    ------
    UnusableLog
        Counts outside what the converter can give.
    Undetermined
        Too short, saturated, moved while still, or the plate not steady.
    """
    n = len(log.time_s) if rate_rad_s == 0 else _whole_turns(log, abs(rate_rad_s))
    if n < SHORTEST_SAMPLES:
        raise Undetermined(
            f"{log.label}: {n} samples, at least {SHORTEST_SAMPLES} expected in a pose. Log each "
            f"pose for some seconds."
        )
    means, creep_rad_s = [], 0.0
    duration_s = float(log.time_s[n - 1] - log.time_s[0])
    for triad, spec in zip(TRIADS, (accelerometer, gyroscope), strict=True):
        if spec is None or not log.has(triad):
            means.append(_NOT_LOGGED)
            continue
        counts = spec.signed(getattr(log, triad)[:n])
        _check_counts(log.label, triad, counts, spec)
        values = spec.nominal(counts)
        if rate_rad_s == 0:
            _check_still(log.label, triad, values, largest_shift[triad])
            rest = values
            if triad == "accelerometer":
                creep_rad_s = creep_rate(batch_means(values, BATCHES), duration_s)
        else:
            rest = _without_harmonics(values, log.time_s[:n], abs(rate_rad_s))
            if triad == "gyroscope":
                _check_steady(log.label, rest)
        means.append(
            TriadMean(
                mean=values.mean(axis=0),
                variance=batch_variance(rest, BATCHES),
                coarse_variance=batch_variance(rest, COARSE_BATCHES),
                scatter=rest.var(axis=0, ddof=1),
                step=value_steps(counts) * spec.nominal_scale,
                unit=least_steps(counts, spec) * spec.nominal_scale,
                envelope=envelope(values),
            )
        )
    return PoseMean(
        label=log.label,
        accelerometer=means[0],
        gyroscope=means[1],
        time_s=float(log.time_s[:n].mean()),
        duration_s=duration_s,
        columns={name: float(values[:n].mean()) for name, values in log.columns.items()},
        creep_rad_s=creep_rad_s,
    )


def check_alive(means: Sequence[PoseMean], triad: Triad, run: str) -> None:
    """Refuse a run in which an axis gave the very same value all the time."""
    spread = np.max([getattr(mean, triad).scatter for mean in means], axis=0)
    values = np.array([getattr(mean, triad).mean for mean in means])
    stuck = (spread == 0) & (np.ptp(values, axis=0) == 0)
    if len(means) > 1 and stuck.any():
        axis = AXES[int(np.argmax(stuck))]
        raise Undetermined(
            f"{run}: {triad} {axis} is stuck: it gives the same value in every sample of all "
            f"{len(means)} poses. Check the wiring, the register settings, or whether the column "
            f"was logged twice."
        )
