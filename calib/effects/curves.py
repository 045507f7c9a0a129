"""Curves in the temperature: polynomials of third order about the mean of the session."""

import numpy as np

from calib.effects.effect import (
    OF_COLUMN,
    REFERENCE_TEMPERATURE_C,
    Page,
    Shape,
    ShapeValue,
    effect,
)
from calib.effects.typical import between, quoted, typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, TEMPERATURE, FloatArray

PER_ORDER_K = 10.0
"""Warmth by which each further order is divided, so that all have one unit. A definition."""

CENTRE = Shape("centre_c", "°C", (REFERENCE_TEMPERATURE_C,), (-273.15, 1e3), is_fitted=False)
"""Reference temperature of a curve, the mean of the poses. A definition: there a line and a square
overlap least."""

NAMES = tuple(f"{axis}{order}" for axis in AXES for order in (1, 2, 3))
"""Names of the parameters: the axis, and the order of the polynomial."""

CENTRED = f"({TEMPERATURE} - centre_c)"
"""Temperature relative to the centre as an expression, K."""

CURVE = (CENTRED, f"{CENTRED} ** 2 / {PER_ORDER_K}", f"{CENTRED} ** 3 / {PER_ORDER_K**2}")
"""The columns of a curve as expressions, K."""


def _curve(at: Conditions, centre_c: ShapeValue) -> FloatArray:
    """Temperature relative to ``centre_c``, its square and its cube, (n, 3), K."""
    warmth = at.column(TEMPERATURE)[:, None] - centre_c
    return np.concatenate(
        [warmth, warmth**2 / PER_ORDER_K, warmth**3 / PER_ORDER_K**2], axis=1)


def _mean_temperature(at: Conditions) -> tuple[float, ...]:
    """The mean temperature of the poses, °C; none where it was not logged."""
    mean = float(at.column(TEMPERATURE).mean())
    return (mean,) if np.isfinite(mean) else ()


@effect(
    *NAMES,
    unit="{u}/K",
    logged=(TEMPERATURE,),
    constant_is="bias",
    contains=("temperature_bias", f"{OF_COLUMN}{TEMPERATURE}"),
    shape=CENTRE,
    starts_in=_mean_temperature,
    page=Page(
        formula="e_k = c_k1 · ΔT + c_k2 · ΔT²/10 K + c_k3 · ΔT³/(10 K)²,  ΔT = T − its mean here",
        expressions=CURVE,
        typical={"MPU-6050": typical(between(0.01, 0.1, "°/s/K"), between(0.05, 0.5, "mg/K")),
                 "MTi": typical(note="compensated in the factory model")},
        source="ArduPilot's calibration of IMU temperature, a polynomial of third order",
        confounded="warm_up and temperature_bias where few temperatures were seen",
        separates="poses at four temperatures or more, falling as well as rising",
    ),
)
def temperature_bias_curve(at: Conditions, centre_c: ShapeValue) -> FloatArray:
    """Bias that follows the die temperature in a curve, temperature_bias being its line."""
    return _for_each_axis(_curve(at, centre_c), np.ones_like(at.vector))


@effect(
    *NAMES,
    unit="1/K",
    logged=(TEMPERATURE,),
    constant_is="scale",
    contains=("temperature_scale",),
    shape=CENTRE,
    starts_in=_mean_temperature,
    page=Page(
        formula="e_k = (c_k1 · ΔT + c_k2 · ΔT²/10 K + c_k3 · ΔT³/(10 K)²) · s_k",
        expressions=tuple(f"{each} * s" for each in CURVE),
        typical={"MPU-6050": typical(quoted(0.01, "%/K")),
                 "MTi": typical(note="compensated in the factory model")},
        source="ArduPilot's calibration of IMU temperature, for the gain",
        confounded="a plate or clock that drifts as the session warms up",
        separates="poses at four temperatures or more, falling as well as rising",
    ),
)
def temperature_scale_curve(at: Conditions, centre_c: ShapeValue) -> FloatArray:
    """Gain that follows the die temperature in a curve, temperature_scale being its line."""
    return _for_each_axis(_curve(at, centre_c), at.vector)


def _for_each_axis(orders: FloatArray, values: FloatArray) -> FloatArray:
    """Columns (n, 3, 3 m) of axes whose errors are ``orders`` (n, m) times ``values`` (n, 3)."""
    n, m = orders.shape
    columns = np.zeros((n, 3, 3, m))
    for k in range(3):
        columns[:, k, k] = orders * values[:, [k]]
    return columns.reshape(n, 3, 3 * m)
