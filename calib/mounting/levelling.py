"""Roll and pitch of a still sensor (Promrit et al.), and the slope of the floor under it.

``In-Vehicle MEMS IMU Calibration Using Accelerometer`` writes R for the matrix that takes a vector
from the vehicle's axes to the sensor's axes, ``G = R (0, 0, 1)``; eq. (1)-(3) turn the axes, not
the vector (its remark that they turn the vector counter-clockwise is a slip: with eq. (3),
``R_z(90°) (1, 0, 0) = (0, -1, 0)``, as its own figure 2 computes). The reading of a mounted sensor
is therefore transformed to the vehicle's axes with the transpose, ``Rᵀ``.

The paper's tan⁻¹ is the quadrant-aware arc tangent here, so that every mounting, also upside down,
has its angles.

A slope of the floor keeps its direction in the world, so it changes sign in the vehicle when the
vehicle is turned round; the mounting does not. Half the sum of the two readings is the mounting,
half their difference the floor.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from calib.errors import Undetermined
from calib.mounting.heading import Yaw
from calib.mounting.still_reading import StillReading
from calib.poses.imu_log import FloatArray

Order = Literal["xyz", "yxz"]
ORDERS: tuple[Order, ...] = get_args(Order)


def mounting_rotation(
    order: Order, roll_rad: float, pitch_rad: float, yaw_rad: float = 0.0
) -> FloatArray:
    """Rotation ``R_xyz = R_x R_y R_z`` or ``R_yxz = R_y R_x R_z``, vehicle to sensor, (3, 3).

    ``R_x(φ)``, ``R_y(θ)`` and ``R_z(ψ)`` of eq. (1)-(3) turn the axes and not the vector.
    """
    from scipy.spatial.transform import Rotation  # few sessions measure a mounting

    angles = (roll_rad, pitch_rad) if order == "xyz" else (pitch_rad, roll_rad)
    return np.asarray(Rotation.from_euler(order, [*angles, yaw_rad]).inv().as_matrix())


def order_margins(g: FloatArray) -> dict[Order, float]:
    """Both sides of eq. (6), the smaller of which names the order.

    Parameters
    ----------
    g : array, shape (3,)
        Mean reading in units of local gravity.

    Examples
    --------
    >>> margins = order_margins(np.array([-0.2235, 0.4937, 0.8330]))
    >>> f"{margins['xyz']:.6f} {margins['yxz']:.6f}"
    '0.031688 0.137538'
    """
    x, y, z = g
    return {"xyz": abs(math.hypot(y, z) - 1), "yxz": abs(math.hypot(x, z) - 1)}


def rotation_order(g: FloatArray) -> Order:
    """The order of rotations by eq. (6), for ``g`` (3,) in units of local gravity.

    It takes the order whose second angle is the smaller, so the denominators of eq. (A)-(D) never
    fall below 0.7 of gravity, and no mounting is locked.
    """
    margins = order_margins(g)
    return "xyz" if margins["xyz"] < margins["yxz"] else "yxz"


def roll_pitch(g: FloatArray, order: Order) -> tuple[float, float]:
    """Roll φ and pitch θ in radians: eq. (A) and (B) for ``xyz``, (C) and (D) for ``yxz``.

    Parameters
    ----------
    g : array, shape (3,)
        Specific force along the sensor's axes, in any unit.

    Examples
    --------
    >>> roll, pitch = roll_pitch(np.array([-0.2235, 0.4937, 0.8330]), "xyz")
    >>> f"{math.degrees(roll):.4f} {math.degrees(pitch):.4f}"
    '30.6543 12.9971'
    """
    x, y, z = (float(value) for value in g)
    if order == "xyz":
        return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))
    return math.atan2(y, math.hypot(x, z)), math.atan2(-x, z)


def roll_pitch_jacobian(g: FloatArray, order: Order) -> FloatArray:
    """Derivatives of (φ, θ) with respect to ``g`` (3,), shape (2, 3), radians per unit of ``g``."""
    if order == "yxz":  # pitch and roll of the order xyz, of (-y, -x, z)
        exchanged = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(roll_pitch_jacobian(exchanged @ g, "xyz")[::-1] @ exchanged)
    x, y, z = g
    r = np.hypot(y, z)
    of_roll = np.array([0.0, z, -y]) / r**2
    of_pitch = np.array([-r, x * y / r, x * z / r]) / (g @ g)
    return np.stack([of_roll, of_pitch])


STEEPEST_FLOOR_RAD = math.radians(15.0)  #: rad, 27 %; ramps of garages have up to 20 %; fact
REVERSAL_SD_RAD = math.radians(3.0)
"""Error of turning a vehicle round by eye, rad; an error ε leaves ε/2 of the slope, sideways. A
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
    """The calibrated mean reading at each heading, and the upward direction on a level floor.

    ``forces`` (h, 3) and ``noise`` (h, 3, 3), their covariance by noise alone; ``up`` (3,) the mean
    over the headings and its covariance ``cov`` (3, 3), the calibration's included.
    """

    readings: Sequence[StillReading]
    forces: FloatArray
    noise: FloatArray
    up: FloatArray
    cov: FloatArray


def turned_short_covariance(upright: HeadingForces) -> FloatArray:
    """Covariance (3, 3) of the mean of both headings due to a turn that is not exactly 180°."""
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
