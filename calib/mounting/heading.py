"""The yaw of a mounting from a straight drive.

Roll and pitch leave one angle open, which gravity does not show. While a vehicle speeds up or
brakes on a straight road, the horizontal specific force lies along its x-axis: its principal
direction in the levelled frame is the x-axis up to the sign, which the user states. With
``R = R_order(φ, θ) R_z(ψ)``, a push a along x appears in the levelled frame as
``R_z(ψ) (a, 0) = (a cos ψ, -a sin ψ)``.

A constant (the road's slope, a residual bias) cancels with the mean. Noise of the same size along
and across does not turn the principal direction. Its sd is that of a jackknife: the change of the
direction when each stretch of the drive is left out, with l the component along the direction and t
the one across it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.errors import Undetermined
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.correction import Correction
from calib.mounting.still_reading import log_conditions, require_evaluable
from calib.poses.imu_log import FloatArray, ImuLog

FirstPush = Literal["forward", "backward"]

MEAN_S = 0.5
"""Averaging time of the readings, s: longer than engine and road vibration, shorter than a push. A
judgement."""

STRETCH_MEANS = 10
"""Means in one stretch of the jackknife: 5 s, as long as a push and several times as long as
lateral motion stays correlated. Derived: 2 s would cover 91 % where 95 % is stated."""

SHORTEST_DRIVE_S = 20.0
"""Time, s, to stand, drive off and stand again. Derived: four stretches of the jackknife."""

WEAKEST_PUSH_M_S2 = 0.3
"""Weakest push, m/s², rms along the strongest direction. A judgement: a floor sloping by 1.7° gives
it. Half and twice change none of the 7 cases of ``tests.calib.mounting.test_heading``.
"""

LARGEST_ACROSS = 0.35
"""Largest rms across relative to along. A judgement: a straight drive has its noise across, a drive
through bends comes near to 1."""

MARKED_SHARE = 0.3
"""Share of the strongest push that the first push reaches. A judgement: a road that slopes by two
degrees (0.34 m/s²) stays below it beside a push of 1.2 m/s²."""


@dataclass(frozen=True)
class Yaw:
    """Yaw ψ of eq. (3) and its sd in radians."""

    yaw_rad: float
    sd_rad: float


def measure_yaw(
    logs: Sequence[ImuLog],
    accelerometer: TriadCalibration,
    levelled: FloatArray,
    first_push: FirstPush = "forward",
) -> Yaw:
    """Yaw from the horizontal specific force of a drive.

    Parameters
    ----------
    logs : sequence of ImuLog
        Drives on straight roads, each beginning with a push in the direction ``first_push``.
    accelerometer : TriadCalibration
    levelled : array, shape (3, 3)
        R with the yaw zero.
    first_push : str
        ``forward`` (speeding up ahead) or ``backward`` (braking).

    Raises
    ------
    Undetermined
        Too short, no marked push, or no clear direction.
    """

    def pushes(by: Correction) -> list[FloatArray]:
        return [_horizontal(log, by, levelled, accelerometer.end_s) for log in logs]

    parts = pushes(accelerometer.correction)
    yaw = _yaw(parts, first_push)
    forward = np.array([math.cos(yaw), -math.sin(yaw)])
    across = np.array([-forward[1], forward[0]])
    along_rms = _rms([_centred(part) @ forward for part in parts])
    across_rms = _rms([_centred(part) @ across for part in parts])
    _refuse_unclear(logs[0].label, along_rms, across_rms)

    calibrated = accelerometer.covariance_of(
        lambda by: np.array([math.remainder(_yaw(pushes(by), first_push) - yaw, 2 * math.pi)]))
    variance = _jackknife_variance(parts, forward, across) + float(calibrated[0, 0])
    return Yaw(yaw, math.sqrt(variance))


def _horizontal(
    log: ImuLog, calibration: Correction, levelled: FloatArray, end_s: float
) -> FloatArray:
    """Horizontal specific force, averaged over MEAN_S, shape (b, 2)."""
    duration = float(log.time_s[-1] - log.time_s[0])
    if not log.has("accelerometer") or duration < SHORTEST_DRIVE_S:
        raise Undetermined(
            f"{log.label}: a drive of {duration:.1f} s with accelerometer readings "
            f"{'present' if log.has('accelerometer') else 'missing'}; at least "
            f"{SHORTEST_DRIVE_S:g} s with acc_x, acc_y, acc_z are needed. Log a whole drive from "
            f"standstill through speeding up and braking on a straight road."
        )
    at = log_conditions(log, calibration.spec.nominal(log.accelerometer), end_s)
    require_evaluable(log.label, at, calibration)
    force = calibration.correct(at)
    samples = max(1, round(MEAN_S * (len(force) - 1) / duration))
    count = len(force) // samples
    means = (force @ levelled)[: count * samples, :2].reshape(count, samples, 2).mean(axis=1)
    return np.asarray(means)


def _centred(part: FloatArray) -> FloatArray:
    return np.asarray(part - part.mean(axis=0))


def _yaw(parts: Sequence[FloatArray], first_push: FirstPush) -> float:
    """ψ from the principal direction, its sign by the first marked push of the first drive."""
    moment = sum((_centred(part).T @ _centred(part) for part in parts), np.zeros((2, 2)))
    direction = np.linalg.eigh(moment)[1][:, -1]  # eigenvalues in ascending order
    push = parts[0] @ direction  # not centred: only the road's slope at standstill
    first = push[np.abs(push) >= MARKED_SHARE * np.abs(push).max()][0]
    if (first > 0) != (first_push == "forward"):
        direction = -direction
    return math.atan2(-direction[1], direction[0])


def _rms(parts: Sequence[FloatArray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(list(parts)) ** 2)))


def _jackknife_variance(
    parts: Sequence[FloatArray], forward: FloatArray, across: FloatArray
) -> float:
    """Variance of the direction: leaving out a stretch moves it by ``Σ l t / Σ l²``.

    The first sum is over the stretch, the second over the others. Student's factor accounts for the
    few stretches that contain most of the push; it is finite from three degrees of freedom on.
    """
    scores, weights = [], []
    for part in parts:
        along, aside = _centred(part) @ forward, _centred(part) @ across
        whole = len(along) // STRETCH_MEANS * STRETCH_MEANS
        scores.append((along * aside)[:whole].reshape(-1, STRETCH_MEANS).sum(axis=1))
        weights.append((along**2)[:whole].reshape(-1, STRETCH_MEANS).sum(axis=1))
    score, weight = np.concatenate(scores), np.concatenate(weights)
    moved = score / (weight.sum() - weight)
    dof = max(float(weight.sum() ** 2 / (weight**2).sum()) - 1, 3.0)
    return float(moved @ moved) * dof / (dof - 2)


def _refuse_unclear(label: str, along: float, across: float) -> None:
    if along >= WEAKEST_PUSH_M_S2 and across <= LARGEST_ACROSS * along:
        return
    measured = f"{along:.2f} m/s² along the strongest direction and {across:.2f} m/s² across it"
    raise Undetermined(
        f"{label}: the horizontal specific force of the drive has an rms of {measured}; at least "
        f"{WEAKEST_PUSH_M_S2:g} m/s² along and at most {100 * LARGEST_ACROSS:g} % of it across are "
        f"needed to determine the yaw. Cut the log to a straight stretch with marked acceleration "
        f"and braking, without bends."
    )
