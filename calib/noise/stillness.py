"""Test whether a log is fit for an Allan deviation: evenly sampled, without gaps, and still."""

import numpy as np

from calib.errors import Undetermined
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import AXES, FloatArray, ImuLog, Triad

# Limits for refusing a log; half and double of each: ``tests.bench.stillness_thresholds``.
GAP_S = 0.25
"""An interval longer than this, s, and than ``GAP_STEPS`` is a gap. Tuned: shorter ones are how a
serial port delivers samples in bursts."""
GAP_STEPS = 5.0  #: usual steps, as ``GAP_S``. Tuned
WINDOW_S = 1.0
"""Length of the means and variances that show a movement, s. A judgement: as long as a touch."""
FEWEST_IN_WINDOW = 20  #: samples; derived: the sd of a variance is a third of it
JUMP = 10.0
"""Difference of neighbouring windows' means, robust sds. Derived: Gaussian noise has 6 in a billion
windows; what wanders has more."""
LOUDER = 10.0  #: variance of a window over the median one. Derived: as ``JUMP``
LARGEST_RATE_RAD_S = 0.5
"""Fact: more is no bias of a low-cost gyroscope at rest (MPU-6050: 0.35 rad/s)."""
FEWEST = 1000  #: samples. Derived: the noise density to 5 % and better


def sample_step_s(log: ImuLog) -> float:
    """The mean interval between samples.

    Returns
    -------
    float
        s.

    Raises
    ------
    Undetermined
        There are too few samples, or a gap between two of them.
    """
    if len(log.time_s) < FEWEST:
        raise Undetermined(
            f"{log.label}: {len(log.time_s)} samples; at least {FEWEST} are expected for "
            f"a noise density. Record the sensor at rest: some minutes for the noise density, "
            f"hours for bias instability and random walk."
        )
    steps = np.diff(log.time_s)
    usual = float(np.median(steps))
    mean = float(steps.mean())
    limit = max(GAP_S, GAP_STEPS * max(usual, mean))
    gaps = np.flatnonzero(steps > limit)
    if gaps.size:
        edges = np.concatenate([[0], gaps + 1, [len(log.time_s)]])
        longest = int(np.argmax(np.diff(edges)))
        start, stop = log.time_s[edges[longest]], log.time_s[edges[longest + 1] - 1]
        worst = int(gaps[np.argmax(steps[gaps])])
        raise Undetermined(
            f"{log.label}: {gaps.size} gap{'s' if gaps.size > 1 else ''} between samples, the "
            f"longest {steps[worst]:.3g} s at {log.time_s[worst]:.6g} s, where one sample in "
            f"{mean:.3g} s is expected. An Allan deviation needs evenly spaced samples. Cut the "
            f"log to its longest part without a gap, {start:.6g} to {stop:.6g} s, or record it "
            f"again."
        )
    return mean


def require_still(log: ImuLog, triad: Triad, readings: FloatArray, step_s: float) -> None:
    """Refuse a log in which the sensor moved.

    Parameters
    ----------
    log : ImuLog
        For its label and times.
    triad : str
    readings : array, shape (t, 3)
        SI units.
    step_s : float

    Raises
    ------
    Undetermined
        It turned, was touched or tilted, or an axis is stuck.
    """
    length = max(FEWEST_IN_WINDOW, round(WINDOW_S / step_s))
    count = len(readings) // length
    windows = readings[: count * length].reshape(count, length, 3)
    means, variances = windows.mean(axis=1), windows.var(axis=1)
    if triad == "gyroscope" and np.median(
            np.linalg.norm(means, axis=1)) > LARGEST_RATE_RAD_S:
        raise Undetermined(f"{log.label}: the gyroscope turns at "
                          f"{np.rad2deg(np.median(np.linalg.norm(means, axis=1))):.3g} °/s. Record "
                          f"the sensor at rest.")
    for axis, name in enumerate(AXES):
        if np.ptp(readings[:, axis]) == 0:
            raise Undetermined(f"{log.label}: the {triad} {name} reads the same in every sample, "
                              f"which is no noise. Is the axis stuck, or its unit too coarse?")
        moved = _moved(means[:, axis], variances[:, axis])
        if moved is not None:
            at = float(log.time_s[moved * length] - log.time_s[0])
            raise Undetermined(
                f"{log.label}: the sensor was not still: the {triad} {name} moves after {at:.6g} "
                f"s, beyond its own noise. Cut the log to its still part, or record it again on a "
                f"firm support that nobody touches."
            )


def _moved(means: FloatArray, variances: FloatArray) -> int | None:
    """The first window with a movement; None without one."""
    usual = float(np.median(variances))
    loud = variances > LOUDER * usual if usual > 0 else np.zeros(len(means), bool)
    steps = np.abs(np.diff(means))
    robust = float(np.median(steps)) / MEDIAN_OF_NORMAL
    jumps = np.concatenate([[False], steps > JUMP * robust]) if robust > 0 else loud
    wrong = np.flatnonzero(loud | jumps)
    return int(wrong[0]) if wrong.size else None
