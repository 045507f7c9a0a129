"""Kind of the session of the poses, as far as it decides the next measurement."""

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.poses.attitudes import natural_directions, uncovered
from calib.poses.imu_log import TEMPERATURE, FloatArray
from calib.poses.pose_set import PoseSet

FEW_ATTITUDES = 3
"""Natural directions within 25° of one attitude, at most: more are more than one attitude.
Derived."""

SAME_SPEED = 0.05
"""Relative: rates of one setting of a plate differ by less, its neighbours (16, 33, 45, 78) by
more. Fact."""

SWEEP_K = 5.0
"""A sensor warms itself by less while it is laid on its faces; a chamber is set to more.
A judgement."""

THROUGH_TEMPERATURES = (
    "the same attitude through the same temperatures once more, falling as well as rising"
)


def in_a_chamber(poses: PoseSet) -> bool:
    """Whether the sensor rested in one attitude while the temperature was swept.

    Poses in other attitudes are then another session, and time cannot be told from temperature by
    their order.
    """
    values = poses.columns.get(TEMPERATURE)
    if values is None or poses.spin_rad_s.any() or np.ptp(values) < SWEEP_K:
        return False
    up = _up(poses)
    if up is None:
        return False
    natural = natural_directions()
    return len(natural) - len(uncovered(up, natural)) <= FEW_ATTITUDES


def at_one_speed(poses: PoseSet) -> bool:
    """Whether a gyroscope turned at one speed and was never at rest.

    More such poses do not show the aliases of scale and misalignment at one speed.
    """
    if poses.triad != "gyroscope" or poses.reference.is_null.any():
        return False
    speed = np.abs(poses.spin_rad_s)
    return bool(speed.all() and np.ptp(speed) < SAME_SPEED * speed.min())


def attitudes_again(fit: Fit) -> FloatArray:
    """Unit vectors (n, 3), no unit, up in the poses of the first run: 18 at most, in their order.

    Faces and edges of a box where no pose has a length.
    """
    poses, wedge = fit.poses, natural_directions(corners=False)
    known = np.flatnonzero(~poses.reference.is_null)
    if not known.size:
        return wedge
    known = known[[poses.run[i] == poses.run[known[0]] for i in known]]
    most = min(len(known), len(wedge))
    known = known[np.linspace(0, len(known) - 1, most).round().astype(int)]
    vector = fit.rows.vector[known]
    sign = np.sign(poses.spin_rad_s[known])[:, None] if poses.triad == "gyroscope" else 1.0
    return np.asarray(sign * vector / np.linalg.norm(vector, axis=1, keepdims=True))


def _up(poses: PoseSet) -> FloatArray | None:
    """Direction up in every pose, in the sensor's axes (n, 3); None if it was not logged."""
    up = poses.reading if poses.triad == "accelerometer" else poses.force
    return up if np.isfinite(up).all() else None
