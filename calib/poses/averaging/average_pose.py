"""From one pose to one mean with an honest sd.

The samples of a pose are autocorrelated, so the sd of their mean comes from batch means: the pose
is cut into ``BATCHES`` equal stretches, and the scatter of the stretch means gives the sd. Twice as
many means show the correlation that the batches leave out
(:mod:`calib.poses.averaging.correlation`).

On the turning plate the mean is taken over whole turns, and the waves once and twice per turn
(plate tilt, wow) are removed first: they average to zero but would look like noise. Over few turns
that takes part of the noise between the batches too, and the variance is restored by its share.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from calib.errors import Contradiction, Undetermined
from calib.poses.averaging.pose_mean import NOT_LOGGED, PoseMean, TriadMean
from calib.poses.averaging.sway import check_calm, sway_square
from calib.poses.checks.pose_checks import (
    LARGEST_STILL_SHIFT,
    check_attitude,
    check_counts,
    check_steady,
    check_still,
    stray_of,
)
from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, ImuLog, Triad
from calib.poses.samples.batches import (
    BATCHES,
    PARTS,
    SHORTEST_SAMPLES,
    batch_means,
    batch_variance,
    creep_rate,
    envelope,
)
from calib.poses.samples.converter_steps import least_steps, value_steps
from calib.poses.samples.in_step import HARMONICS, plate_angle, rate_in_step, waves_of
from calib.poses.triad_kind import TRIAD_KINDS

LEAST_PER_TURN = 5
"""Least number of samples per turn. Derived: a mean and both harmonics are five unknowns."""

LONGEST_PAUSE = 0.25
"""Share of a turn without a sample. Derived: the mean of a wave over three turns is then up to 0.08
of its amplitude."""

WHOLE_TURN = 1e-9  #: turns by which the last one may be incomplete: rounding of the stamps


def without_pause(log: ImuLog, rate_rad_s: float) -> ImuLog:
    """The longest stretch of a log of the turning plate in which no long part of a turn is missing.

    What comes back with every turn averages out over whole turns without a pause only.

    Raises
    ------
    Contradiction
        A turn has too few samples: its stamps are no seconds, or the rate is wrong.
    """
    steps = np.diff(log.time_s)
    step_s = float(np.median(steps))
    turn_s = 2 * math.pi / rate_rad_s
    if turn_s < LEAST_PER_TURN * step_s:
        raise Contradiction(
            f"{log.label}: its time stamps are {step_s:.3g} s apart, and a turn of the plate lasts "
            f"{turn_s:.3g} s: {turn_s / step_s:.2g} samples in a turn, where {LEAST_PER_TURN} and "
            f"more are expected. Are the stamps milliseconds, microseconds or a counter? Bring "
            f"them to seconds, or check the rate of this run."
        )
    ends = [0, *(np.flatnonzero(steps > LONGEST_PAUSE * turn_s) + 1), len(log.time_s)]
    begin, end = max(pairwise(ends), key=lambda part: part[1] - part[0])
    return log if end - begin == len(log.time_s) else log.take(slice(begin, end))


def _whole_turns(log: ImuLog, rate_rad_s: float) -> int:
    step_s = (log.time_s[-1] - log.time_s[0]) / (len(log.time_s) - 1)
    turn_s = 2 * math.pi / rate_rad_s
    turns = math.floor(len(log.time_s) * step_s / turn_s + WHOLE_TURN)
    if turns < 1:
        raise Undetermined(
            f"{log.label}: lasts {log.time_s[-1] - log.time_s[0]:.3g} s by its time stamps, less "
            f"than one turn of the plate ({turn_s:.2f} s). Log at least three whole turns in every "
            f"pose; if this log has them, its stamps are not in seconds."
        )
    return round(float(turns * turn_s / step_s))


def _harmonics(time_s: FloatArray, rate_rad_s: float) -> FloatArray:
    """Waves HARMONICS times per turn, (t, 4), of one unit."""
    angle = rate_rad_s * (time_s - time_s[0])
    return np.column_stack([f(h * angle) for h in HARMONICS for f in (np.cos, np.sin)])


def _without(values: FloatArray, waves: FloatArray) -> FloatArray:
    """``values`` (t, 3) less their ``waves`` (t, w); the mean is unchanged."""
    design = np.column_stack([np.ones(len(waves)), waves])
    # Normal equations: whole turns make the design orthogonal, so nothing is lost by them.
    solution = np.linalg.solve(design.T @ design, design.T @ values)
    return np.asarray(values - waves @ solution[1:])


def _share_left(waves: FloatArray) -> float:
    """Share of the batches' variance by white noise that is left without ``waves`` (t, w).

    Over whole turns t/2 is the square of a wave's length: two thirds are lost in one turn, a sixth
    in three, nothing in many.
    """
    return float(1 - 2 * batch_variance(waves, BATCHES).sum())


def _angle(log: ImuLog, specs: Specs, n: int, rate_rad_s: float) -> FloatArray:
    """The angle of the plate at the first n samples, rad."""
    if "gyroscope" not in specs or not log.has("gyroscope"):
        return plate_angle(log.time_s[:n], None, rate_rad_s)
    readings = specs["gyroscope"].nominal(log.gyroscope[:n])
    return plate_angle(log.time_s[:n], readings, rate_rad_s)


def strays_of(
    log: ImuLog, triad: Triad, spec: TriadSpec, rate_rad_s: float = 0.0
) -> FloatArray:
    """The stray of the readings of one pose, SI, (3,); parameters as :func:`average_pose`."""
    values = spec.nominal(log.readings(triad))
    return stray_of(values if rate_rad_s == 0 else
                    _without(values, _harmonics(log.time_s, abs(rate_rad_s))))


def average_pose(
    log: ImuLog,
    specs: Specs,
    rate_rad_s: float = 0.0,
    largest_shift: Mapping[str, float] = LARGEST_STILL_SHIFT,
    drift: Mapping[Triad, FloatArray] | None = None,
    usual: Mapping[Triad, FloatArray] | None = None,
) -> PoseMean:
    """Average one pose, still or turning.

    Parameters
    ----------
    log : ImuLog
        Counts of this pose alone.
    specs : mapping of triad to TriadSpec
        Data sheets; a triad without one is left out.
    rate_rad_s : float
        Approximate rate of the plate, 0 for a still pose.
    largest_shift : mapping of triad to float
        By how much the halves of a still pose may differ, SI.
    drift : mapping of triad to array, shape (t, 3), optional
        What is known to drift in a pose at rest, about its mean, SI: it is no motion.
    usual : mapping of triad to array, shape (3,), optional
        By how much the run's other poses stray, SI: what they all do is noise and no motion.

    Raises
    ------
    UnusableLog
        Counts outside what the converter can give.
    Undetermined
        Too short, saturated, moved while still, or the plate not steady.
    Contradiction
        A turn of the plate has fewer than five samples: the clock or the rate is wrong.
    """
    if rate_rad_s:
        log = without_pause(log, abs(rate_rad_s))
    if rate_rad_s and "accelerometer" in specs and log.has("accelerometer"):
        readings = specs["accelerometer"].nominal(log.accelerometer)
        rate_rad_s = rate_in_step(readings, log.time_s, abs(rate_rad_s))
    n = len(log.time_s) if rate_rad_s == 0 else _whole_turns(log, abs(rate_rad_s))
    if n < SHORTEST_SAMPLES:
        raise Undetermined(
            f"{log.label}: {n} samples, at least {SHORTEST_SAMPLES} expected in a pose. Log each "
            f"pose for some seconds."
        )
    means: dict[Triad, TriadMean] = {}
    nominal: dict[Triad, FloatArray] = {}
    angle = None if rate_rad_s == 0 else _angle(log, specs, n, abs(rate_rad_s))
    harmonics = (np.zeros((n, 0)) if rate_rad_s == 0 else
                 _harmonics(log.time_s[:n], abs(rate_rad_s)))
    share_left = _share_left(harmonics)
    creep_rad_s, sway = 0.0, math.nan
    strays = usual or dict.fromkeys(TRIADS, np.zeros(3))
    duration_s = float(log.time_s[n - 1] - log.time_s[0])
    for triad in TRIADS:
        if triad not in specs or not log.has(triad):
            means[triad] = NOT_LOGGED
            continue
        spec = specs[triad]
        counts = spec.signed(log.readings(triad)[:n])
        check_counts(log.label, triad, counts, spec)
        nominal[triad] = values = spec.nominal(counts)
        step = value_steps(counts) * spec.nominal_scale
        known = np.where(np.isfinite(step), step, 0.0)
        if rate_rad_s == 0:
            rest, still = values, values if drift is None else values - drift[triad]
            check_still(log.label, triad, still, known, largest_shift[triad], strays[triad])
            if triad == "accelerometer":
                creep_rad_s = creep_rate(batch_means(still, BATCHES), duration_s)
            else:
                sway = sway_square(still, duration_s)
        else:
            rest = _without(values, harmonics)
            if triad == "gyroscope":
                check_steady(log.label, rest)
            check_attitude(log.label, triad, rest, known, strays[triad])
        mean = _mean_of(counts, rest, spec, step)
        means[triad] = replace(mean, variance=mean.variance / share_left)
    waves = None if angle is None or not nominal else waves_of(
        np.hstack([*nominal.values()]), log.time_s[:n], angle)
    if waves is not None:
        for k, triad in enumerate(nominal):
            means[triad] = replace(means[triad], waves=waves.of(slice(3 * k, 3 * k + 3)))
    force = means["accelerometer"]
    reading_names = {name for triad in specs for name in TRIAD_KINDS[triad].columns}
    check_calm(log.label, force.scatter, sway, float(np.linalg.norm(force.mean)),
               largest_shift["accelerometer"])
    return PoseMean(
        label=log.label,
        accelerometer=force,
        gyroscope=means["gyroscope"],
        time_s=float(log.time_s[:n].mean()),
        duration_s=duration_s,
        columns={name: float(values[:n].mean()) for name, values in log.columns.items()
                 if name not in reading_names},
        creep_rad_s=creep_rad_s,
        sway_rad2=sway,
        further={triad: _further_mean(log, triad, spec, n) for triad, spec in specs.items()
                 if triad not in TRIADS},
    )


def _mean_of(
    counts: FloatArray, rest: FloatArray, spec: TriadSpec, step: FloatArray
) -> TriadMean:
    """Mean of readings (n, 3); ``rest`` (n, 3) is their residual noise, ``step`` (3,), SI."""
    values = spec.nominal(counts)
    return TriadMean(
        mean=values.mean(axis=0),
        variance=batch_variance(rest, BATCHES),
        scatter=rest.var(axis=0, ddof=1),
        parts=batch_means(rest, PARTS),
        step=step,
        unit=least_steps(counts, spec) * spec.nominal_scale,
        envelope=envelope(values),
    )


def _further_mean(log: ImuLog, triad: Triad, spec: TriadSpec, n: int) -> TriadMean:
    """The mean of a further triad over its available samples; NaN if these are too few.

    Accelerometer and gyroscope show whether the sensor rests.
    """
    if not log.has(triad):
        return NOT_LOGGED
    readings = log.readings(triad)[:n]
    counts = spec.signed(readings[np.isfinite(readings).all(axis=1)])
    if len(counts) < SHORTEST_SAMPLES:
        return NOT_LOGGED
    check_counts(log.label, triad, counts, spec)
    step = value_steps(counts) * spec.nominal_scale
    return _mean_of(counts, spec.nominal(counts), spec, step)
