"""Roll and pitch of a still sensor (Promrit et al.).

``In-Vehicle MEMS IMU Calibration Using Accelerometer`` writes R for the matrix that takes a vector
given in the vehicle's axes to the sensor's axes, ``G = R (0, 0, 1)``; eq. (1)-(3) turn the axes,
not the vector (its remark that they turn the vector counter-clockwise is a slip: with eq. (3),
``R_z(90°) (1, 0, 0) = (0, -1, 0)``, as its own figure 2 computes). What a mounted sensor reads
therefore goes back to the vehicle's axes with the transpose, ``Rᵀ``.

The paper's tan⁻¹ is the quadrant-aware arc tangent here, so that every mounting, also upside down,
has its angles.
"""

import math
from typing import Literal, get_args

import numpy as np

from calib.poses.imu_log import FloatArray

Order = Literal["xyz", "yxz"]
ORDERS: tuple[Order, ...] = get_args(Order)


def mounting_rotation(order: Order, roll_rad: float, pitch_rad: float) -> FloatArray:
    """Rotation ``R_xyz = R_x R_y R_z`` or ``R_yxz = R_y R_x R_z``, vehicle to sensor, (3, 3).

    ``R_x(φ)``, ``R_y(θ)`` and ``R_z(ψ)`` of eq. (1)-(3) turn the axes and not the vector. ψ is
    zero: gravity does not show it.
    """
    from scipy.spatial.transform import Rotation  # few sessions measure a mounting

    angles = (roll_rad, pitch_rad) if order == "xyz" else (pitch_rad, roll_rad)
    return np.asarray(Rotation.from_euler(order, [*angles, 0.0]).inv().as_matrix())


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
    x, y, z = (float(value) for value in g)
    square = x * x + y * y + z * z
    if order == "xyz":
        r = math.hypot(y, z)
        of_roll = np.array([0.0, z, -y]) / r**2
        of_pitch = np.array([-r, x * y / r, x * z / r]) / square
    else:
        r = math.hypot(x, z)
        of_roll = np.array([-x * y / r, r, -y * z / r]) / square
        of_pitch = np.array([-z, 0.0, x]) / r**2
    return np.stack([of_roll, of_pitch])
