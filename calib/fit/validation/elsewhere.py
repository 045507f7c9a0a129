"""Errors away from the poses of a fit: in all directions, at a pose left out, by a missing effect.

**In all directions, magnitudes and times** the expected square error of a magnitude is

    E² = s² <g cov gᵀ> + (s² - 1) <σ²>

s² is the scatter of left-out poses about their predictions, in the sds of these; <σ²> the mean
variance of a magnitude: a misfit at the poses is also a misfit elsewhere. <g cov gᵀ> is the
variance by the parameters, averaged over all directions and magnitudes under the conditions of
every pose, without the errors that the references have in common. Left-out poses lie where poses
are: if few of them determine an effect that is applied to others, this term grows.

**By an effect that is missing**: with parameters t the magnitude of a true vector along n errs by
``n · C t + g · A t``: the effect on the reading there, and, through the gradient g of the corrected
magnitude, the part of it (A) that the parameters absorbed in the calibration. The next log has
gravity in any direction, whatever the rate; so the square is averaged over those.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.linear import inverse_square
from calib.fit.rows.residuals import Equations
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.leave_one_out import PoseResidual, compare, pose_errors, pose_sds
from calib.fit.validation.prediction import (
    Prediction,
    distinct,
    effects_along,
    gradient_of,
    imagined,
    other_logs,
)
from calib.poses.attitudes import spread_directions
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

ATTITUDES = 300
"""Number of attitudes that represent all, 12° apart. Numerical: the averaged function is smooth."""

def new_attitudes(poses: PoseSet) -> PoseSet | None:
    """Poses in every direction, each at some magnitude and the conditions of one of ``poses``.

    None if all poses were at rest.
    """
    turning = poses.reference.magnitude[poses.reference.magnitude > 0]
    if turning.size == 0:
        return None
    drawn = np.random.default_rng(0)
    directions = spread_directions(ATTITUDES)
    size = drawn.choice(distinct(turning), (ATTITUDES, 1))
    return imagined(poses, size * directions, up=drawn.permutation(directions),
                    like=drawn.integers(len(poses), size=ATTITUDES))


def mean_square_error(fit: Fit) -> float:
    """Expected mean square error of a magnitude that ``fit`` corrects in new attitudes, SI."""
    scatter, elsewhere = compare(fit).scatter, new_attitudes(fit.poses)
    if elsewhere is None:
        return (scatter - 1) * float(np.mean(fit.equations.row_sd**2))
    missed = (scatter - 1) * float(np.mean(fit.equations.magnitude_sd**2))
    whitened = fit.weighted_jacobian
    gradient = gradient_of(fit, elsewhere) @ fit.directions[: fit.model.size]
    by_row = gradient @ inverse_square(whitened) @ whitened[: fit.equations.data_count].T
    return missed + scatter * float((by_row**2).sum(axis=1).mean())


def mean_square_apart(one: TriadCalibration, other: TriadCalibration) -> float:
    """Mean square difference of the magnitudes that both fits correct in new attitudes, SI."""
    elsewhere = new_attitudes(one.fit.poses)
    if elsewhere is None:
        return 0.0
    return float(squares_apart(one, other, elsewhere.conditions(elsewhere.reading)).mean())


def squares_apart(
    one: TriadCalibration, other: TriadCalibration, at: Conditions
) -> FloatArray:
    """Square of the difference of the magnitudes that both correct in conditions (n), SI, (n,).

    Raises
    ------
    FitFailed
        The effects of one are larger than the readings.
    """
    sizes = [np.linalg.norm(each.correct(at), axis=1) for each in (one, other)]
    return np.asarray((sizes[0] - sizes[1]) ** 2)


@dataclass(frozen=True, eq=False)
class PredictedPose:
    """Comparison of one pose with a fit without it.

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
    """Prediction of the pose at ``place`` of ``poses`` by the parameters of ``fit``.

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
    value = float(pose_errors(equations, rows.residual)[place])
    of_pose = poses.take([place])
    return PredictedPose(of_pose, rows.vector[place], PoseResidual(
        of_pose.label[0], of_pose.run[0], value, float(pose_sds(equations)[place]), value))


def error_by_missing(
    calibration: TriadCalibration, prediction: Prediction, effect: Effect, absorbed: FloatArray,
    root: FloatArray, shape: float | None = None,
) -> FloatArray:
    """Mean square error of a corrected magnitude by an effect that the model lacks, SI.

    Parameters
    ----------
    calibration : TriadCalibration
        Of p parameters.
    prediction : Prediction
        Of that calibration.
    effect : Effect
        One of another owner than the sensor acts through the parameters alone: the next log is of
        another session and another bench.
    absorbed : array, shape (p, k)
        What the parameters hold of it, per unit of each of its k parameters.
    root : array, shape (k, j)
        A square root of the mean of ``t tᵀ``, t its parameters.
    shape : float or None
        Value of its shape parameter; None for the usual one.

    Returns
    -------
    array, shape (m, d)
    """
    by_parameters = prediction.gradient @ absorbed @ root  # (m, d, j)
    if effect.belongs_to != "sensor" or effect.acts_on == "reference":
        return np.asarray((by_parameters**2).sum(axis=2))
    shapes = {} if shape is None else {effect.name: shape}
    logs = other_logs if "force" in effect.needs else imagined
    squares = []
    for size, held in zip(prediction.magnitude, by_parameters, strict=True):
        at = logs(calibration.fit.poses, size * prediction.directions)
        at_once = effects_along(calibration, (effect,), at, shapes) @ root
        squares.append(((at_once.reshape(-1, *held.shape) + held) ** 2).sum(axis=2).mean(axis=0))
    return np.array(squares)
