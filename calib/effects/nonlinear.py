"""Response of an axis that is not a straight line."""

import numpy as np

from calib.effects.effect import Page, effect, per_axis
from calib.effects.typical import quoted, typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray


@effect(
    *AXES,
    unit="1/({u})",
    page=Page(
        formula="e_k = K2_k · s_k²",
        expressions=("s**2",),
        typical={
            "MPU-6050": typical(quoted(2.5, "mg/g²"), quoted(8e-6, "1/(°/s)"),
                                note="0.5 % of ±2 g, 0.2 % of ±250 °/s"),
            "MTi": typical(quoted(0.3, "mg/g²"), quoted(1e-5, "1/(°/s)"),
                           note="0.1 to 0.2 % of full scale"),
        },
        source="IEEE Std 1293 second-order nonlinearity coefficient",
        confounded="asymmetry exactly on 18 wedge poses; g_squared_sensitivity at one speed",
        separates="gyro: a second speed or plate-stopped poses; accelerometer: corner poses help "
        "a little, another magnitude than 1 g settles it",
    ),
)
def quadratic(at: Conditions) -> FloatArray:
    """Second-order nonlinearity: the gain grows with the reading."""
    return per_axis(at.vector**2)


@effect(
    *AXES,
    unit="1/({u})²",
    page=Page(
        formula="e_k = K3_k · s_k³",
        expressions=("s**3",),
        typical={
            "MPU-6050": typical(quoted(1.2, "mg/g³"), quoted(3e-8, "1/(°/s)²"),
                                note="0.5 % of ±2 g, 0.2 % of ±250 °/s"),
            "MTi": typical(quoted(0.04, "mg/g³"), quoted(4e-8, "1/(°/s)²"),
                           note="within 0.1 % of full scale"),
        },
        source="IEEE Std 1293 third-order nonlinearity coefficient",
        confounded="scale (91 % of it at one magnitude)",
        separates="gyro: a second speed; accelerometer: 26 poses or more",
    ),
)
def cubic(at: Conditions) -> FloatArray:
    """Third-order nonlinearity: both signs compress or expand alike."""
    return per_axis(at.vector * at.vector**2)


@effect(
    *AXES,
    unit="1",
    page=Page(
        formula="e_k = a_k · |s_k|",
        expressions=("abs(s)",),
        typical={
            "MPU-6050": typical(quoted(0.1, "%")),
            "MTi": typical(quoted(0.05, "%"), note="at most"),
        },
        source="IEEE Std 1293 bias asymmetry",
        confounded="quadratic exactly on 18 wedge poses",
        separates="gyro: two or more speeds; accelerometer: another magnitude than 1 g",
    ),
)
def asymmetry(at: Conditions) -> FloatArray:
    """Another gain for positive than for negative readings."""
    return per_axis(np.abs(at.vector))


@effect(
    *(f"{k}{i}{j}" for k in "xyz" for i, j in ("xy", "yz", "zx")),
    unit="1/({u})",
    page=Page(
        formula="e_k = K_kij · s_i · s_j,  i ≠ j",
        expressions=("x*y", "y*z", "z*x"),
        typical={"MPU-6050": typical(note="not specified"), "MTi": typical(note="not specified")},
        source="IEEE Std 1293 cross-coupling coefficients Kip, Kio, Kop",
        confounded="quadratic; x·y·z is zero on every wedge pose",
        separates="corner poses; gyro: a second speed",
    ),
    follows_words="product of two readings, {parameter}",
)
def cross_quadratic(at: Conditions) -> FloatArray:
    """Cross-coupling: an axis answers to the product of two axes."""
    s = at.vector
    products = np.stack([s[:, 0] * s[:, 1], s[:, 1] * s[:, 2], s[:, 2] * s[:, 0]], axis=1)
    columns = np.zeros((len(s), 3, 9))
    for k in range(3):
        columns[:, k, 3 * k : 3 * k + 3] = products
    return columns
