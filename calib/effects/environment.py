"""Effects of the surroundings and the past on a triad: temperature, time, history, vibration."""

import numpy as np

from calib.effects.effect import (
    OF_COLUMN,
    REFERENCE_TEMPERATURE_C,
    Page,
    Shape,
    ShapeValue,
    effect,
    per_axis,
)
from calib.effects.typical import between, quoted, typical
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, TEMPERATURE, TRIADS, FloatArray

WARMTH = f"({TEMPERATURE} - {REFERENCE_TEMPERATURE_C})"
"""The columns of an effect of temperature as an expression, K."""

HOURS = f"time_s / {SECONDS_PER_HOUR}"
"""The columns of a drift as an expression, h."""


def _warmth(at: Conditions) -> FloatArray:
    return np.asarray(at.column(TEMPERATURE) - REFERENCE_TEMPERATURE_C)[:, None]


def _hours(at: Conditions) -> FloatArray:
    return np.asarray(at.time_s / SECONDS_PER_HOUR)[:, None]

LARGEST_RECTIFICATION = 1e3
"""SI of the triad per (m/s²)². Derived: 300 sds of a pose's mean where poses hardly vary in what
they vibrate by; poses at another range make a thousand times as much of it."""


@effect(
    *AXES,
    unit="{u}/K",
    logged=(TEMPERATURE,),
    constant_is="bias",
    names_column=TEMPERATURE,
    contains=(f"{OF_COLUMN}{TEMPERATURE}",),
    page=Page(
        formula="e_k = c_k · (T − 25 °C)",
        expressions=(WARMTH,),
        typical={
            "MPU-6050": typical(quoted(0.16, "°/s/K"), between(0.5, 0.9, "mg/K")),
            "MTi": typical(quoted(0.1, "mg/K"), note="at most, after the factory"),
        },
        source="MPU-6050 data sheet: zero-rate and zero-g output over temperature",
        confounded="bias_drift and warm_up as long as temperature only rises with time",
        separates="a second soak, hot then cold, so that temperature is not a clock",
    ),
)
def temperature_bias(at: Conditions) -> FloatArray:
    """Bias that moves in proportion to the die temperature."""
    return per_axis(_warmth(at) * np.ones_like(at.vector))


@effect(
    *AXES,
    unit="1/K",
    logged=(TEMPERATURE,),
    constant_is="scale",
    page=Page(
        formula="e_k = c_k · (T − 25 °C) · s_k",
        expressions=(f"{WARMTH} * s",),
        typical={
            "MPU-6050": typical(quoted(0.02, "%/K")),
            "MTi": typical(note="compensated in the factory model"),
        },
        source="MPU-6050 data sheet: sensitivity change over temperature",
        confounded="a plate or clock that drifts as the session warms up",
        separates="a second soak; one clip per pose",
    ),
)
def temperature_scale(at: Conditions) -> FloatArray:
    """Gain that moves in proportion to the die temperature."""
    return per_axis(_warmth(at) * at.vector)


@effect(
    *AXES,
    unit="{u}/h",
    needs=("time",),
    constant_is="bias",
    belongs_to="session",
    page=Page(
        formula="e_k = d_k · t",
        expressions=(HOURS,),
        typical={
            "MPU-6050": typical(between(0.01, 0.05, "°/s/h"), quoted(1, "mg/h")),
            "MTi": typical(quoted(0.003, "°/s/h"), quoted(0.02, "mg/h")),
        },
        source="IEEE Std 952 rate ramp",
        confounded="temperature_bias when temperature rises with time",
        separates="poses repeated at the end; random pose order; a second soak",
    ),
)
def bias_drift(at: Conditions) -> FloatArray:
    """Bias that moves steadily through the session."""
    return per_axis(_hours(at) * np.ones_like(at.vector))


