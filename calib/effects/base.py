"""The nine parameters of Angrisano et al. eq. (1), and the frame they leave open.

Evaluated on the nominal reading y, they form ``s = M y + c`` with
``M = I - diag(scale) - U(misalignment)`` and ``c = -bias``.
"""

import numpy as np

from calib.effects.effect import Page, effect, per_axis
from calib.effects.typical import between, quoted, typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray


@effect(
    *AXES,
    acts_on="reading",
    unit="{u}",
    page=Page(
        formula="e_k = b_k",
        typical={
            "MPU-6050": typical(quoted(20, "°/s"), between(50, 80, "mg")),
            "MTi": typical(quoted(0.5, "°/s"), quoted(20, "mg")),
        },
        source="Angrisano et al. eq. (1)",
        confounded="motor vibration at one speed; any slow drift over one short session",
        separates="plate-stopped poses; poses repeated at the end",
    ),
)
def bias(at: Conditions) -> FloatArray:
    """Reading of an axis that senses nothing: the zero offset of eq. (1)."""
    return per_axis(np.ones_like(at.vector))


@effect(
    *AXES,
    acts_on="reading",
    unit="1",
    page=Page(
        formula="e_k = k_k · y_k",
        typical={
            "MPU-6050": typical(quoted(3, "%")),
            "MTi": typical(quoted(1, "%"), note="before the certificate"),
        },
        source="Angrisano et al. eq. (1)",
        confounded="an error of the reference: camera clock, local gravity",
        separates="a better reference: a second clock, surveyed gravity",
    ),
)
def scale(at: Conditions) -> FloatArray:
    """Gain of each axis relative to the data sheet."""
    return per_axis(at.vector)


@effect(
    *AXES,
    acts_on="reading",
    unit="rad",
    page=Page(
        formula="e_x = α_z y_y + α_y y_z,  e_y = α_x y_z",
        typical={"MPU-6050": typical(quoted(2, "%")), "MTi": typical(between(0.1, 1, "°"))},
        source="Angrisano et al. eq. (2), (15)",
        confounded="the symmetric part of g-sensitivity at one speed on a level plate",
        separates="plate-stopped poses, a second speed",
    ),
)
def misalignment(at: Conditions) -> FloatArray:
    """Departure of the sensitive axes from a right angle; T of eq. (2) is upper triangular."""
    x, y, z = 0, 1, 2
    columns = np.zeros((len(at.vector), 3, 3))
    columns[:, x, z] = at.vector[:, y]
    columns[:, x, y] = at.vector[:, z]
    columns[:, y, x] = at.vector[:, z]
    return columns


@effect(
    *AXES,
    unit="rad",
    orthogonal=True,
    page=Page(
        formula="e = φ × s",
        expressions=("0", "z", "-y", "-z", "0", "x", "y", "-x", "0"),
        typical={"MPU-6050": typical(between(1, 2, "°")), "MTi": typical(quoted(0.1, "°"))},
        source="IEEE Std 528 input-axis misalignment; Kalibr C_gyro_i",
        confounded="nothing and everything: a magnitude does not change under rotation",
        separates="gyro: both triads logged together on the turning plate, which makes it a "
        "parameter; accelerometer: nothing on this bench, its own axes are the frame",
    ),
)
def frame_rotation(at: Conditions) -> FloatArray:
    """Rotation of the whole triad against the frame it is mounted in."""
    s = at.vector
    columns = np.zeros((len(s), 3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        columns[:, i, k] = -s[:, j]
        columns[:, j, k] = s[:, i]
    return columns
