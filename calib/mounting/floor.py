"""The slope of the floor, separated from the mounting by a second log at the reverse heading.

One still log measures both together. Turned by 180°, the vehicle keeps its mounting and the floor's
slope changes its sign in the vehicle's axes: the mean of both readings is the mounting's, half of
their difference the floor's.
"""

import math
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.mounting.heading import Yaw
from calib.poses.imu_log import FloatArray

STEEPEST_FLOOR_RAD = math.radians(15.0)
REVERSAL_SD_RAD = math.radians(3.0)
"""How well a vehicle is turned round by eye; an error ε leaves ε/2 of the slope, sideways."""


@dataclass(frozen=True, eq=False)
class Slope:
    """The floor's rise along the vehicle's x and y at the first heading, and its sd, each (2,).

    Without a yaw from a drive, x and y are the axes that a yaw of zero gives.
    """

    rise_rad: FloatArray
    sd_rad: FloatArray


def turned_short(label: str, forces: FloatArray, up: FloatArray) -> FloatArray:
    """Covariance (3, 3) of the mean of both headings by a turn that is not quite 180°.

    Parameters
    ----------
    label : str
        What messages call the second log.
    forces : array, shape (2, 3)
        Calibrated mean readings of both headings in the sensor's axes, m/s².
    up : array, shape (3,)
        Their mean.

    Raises
    ------
    Undetermined
        The floor would have to be steeper than any: the logs are not of one place.
    """
    first, second = forces / np.linalg.norm(forces, axis=1, keepdims=True)
    # Half the angle between two unit vectors; exact also where they nearly agree.
    tilt = math.atan2(float(np.linalg.norm(first - second)), float(np.linalg.norm(first + second)))
    if tilt > STEEPEST_FLOOR_RAD:
        raise Undetermined(
            f"{label}: between the two headings the plumb line turns by "
            f"{math.degrees(2 * tilt):.1f}° in the sensor, as on a floor that slopes by "
            f"{math.degrees(tilt):.1f}°; up to {math.degrees(STEEPEST_FLOOR_RAD):g}° is accepted. "
            f"The sensor was remounted, or the logs are of different places; record both headings "
            f"at one place without touching the sensor."
        )
    sloping = (forces[0] - forces[1]) / 2
    short = np.cross(up / np.linalg.norm(up), sloping) * REVERSAL_SD_RAD / 2
    return np.outer(short, short)


def floor_slope(forces: FloatArray, noise: FloatArray, yaw: Yaw | None) -> Slope:
    """The floor's rise from the readings (2, 3) of both headings in the vehicle's axes, m/s².

    ``noise`` (3, 3) is the covariance of their sum.
    """
    gravity = float(np.linalg.norm(forces, axis=1).mean())
    rise = (forces[0] - forces[1])[:2] / (2 * gravity)
    sideways = np.array([-rise[1], rise[0]])
    turned = (REVERSAL_SD_RAD / 2) ** 2 + (yaw.sd_rad**2 if yaw else 0.0)
    cov = noise[:2, :2] / (2 * gravity) ** 2 + turned * np.outer(sideways, sideways)
    return Slope(rise, np.sqrt(np.diag(cov)))
