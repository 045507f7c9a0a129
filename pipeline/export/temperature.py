"""A bias that follows the temperature as the polynomial that flight controllers compute."""

import numpy as np
from numpy.polynomial import Polynomial

from calib.effects.curves import PER_ORDER_K
from calib.effects.effect import REFERENCE_TEMPERATURE_C
from calib.poses.imu_log import AXES, FloatArray
from pipeline.export.parts import gains
from pipeline.results.read import StoredTriad

HELD = ("temperature_bias", "temperature_bias_curve")
"""The effects that the polynomial holds."""

ORDERS = (1, 2, 3)  #: fact: theirs are cubics in the temperature


def temperature_courses(triad: StoredTriad) -> list[Polynomial]:
    """Errors of the nominal reading of x, y and z, SI, by the temperature in °C."""
    courses = [Polynomial([0.0]) for _ in AXES]
    for name in HELD:
        if name not in triad.effects:
            continue
        values = np.array(triad.effects[name]["values"], float)
        if name == "temperature_bias":
            orders, centre = values[:3, None], REFERENCE_TEMPERATURE_C
        else:
            count = len(AXES) * len(ORDERS)
            orders = values[:count].reshape(len(AXES), -1)
            centre = float(triad.correction.shapes[name])
        warmth = Polynomial([-centre, 1.0])
        for axis, gain in enumerate(gains(triad)):
            for k, coefficient in enumerate(orders[axis], start=1):
                courses[axis] += coefficient / gain * warmth**k / PER_ORDER_K ** (k - 1)
    return courses


def courses_about(triad: StoredTriad, centre_c: float) -> FloatArray:
    """Coefficients (orders + 1, 3), SI per K to the order, of the polynomials about ``centre_c``.
    """
    from_there = Polynomial([centre_c, 1.0])
    coefficients = np.zeros((len(ORDERS) + 1, len(AXES)))
    for axis, course in enumerate(temperature_courses(triad)):
        shifted = course(from_there).coef
        coefficients[: len(shifted), axis] = shifted
    return coefficients
