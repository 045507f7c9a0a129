"""Drift of readings within a pose due to temperature or time, estimated from the other poses.

A bias that follows the temperature changes during a pose, and the larger the change, the more it
looks like a moved sensor. The other poses separate the two: a bias changes along the sensor's own
axes by the same amount per kelvin and per second in every attitude, whereas a sensor that turns
exchanges gravity between its axes. The slopes are the least squares solution of

    v_b - mean(v) = Σ_j (x_jb - mean(x_j)) c_j

over the batch means v_b of the other poses, x_j the time and the temperature, axis by axis.
"""

from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging.average_pose import average_pose, strays_of
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.checks.pose_checks import SensorMoved
from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import TEMPERATURE, TRIADS, FloatArray, ImuLog, Triad
from calib.poses.samples.batches import PARTS, batch_means

FEWEST_OTHERS = 3
"""Number of poses that show the slopes. Derived: with two unknowns on each axis, one pose that was
moved in the same way cannot determine the answer. A count of poses: runs of 7 and more are the same
at half and twice."""


def average_poses(
    logs: Sequence[ImuLog], specs: Specs, rates_rad_s: Sequence[float]
) -> list[PoseMean]:
    """Average the poses of one run.

    A pose that seems to have moved is compared with the others: with their strays, and at rest
    after the drift common to all of them is removed.

    Parameters
    ----------
    logs : sequence of ImuLog
        One for each pose.
    specs : mapping of triad to TriadSpec
        Data sheets; a triad without one is left out.
    rates_rad_s : sequence of float
        Approximate rate of the plate in each pose, 0 at rest.

    Raises
    ------
    UnusableLog, Undetermined, Contradiction
        As :func:`calib.poses.averaging.average_pose`.
    """
    means = []
    for i, (log, rate) in enumerate(zip(logs, rates_rad_s, strict=True)):
        try:
            means.append(average_pose(log, specs, rate))
        except SensorMoved as moved:
            others = [(logs[j], its) for j, its in enumerate(rates_rad_s)
                      if j != i and (its == 0) == (rate == 0)]
            logged = {triad: specs[triad] for triad in TRIADS if triad in specs and log.has(triad)}
            drift = None if rate else {
                triad: drift_within(log, [other for other, _ in others], triad, spec)
                for triad, spec in logged.items()}
            usual = {triad: _usual_stray(others, triad, spec) for triad, spec in logged.items()}
            try:
                means.append(average_pose(log, specs, rate, drift=drift, usual=usual))
            except Undetermined:
                raise moved from None
    return means


def _usual_stray(
    others: Sequence[tuple[ImuLog, float]], triad: Triad, spec: TriadSpec
) -> FloatArray:
    """The median stray of poses, each with its rate, SI, (3,); zero where few show it."""
    strays = [strays_of(other, triad, spec, rate) for other, rate in others
              if other.has(triad) and len(other.time_s) >= PARTS]
    return np.asarray(np.median(strays, axis=0)) if len(strays) >= FEWEST_OTHERS else np.zeros(3)


def drift_within(
    log: ImuLog, others: Sequence[ImuLog], triad: Triad, spec: TriadSpec
) -> FloatArray:
    """Drift of the readings of a pose about their mean, by the other poses, (t, 3), SI.

    Zero if fewer than ``FEWEST_OTHERS`` others show it.
    """
    t = len(log.time_s)
    alike = [other for other in others
             if other.has(triad) and len(other.time_s) >= PARTS
             and (TEMPERATURE in other.columns) == (TEMPERATURE in log.columns)]
    if len(alike) < FEWEST_OTHERS:
        return np.zeros((t, 3))
    x = np.concatenate([_about_mean(batch_means(_causes(other), PARTS))
                        for other in alike])
    v = np.concatenate([
        _about_mean(batch_means(spec.nominal(other.readings(triad)), PARTS))
        for other in alike
    ])
    size = np.maximum(np.sqrt((x**2).sum(axis=0)), np.finfo(float).tiny)
    slopes = np.linalg.lstsq(x / size, v, rcond=None)[0] / size[:, None]
    return np.asarray(_about_mean(_causes(log)) @ slopes)


def _causes(log: ImuLog) -> FloatArray:
    """Time in the pose and, where it was logged, the temperature, (t, 1 or 2)."""
    causes = [log.time_s, *(log.columns[name] for name in (TEMPERATURE,) if name in log.columns)]
    return np.column_stack(causes)


def _about_mean(values: FloatArray) -> FloatArray:
    return np.asarray(values - values.mean(axis=0))