@effect(
    *AXES,
    unit="1/h",
    needs=("time",),
    constant_is="scale",
    belongs_to="session",
    page=Page(
        formula="e_k = d_k · t · s_k",
        expressions=(f"{HOURS} * s",),
        typical={
            "MPU-6050": typical(quoted(0.1, "%/h"), note="while warming"),
            "MTi": typical(note="small"),
        },
        source="IEEE Std 528 scale-factor drift",
        confounded="reference_drift, as far as it is the same on all axes: the plate slowing down "
        "looks like that",
        separates="one clip per pose, so that the reference is measured for each",
    ),
)
def scale_drift(at: Conditions) -> FloatArray:
    """Gain of each axis that moves steadily through the session."""
    return per_axis(_hours(at) * at.vector)


@effect(
    *AXES,
    unit="{u}",
    needs=("time",),
    constant_is="bias",
    belongs_to="session",
    page=Page(
        formula="e_k = w_k · exp(−t/τ),  τ fitted",
        expressions=("exp(-time_s / tau_s)",),
        typical={
            "MPU-6050": typical(
                between(0.1, 1, "°/s"), between(5, 20, "mg"), note="over 10 min"),
            "MTi": typical(quoted(1, "mg"), note="at most"),
        },
        source="IEEE Std 528 warm-up; field experience",
        confounded="temperature_bias (0.99 and more) and bias_drift",
        separates="wait half an hour and repeat the poses; a hot and a cold soak",
    ),
    shape=Shape("tau_s", "s", (600.0, 150.0, 300.0, 1200.0, 2400.0), (30.0, 7200.0)),
)
def warm_up(at: Conditions, tau_s: ShapeValue) -> FloatArray:
    """Bias that settles exponentially after power-on."""
    settling = np.exp(-at.time_s[:, None] / tau_s)
    return per_axis(settling * np.ones_like(at.vector))


@effect(
    *AXES,
    unit="{u}",
    needs=("previous",),
    page=Page(
        formula="e_k = h_k · tanh(u_k / (width · |u|)),  u what the axes sensed in the pose before",
        typical={
            "MPU-6050": typical(between(0.1, 1, "mg")),
            "MTi": typical(quoted(0.1, "mg"), note="at most"),
        },
        source="IEEE Std 1293 hysteresis error",
        confounded="bias, when the pose order is systematic",
        separates="random pose order; each pose approached from both sides",
    ),
    shape=Shape("width", "1", (0.3, 0.03, 1.0, 2e-4), (1e-4, 3.0)),
    follows_words="memory of the pose before along {axis}",
)
def hysteresis(at: Conditions, width: ShapeValue) -> FloatArray:
    """Memory of the last pose: stress that has not relaxed when the next one is taken.

    Narrow, it keeps the sign of what an axis sensed; wide, it is in proportion to it.
    """
    size = np.linalg.norm(at.previous, axis=1, keepdims=True)
    share = at.previous / np.where(size == 0, 1.0, size)  # rest leaves no memory
    return per_axis(np.tanh(share / width))


@effect(
    *AXES,
    unit="{u}/(m/s²)²",
    needs=("vibration",),
    constant_is="bias",
    largest=LARGEST_RECTIFICATION,
    only_for=TRIADS,
    page=Page(
        formula="e_k = v_k · σ_a²,  σ_a² the accelerometer's variance within the pose, axes summed",
        typical={
            "MPU-6050": typical(
                between(0.01, 0.1, "°/s/g²"), between(0.1, 0.5, "mg/g²"), note="of variance"),
            "MTi": typical(quoted(0.001, "°/s/g²"), between(0.05, 0.1, "mg/g²")),
        },
        source="IEEE Std 1293 vibration rectification error",
        confounded="bias exactly while the motor shakes every pose alike",
        separates="plate-stopped poses with the motor on and off; a second speed",
    ),
)
def vibration_rectification(at: Conditions) -> FloatArray:
    """Bias that vibration makes: a shaken axis with curvature does not average to zero."""
    total = at.vibration.sum(axis=1)[:, None]
    return per_axis(total * np.ones_like(at.vector))
