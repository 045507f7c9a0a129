"""The slope of the floor, from two still logs with opposite headings.

A floor that rises leans the same way in the world, so it changes sign in the vehicle when the
vehicle is turned round; the mounting does not. Half the sum of the two readings is the mounting,
half their difference the floor.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.mounting.heading import Yaw
from calib.mounting.still_reading import StillReading
from calib.poses.imu_log import FloatArray

STEEPEST_FLOOR_RAD = math.radians(15.0)  #: rad, 27 %; ramps of garages have up to 20 %; fact
REVERSAL_SD_RAD = math.radians(3.0)
"""How well a vehicle is turned round by eye; an error ε leaves ε/2 of the slope, sideways. A
judgement."""


@dataclass(frozen=True, eq=False)
class Slope:
    """The floor's rise along the vehicle's x and y at the first heading, and its sd, each (2,).

    Without a yaw from a drive, x and y are the axes that a yaw of zero gives.
    """

    rise_rad: FloatArray
    sd_rad: FloatArray


@dataclass(frozen=True, eq=False)
class HeadingForces:
    """The calibrated mean reading at each heading, and what is up on a level floor.

    ``forces`` (h, 3) and ``noise`` (h, 3, 3), their covariance by noise alone; ``up`` (3,) the mean
    over the headings and its covariance ``cov`` (3, 3), the calibration's included.
    """

    readings: Sequence[StillReading]
    forces: FloatArray
    noise: FloatArray
    up: FloatArray
    cov: FloatArray


def turned_short_covariance(upright: HeadingForces) -> FloatArray:
    """Covariance (3, 3) of the mean of both headings by a turn that is not quite 180°."""
    forces, up = upright.forces, upright.up
    first, second = forces / np.linalg.norm(forces, axis=1, keepdims=True)
    # Half the angle between two unit vectors; exact also where they nearly agree.
    tilt = math.atan2(float(np.linalg.norm(first - second)), float(np.linalg.norm(first + second)))
    if tilt > STEEPEST_FLOOR_RAD:
        raise Undetermined(
            f"{upright.readings[1].label}: between the two headings the plumb line turns by "
            f"{math.degrees(2 * tilt):.1f}° in the sensor, as on a floor that slopes by "
            f"{math.degrees(tilt):.1f}°; up to {math.degrees(STEEPEST_FLOOR_RAD):g}° is accepted. "
            f"The sensor was remounted, or the logs are of different places; record both headings "
            f"at one place without touching the sensor."
        )
    sloping = (forces[0] - forces[1]) / 2
    short = np.cross(up / np.linalg.norm(up), sloping) * REVERSAL_SD_RAD / 2
    return np.outer(short, short)


def floor_slope(upright: HeadingForces, rotation: FloatArray, yaw: Yaw | None) -> Slope:
    """The floor's rise from both headings, ``rotation`` (3, 3) from the vehicle to the sensor."""
    forces = upright.forces @ rotation
    noise = rotation.T @ upright.noise.sum(axis=0) @ rotation
    gravity = float(np.linalg.norm(forces, axis=1).mean())
    rise = (forces[0] - forces[1])[:2] / (2 * gravity)
    sideways = np.array([-rise[1], rise[0]])
    turned = (REVERSAL_SD_RAD / 2) ** 2 + (yaw.sd_rad**2 if yaw else 0.0)
    cov = noise[:2, :2] / (2 * gravity) ** 2 + turned * np.outer(sideways, sideways)
    return Slope(rise, np.sqrt(np.diag(cov)))
