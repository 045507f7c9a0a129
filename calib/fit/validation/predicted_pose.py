"""What a fit says of a pose that took no part in it."""

from dataclasses import dataclass, replace

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.fit.rows.residuals import Equations
from calib.fit.validation.leave_one_out import PoseResidual
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class PredictedPose:
    """One pose beside a fit without it.

    Parameters
    ----------
    poses : PoseSet
        This pose alone.
    vector : array, shape (3,)
        Its corrected vector, SI.
    residual : PoseResidual
        ``residual`` and ``left_out`` are the same: the error of the prediction.
    """

    poses: PoseSet
    vector: FloatArray
    residual: PoseResidual


def predict_pose(fit: Fit, poses: PoseSet, place: int) -> PredictedPose:
    """The pose at ``place`` of ``poses`` by the parameters of ``fit``.

    Parameters
    ----------
    fit : Fit
    poses : PoseSet
        The poses of the fit and more, under references with the same common errors.
    place : int
        Which of them.

    Returns
    -------
    PredictedPose
        Its sd is that of the pose; a pose whose sd is not known has a typical one of the fit.
    """
    typical = np.median(fit.poses.sd, axis=0)
    poses = replace(poses, sd=np.where(np.isfinite(poses.sd), poses.sd, typical))
    equations = Equations.of_sets((poses,), fit.model, fit.equations.start.take(None)).take(0)
    rows = equations.rows(fit.theta, fit.eta, fit.shapes)
    mine = np.flatnonzero(equations.row_pose == place)
    sd = equations.row_sd[mine]
    error = rows.residual[mine] * sd
    value = float(np.linalg.norm(error)) if equations.is_null[place] else float(error[0])
    of_pose = poses.take([place])
    return PredictedPose(of_pose, rows.vector[place], PoseResidual(
        of_pose.label[0], of_pose.run[0], value, float(np.linalg.norm(sd)), value))
