"""Test whether a log is fit for an Allan deviation: evenly sampled, without gaps, and still."""

from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import AXES, FloatArray, ImuLog, Triad


@dataclass(frozen=True)
class StillnessThresholds:
    """Limits for refusing a log; half and double of each: ``tests.bench.stillness_thresholds``.

    Attributes
    ----------
    gap_s, gap_steps : float
        An interval longer than both, s and usual steps, is a gap. Tuned: shorter ones are how a
        serial port delivers samples in bursts.
    window_s : float
        Of the means and variances that show a movement, s: as long as a touch.
    fewest_in_window : int
        Samples; derived: the sd of a variance is a third of it.
    jump : float
        Of the difference of neighbouring windows' means, robust sds. Derived: Gaussian noise has 6
        in a billion windows; what wanders has more.
    louder : float
        Variance of a window over the median one. Derived: as ``jump``.
    turning_rad_s : float
        Fact: more is no bias of a low-cost gyroscope at rest (MPU-6050: 0.35 rad/s).
    fewest : int
        Samples. Derived: the noise density to 5 % and better.
    """

    gap_s: float = 0.25
    gap_steps: float = 5.0
    window_s: float = 1.0
    fewest_in_window: int = 20
    jump: float = 10.0
    louder: float = 10.0
    turning_rad_s: float = 0.5
    fewest: int = 1000


STILLNESS = StillnessThresholds()


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
    if len(log.time_s) < STILLNESS.fewest:
        raise Undetermined(
            f"{log.label}: {len(log.time_s)} samples; at least {STILLNESS.fewest} are expected for "
            f"a noise density. Record the sensor at rest: some minutes for the noise density, "
            f"hours for bias instability and random walk."
        )
    steps = np.diff(log.time_s)
    usual = float(np.median(steps))
    mean = float(steps.mean())
    limit = max(STILLNESS.gap_s, STILLNESS.gap_steps * max(usual, mean))
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
    length = max(STILLNESS.fewest_in_window, round(STILLNESS.window_s / step_s))
    count = len(readings) // length
    windows = readings[: count * length].reshape(count, length, 3)
    means, variances = windows.mean(axis=1), windows.var(axis=1)
    if triad == "gyroscope" and np.median(
            np.linalg.norm(means, axis=1)) > STILLNESS.turning_rad_s:
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
    loud = variances > STILLNESS.louder * usual if usual > 0 else np.zeros(len(means), bool)
    steps = np.abs(np.diff(means))
    robust = float(np.median(steps)) / MEDIAN_OF_NORMAL
    jumps = np.concatenate([[False], steps > STILLNESS.jump * robust]) if robust > 0 else loud
    wrong = np.flatnonzero(loud | jumps)
    return int(wrong[0]) if wrong.size else None
