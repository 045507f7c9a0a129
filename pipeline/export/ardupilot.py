"""ArduPilot's parameters of the first IMU.

Of a reading v of the driver, in SI units by the data sheet, ArduPilot computes
(``AP_InertialSensor_Backend::_rotate_and_correct_accel`` and ``..._gyro``,
``AP_InertialSensor_TCal::correct_sensor``)

    accelerometer   (v - p(T) + p(CALTEMP) - INS_ACCOFFS) * INS_ACCSCAL
    gyroscope        v - p(T) + p(CALTEMP) - INS_GYROFFS

with ``p(T) = 1e-6 · INS_TCAL1_ACC1 · (T - 35 °C)`` and terms of second and third order, T and
CALTEMP held within TMIN and TMAX. Ours is ``u + c (T - 25 °C) = g (v - v0)``, g the gain on the
nominal reading: the coefficient is c/g, and the offset that at CALTEMP. A curve in the temperature
is a polynomial about another temperature, and the same about 35 °C.
"""

from collections.abc import Mapping

import numpy as np

from calib.effects.effect import REFERENCE_TEMPERATURE_C
from calib.poses.imu_log import AXES, FloatArray
from pipeline.export.firmware import (
    ORDERS,
    courses_about,
    held_effects,
    temperature_courses,
    what_is_left,
)
from pipeline.export.parts import Export, gains, no_effects, no_sds, origin, temperatures
from pipeline.export.programs.syntax import hash_comment
from pipeline.export.robotics import nominal_offset
from pipeline.results.read import Stored, StoredTriad

POLYNOMIAL_FROM_C = 35.0  #: °C, TEMP_REFERENCE in AP_InertialSensor_tempcal; fact
COEFFICIENT = 1e6  #: unit of the parameters INS_TCAL1_*, per SI unit and kelvin
#: Triad -> prefix of offsets, CALTEMP and coefficients.
NAMES: Mapping[str, tuple[str, str, str]] = {
    "accelerometer": ("INS_ACCOFFS", "INS_ACC1_CALTEMP", "INS_TCAL1_ACC"),
    "gyroscope": ("INS_GYROFFS", "INS_GYR1_CALTEMP", "INS_TCAL1_GYR"),
}
SCALE_RANGE = (0.8, 1.2)  #: range of INS_ACCSCAL by ArduPilot's documentation
LARGEST_OFFSET = 3.5  #: m/s², of INS_ACCOFFS by ArduPilot's documentation


def to_ardupilot(stored: Stored) -> Export:
    """``ardupilot.param``: a name and a value in a line, as the ground stations load it."""
    warmed = [triad for triad in stored.triads if held_effects(triad)]
    span = temperatures(stored)
    values: dict[str, float] = {}
    loses = [*no_sds(stored)]
    caltemp = float(np.clip(REFERENCE_TEMPERATURE_C, min(span), max(span))) if span else None
    for triad in stored.triads:
        name, temperature, _ = NAMES[triad.name]
        offset = nominal_offset(triad)
        if warmed and caltemp is not None:
            offset = offset + [float(course(caltemp)) for course in temperature_courses(triad)]
            values[temperature] = caltemp
        values |= {f"{name}_{axis.upper()}": v for axis, v in zip(AXES, offset, strict=True)}
        if triad.name == "accelerometer":
            scale = gains(triad)
            values |= {f"INS_ACCSCAL_{a.upper()}": v for a, v in zip(AXES, scale, strict=True)}
            loses += _range_notes(offset, scale)
        loses.append(what_is_left(triad, "ArduPilot",
                                  keeps_scale=triad.name == "accelerometer"))
    values |= _temperature_calibration(stored, warmed, span)
    loses += [
        "Set INS_GYR_CAL to 0, or ArduPilot measures the gyroscope's offset anew at every start.",
        "The axes are those of the log: ArduPilot's are forward, right, down after the rotation of "
        "the sensor's driver. Logs of ArduPilot itself are corrected already: record them with "
        "offsets of 0, scales of 1 and INS_TCAL1_ENABLE 0.",
        *no_effects(stored, "ArduPilot", {one.name: held_effects(one) for one in warmed}),
    ]
    lines = [hash_comment(line) for line in origin(stored)]
    lines += [f"{name},{value:.9g}" for name, value in values.items()]
    return Export({"ardupilot.param": "\n".join(lines) + "\n"}, tuple(loses))


def _temperature_calibration(
    stored: Stored, warmed: list[StoredTriad], span: list[float]
) -> dict[str, float]:
    """All parameters of INS_TCAL1, so that none of an earlier calibration remains."""
    if not warmed or not span:
        return {"INS_TCAL1_ENABLE": 0.0}
    values = {"INS_TCAL1_ENABLE": 1.0, "INS_TCAL1_TMIN": min(span), "INS_TCAL1_TMAX": max(span)}
    every = {one.name: courses_about(one, POLYNOMIAL_FROM_C)[1:] for one in stored.triads}
    for triad, (_, _, prefix) in NAMES.items():
        coefficients = every.get(triad, np.zeros((len(ORDERS), len(AXES))))
        for order in ORDERS:
            of_order = COEFFICIENT * coefficients[order - 1]
            values |= {f"{prefix}{order}_{axis.upper()}": float(v)
                       for axis, v in zip(AXES, of_order, strict=True)}
    return values


def _range_notes(offset: FloatArray, scale: FloatArray) -> list[str]:
    notes = []
    if (np.abs(offset) > LARGEST_OFFSET).any():
        notes.append(f"INS_ACCOFFS is {np.abs(offset).max():.3g} m/s² on one axis; ArduPilot "
                     f"documents ±{LARGEST_OFFSET} m/s².")
    low, high = SCALE_RANGE
    if ((scale < low) | (scale > high)).any():
        worst = scale[np.argmax(np.abs(scale - 1))]
        notes.append(f"INS_ACCSCAL is {worst:.3g} on one axis; ArduPilot documents {low} to "
                     f"{high}. Are the readings those of ArduPilot's driver, in m/s²?")
    return notes
