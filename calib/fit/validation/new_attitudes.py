"""Expected error of a fit away from its poses: in all directions, magnitudes and times.

    E² = s² <g cov gᵀ> + (s² - 1) <σ²>

s² is the scatter of left-out poses about their predictions, in the sds of these; <σ²> the mean
variance of a magnitude: a misfit at the poses is also a misfit elsewhere. <g cov gᵀ> is the
variance by the parameters, averaged over all directions and magnitudes under the conditions of
every pose, without the errors that the references have in common. Left-out poses lie where poses
are: if few of them determine an effect that is applied to others, this term grows.
"""

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.fit.small_systems import inverse_square
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.leave_one_out import compare
from calib.fit.validation.prediction import distinct, gradient_of, imagined
from calib.poses.attitudes import spread_directions
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
    whitened = fit.rows.jacobian @ fit.directions * np.sqrt(fit.weight)[:, None]
    gradient = gradient_of(fit, elsewhere) @ fit.directions[: fit.model.size]
    by_row = gradient @ inverse_square(whitened) @ whitened[: fit.equations.data_count].T
    return missed + scatter * float((by_row**2).sum(axis=1).mean())


def mean_square_apart(one: TriadCalibration, other: TriadCalibration) -> float:
    """Mean square difference of the magnitudes that both fits correct in new attitudes, SI."""
    elsewhere = new_attitudes(one.fit.poses)
    if elsewhere is None:
        return 0.0
    at = elsewhere.conditions(elsewhere.reading)
    sizes = [np.linalg.norm(each.correct(at), axis=1) for each in (one, other)]
    return float(np.mean((sizes[0] - sizes[1]) ** 2))
