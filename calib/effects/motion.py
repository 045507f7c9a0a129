"""Effects of specific force and rotation on a triad that should not sense them."""

import numpy as np

from calib.earth import EARTH_RATE_RAD_S, STANDARD_GRAVITY_M_S2
from calib.effects.effect import Page, effect, per_axis
from calib.effects.typical import between, quoted, typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray

LARGEST_G_SENSITIVITY = np.radians(3.0) / STANDARD_GRAVITY_M_S2
"""3 °/s per g, in (rad/s)/(m/s²). Fact: thirty times the MPU-6050's 0.1, fifteen times the 0.2 that
data sheets of yaw-rate gyroscopes with an analogue output state."""


@effect(
    *(f"{k}{j}" for k in "xyz" for j in "xyz"),
    unit="(rad/s)/(m/s²)",
    needs=("force",),
    only_for=("gyroscope",),
    largest=LARGEST_G_SENSITIVITY,
    page=Page(
        formula="e_k = Σ_j G_kj · f_j",
        expressions=("fx", "fy", "fz"),
        typical={
            "MPU-6050": typical(quoted(0.1, "°/s/g")),
            "MTi": typical(quoted(0.003, "°/s/g"), note="after the factory"),
        },
        source="IEEE Std 1431 acceleration-sensitive drift rate; Kalibr A",
        confounded="scale and misalignment exactly at one speed on a level plate, where gravity "
        "is parallel to the rate; on one that leans, a motor's field that stays in the room",
        separates="plate-stopped poses determine all nine elements; a plate tilted by 9° nearly "
        "so, its isotropic part less well, which looks like scale and like a rate fixed in the "
        "room; a second speed or the other direction determines six of the nine",
    ),
)
def g_sensitivity(at: Conditions) -> FloatArray:
    """Gyro output caused by specific force: the proof mass sags."""
    columns = np.zeros((len(at.vector), 3, 9))
    for k in range(3):
        columns[:, k, 3 * k : 3 * k + 3] = at.force
    return columns


@effect(
    *AXES,
    unit="(rad/s)/(m/s²)²",
    needs=("force",),
    only_for=("gyroscope",),
    page=Page(
        formula="e_k = h_k · f_k²",
        expressions=("f**2",),
        typical={
            "MPU-6050": typical(between(0.01, 0.05, "°/s/g²")),
            "MTi": typical(note="lower"),
        },
        source="IEEE Std 528 acceleration-squared-sensitive drift rate",
        confounded="quadratic exactly at one speed, in one and in both directions",
        separates="a second speed, plate-stopped poses",
    ),
)
def g_squared_sensitivity(at: Conditions) -> FloatArray:
    """Gyro output that follows the square of specific force, whatever its sign."""
    return per_axis(at.force**2)


@effect(
    *AXES,
    unit="m",
    needs=("plate",),
    belongs_to="bench",
    orthogonal=True,
    in_square=True,
    only_for=("accelerometer",),
    page=Page(
        formula="e = Ω² (u (u·r) − r),  u the axis of the plate",
        typical={
            "on a record player": typical(
                between(13, 100, "mm"), note="off the spindle, which keeps a board beside it"),
        },
        source="centripetal acceleration",
        confounded="nothing in still poses: it is not there",
        separates="accelerometer logged on the plate at two speeds",
    ),
)
def lever_arm(at: Conditions) -> FloatArray:
    """Centripetal acceleration of a sensor that turns r away from the axis of the plate."""
    up = at.vector / np.linalg.norm(at.vector, axis=1, keepdims=True)
    spin_squared = at.spin_rad_s**2
    projector = up[:, :, None] * up[:, None, :] - np.eye(3)
    return np.asarray(spin_squared[:, None, None] * projector)


@effect(
    "vertical",
    unit="rad/s",
    needs=("force",),
    belongs_to="bench",
    orthogonal=True,
    only_for=("gyroscope",),
    largest=EARTH_RATE_RAD_S,
    page=Page(
        formula="e = w · u,  u = f/|f|",
        typical={"everywhere": typical(between(6, 15, "°/h"), note="15.04 °/h × sin(latitude)")},
        source="WGS84; known where the latitude is given, and then already in the reference",
        confounded="the isotropic part of g_sensitivity at every speed of a level plate",
        separates="a plate tilted by 60°; stating the site's latitude",
    ),
)
def earth_rate(at: Conditions) -> FloatArray:
    """The Earth's own rotation about the vertical, on top of the plate's."""
    up = at.force / np.linalg.norm(at.force, axis=1, keepdims=True)
    return np.asarray(up[:, :, None])
