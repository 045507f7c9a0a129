"""The accelerometer of a calibration in other poses: those of the gyroscope beside it."""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from calib.fit.triad.calibration import TriadCalibration
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.past import past_columns
from calib.poses.pose_set import PoseSet


def correct_other_poses(calibration: TriadCalibration) -> Callable[[Conditions], FloatArray]:
    """The specific force (n, 3) in other poses, for :func:`calib.poses.pose_set.pose_set`.

    A column that these poses lack takes its mean over the poses of the calibration, so that the
    correction is that of a typical pose. An effect that needs more than columns is left out.
    """

    def correct(at: Conditions) -> FloatArray:
        at = _with(at, _typical_columns(calibration, at))
        correction = calibration.correction
        return correction.without(correction.not_evaluable(at)).correct(at)

    return correct


def with_typical_columns(calibration: TriadCalibration, poses: PoseSet) -> PoseSet:
    """The poses with the columns that the calibration needs and they lack, at their means."""
    return replace(poses, columns={**poses.columns, **_typical_columns(
        calibration, poses.accelerometer_conditions(poses.force))})


def missing_in(calibration: TriadCalibration, poses: PoseSet) -> dict[str, str]:
    """The effects of the accelerometer that these poses cannot evaluate, with their reasons."""
    at = poses.accelerometer_conditions(poses.force)
    return calibration.correction.not_evaluable(_with(at, _past(calibration, at)))


def _typical_columns(calibration: TriadCalibration, at: Conditions) -> dict[str, FloatArray]:
    """Means of the missing columns, and what follows from the past of all, (n,)."""
    effects = calibration.fit.model.effects
    logged = _means(calibration, at, {name for effect in effects for name in effect.logged})
    past = _past(calibration, _with(at, logged))
    names = {past.name for effect in effects for past in effect.pasts}
    return {**logged, **past, **_means(calibration, _with(at, past), names)}


def _means(
    calibration: TriadCalibration, at: Conditions, names: Collection[str]
) -> dict[str, FloatArray]:
    """Means of those of ``names`` that are missing, (n,)."""
    known = calibration.fit.poses.columns
    return {name: np.full(len(at.vector), known[name].mean()) for name in sorted(names)
            if name in known and not np.isfinite(at.column(name)).all()}


def _past(calibration: TriadCalibration, at: Conditions) -> dict[str, FloatArray]:
    """Columns computed from the past, to which the poses of the calibration belong too, (n,)."""
    poses = calibration.fit.poses
    columns = {name: np.concatenate([poses.columns[name], column])
               for name, column in at.columns.items() if name in poses.columns}
    whole = past_columns(columns, np.concatenate([poses.time_s, at.time_s]), [
        past for effect in calibration.fit.model.effects for past in effect.pasts])
    return {name: column[len(poses):] for name, column in whole.items()
            if np.isfinite(column).all()}


def _with(at: Conditions, columns: dict[str, FloatArray]) -> Conditions:
    return replace(at, columns={**at.columns, **columns})
