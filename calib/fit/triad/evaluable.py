"""Correction by a calibrated accelerometer in poses that lack conditions its model needs.

A column that these poses lack takes its mean over the poses of the calibration, so that the
correction is that of a typical pose. An effect that needs more than columns is left out.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from calib.fit.triad.calibration import TriadCalibration
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


def correct_other_poses(calibration: TriadCalibration) -> Callable[[Conditions], FloatArray]:
    """The specific force (n, 3) in other poses, for :func:`calib.poses.pose_set.pose_set`."""

    def correct(at: Conditions) -> FloatArray:
        at = replace(at, columns={**at.columns, **_typical_columns(calibration, at)})
        correction = calibration.correction
        return correction.without(correction.not_evaluable(at)).correct(at)

    return correct


def with_typical_columns(calibration: TriadCalibration, poses: PoseSet) -> PoseSet:
    """The poses with the columns that the calibration needs and they lack, at their means."""
    return replace(poses, columns={**poses.columns, **_typical_columns(
        calibration, poses.accelerometer_conditions(poses.force))})


def missing_in(calibration: TriadCalibration, poses: PoseSet) -> dict[str, str]:
    """The effects of the accelerometer that these poses cannot evaluate, with their reasons."""
    return calibration.correction.not_evaluable(poses.accelerometer_conditions(poses.force))


def _typical_columns(calibration: TriadCalibration, at: Conditions) -> dict[str, FloatArray]:
    """Means of the missing columns, (n,)."""
    known = calibration.fit.poses.columns
    names = {name for effect in calibration.fit.model.effects for name in effect.logged}
    return {name: np.full(len(at.vector), known[name].mean()) for name in sorted(names)
            if name in known and not np.isfinite(at.column(name)).all()}
