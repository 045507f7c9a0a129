"""The calibrated mean of a still, mounted accelerometer and what its calibration leaves uncertain.

A log in which the vehicle moved is refused (:func:`calib.poses.averaging.average_pose`) where its
halves differ by more than 0.1°; one that settles by less is neither noticed nor in the sd.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.errors import Remedy, Undetermined
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.correction import Correction
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.mean_noise import variance_by_steps, variance_of_mean
from calib.poses.checks.pose_checks import LARGEST_STILL_SHIFT
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.runs.reference_runs import TURNING_RAD_S

LARGEST_OFFSET_RAD_S = 0.35
"""20 °/s. Fact: the largest zero-rate output of the MPU-6050's product specification."""

SAME_PLACE_M_S2 = LARGEST_STILL_SHIFT["accelerometer"]
"""Within which still logs of one mounting agree. Derived: as much as one of them may stray."""

SAME_PLACE_SD = 6.0
"""Or within so many sds of their noise. Derived: four where those of a log of 3 s are short by 30 %
(``tests/bench/study_installation.py``: 83 % lie within what 95 % should)."""


@dataclass(frozen=True, eq=False)
class StillReading:
    """Mean nominal reading of one or several still logs, before any calibration.

    Parameters
    ----------
    label : str
        What messages call it.
    at : Conditions
        One row: the mean reading in nominal m/s² and the means of the logged columns.
    variance : array, shape (3,)
        Variance of that mean by the sensor's own noise, nominal (m/s²)².
    samples : int
    longest_s : float
        Length of the longest of the logs.
    """

    label: str
    at: Conditions
    variance: FloatArray
    samples: int
    longest_s: float


def log_conditions(log: ImuLog, nominal: FloatArray, end_s: float) -> Conditions:
    """Conditions of effects for every sample of a log of another time than the calibration.

    As where a log is corrected, it is quiet, no pose is before it, and it is at the end ``end_s``
    of the session.
    """
    return Conditions.of_vectors(nominal, log.columns, force=nominal).as_in_a_log(end_s)


def require_at_rest(
    logs: Sequence[ImuLog], gyroscope: TriadSpec, reading_at_rest: FloatArray | None
) -> None:
    """Refuse still logs in which the gyroscope turned, which gravity alone need not show.

    Parameters
    ----------
    logs : sequence of ImuLog
    gyroscope : TriadSpec
    reading_at_rest : array, shape (3,), or None
        Its nominal reading at rest, rad/s; None where it is known by the data sheet only.

    Raises
    ------
    Undetermined
        Naming the log and the rate.
    """
    offset, limit = np.zeros(3), LARGEST_OFFSET_RAD_S
    if reading_at_rest is not None:
        offset, limit = reading_at_rest, TURNING_RAD_S
    for log in logs:
        if not log.has("gyroscope"):
            continue
        rate = float(np.linalg.norm(gyroscope.nominal(log.gyroscope).mean(axis=0) - offset))
        if rate > limit:
            raise Undetermined(
                f"{log.label}: the sensor was turning: its gyroscope reads {np.degrees(rate):.0f} "
                f"°/s more than at rest (up to {np.degrees(limit):.0f} °/s is accepted). Record "
                f"the mounted sensor with the vehicle standing still."
            )


def still_reading(logs: Sequence[ImuLog], accelerometer: TriadCalibration) -> StillReading:
    """Average the still logs of one mounting, each counted by its number of samples.

    Raises
    ------
    Undetermined
        No log, the sensor moved, saturated, the logs do not agree, or the calibration has effects
        that they cannot evaluate.
    UnusableLog
        Counts outside what the converter can give.
    """
    if not logs:
        raise Undetermined(
            "installation: no still log was found. Record the mounted sensor for half a minute "
            "with the vehicle standing still."
        )
    parts = [_one_log(log, accelerometer) for log in logs]
    counts = np.array([part.samples for part in parts])
    share = counts / counts.sum()
    means = np.concatenate([part.at.vector for part in parts])  # (l, 3)
    mean = share @ means
    variances = np.array([part.variance for part in parts])
    allowed = np.maximum(SAME_PLACE_M_S2, SAME_PLACE_SD * np.sqrt(variances + share**2 @ variances))
    excess = np.abs(means - mean) / allowed
    if excess.max() > 1:
        worst = int(np.argmax(excess.max(axis=1)))
        apart = float(np.linalg.norm(means[worst] - mean))
        raise Undetermined(
            f"{parts[worst].label}: this still log differs by {apart:.3g} m/s² from the mean of "
            f"the {len(parts)} still logs of the installation, where logs of one mounting at one "
            f"place agree within {float(allowed[worst].min()):.2g} m/s². The sensor or the vehicle "
            f"was moved between them; give the logs of one place only."
        )
    columns = {
        name: np.array([share @ np.array([part.at.columns[name][0] for part in parts])])
        for name in parts[0].at.columns
        if all(name in part.at.columns for part in parts)
    }
    at = replace(
        parts[0].at,
        vector=mean[None],
        force=mean[None],
        columns=columns,
    )
    label = parts[0].label if len(parts) == 1 else f"{parts[0].label} and {len(parts) - 1} more"
    require_evaluable(label, at, accelerometer.correction)
    longest_s = max(part.longest_s for part in parts)
    return StillReading(label, at, share**2 @ variances, int(counts.sum()), longest_s)


def _one_log(log: ImuLog, accelerometer: TriadCalibration) -> StillReading:
    if not log.has("accelerometer"):
        raise Undetermined(
            f"{log.label}: has no accelerometer columns; acc_x, acc_y, acc_z are needed to find "
            f"how the sensor is mounted."
        )
    # It refuses what moved or is saturated.
    mean = average_pose(log, {"accelerometer": accelerometer.spec})
    nominal = accelerometer.spec.nominal(log.accelerometer)
    at = log_conditions(log, nominal, accelerometer.end_s)
    reading = mean.accelerometer.mean[None]
    columns = {name: np.array([value]) for name, value in mean.columns.items()}
    row = replace(at.take([0]), vector=reading, force=reading, columns=columns)
    averaged = mean.accelerometer
    variance = variance_of_mean(nominal) + variance_by_steps([averaged])
    return StillReading(log.label, row, variance, len(nominal), mean.duration_s)


def require_evaluable(label: str, at: Conditions, accelerometer: Correction) -> None:
    """Refuse a log that lacks what the calibration's effects depend on."""
    lost = accelerometer.not_evaluable(at)
    if lost:
        raise Undetermined(
            f"{label}: the accelerometer's model has {', '.join(lost)}, which this log cannot "
            f"evaluate: the column is not in it, or the times of the calibration session are not "
            f"known. Log the column, or calibrate without that effect.",
            Remedy("remove_effect", "accelerometer"),
        )


def noise_covariance(reading: StillReading, accelerometer: Correction) -> FloatArray:
    """Covariance of the corrected mean by the sensor's noise alone, (m/s²)², shape (3, 3)."""
    matrix, _ = accelerometer.linear_form()  # added effects change it by a per cent
    return np.asarray(matrix * reading.variance @ matrix.T)
