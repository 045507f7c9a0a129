"""Formats of microcontrollers: C headers, and the parameters of two flight controllers."""

import ast
import math
from collections.abc import Iterator

import numpy as np
from numpy.polynomial import Polynomial

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import REFERENCE_TEMPERATURE_C, Effect
from calib.effects.formula import axis_terms
from calib.poses.imu_log import AXES, TEMPERATURE, FloatArray
from pipeline.export.parts import (
    Export,
    error_text,
    example,
    gains,
    no_effects,
    no_sds,
    origin,
    plain_row,
    temperatures,
    triad_named,
)
from pipeline.export.programs.syntax import c_comment, c_row, hash_comment
from pipeline.export.robotics import nominal_offset
from pipeline.results.read import Stored, StoredTriad

ORDERS = (1, 2, 3)  #: fact: these programs use cubics in the temperature


def held_effects(triad: StoredTriad) -> tuple[str, ...]:
    """Effects that a cubic in the temperature contains: listed, of a column, or the user's own."""
    return tuple(each.name for each in triad.correction.model.effects
                 if each.name in triad.section.effects and _polynomials(triad, each) is not None)


def temperature_courses(triad: StoredTriad) -> list[Polynomial]:
    """Errors of the nominal reading of x, y and z, SI, by the temperature in °C."""
    courses = [Polynomial([0.0]) for _ in AXES]
    for each in triad.correction.model.effects:
        of_axes = _polynomials(triad, each) if each.name in triad.section.effects else None
        for axis, course in enumerate(of_axes or ()):
            courses[axis] += course / gains(triad)[axis]
    return courses


def _polynomials(triad: StoredTriad, effect: Effect) -> list[Polynomial] | None:
    """The error of x, y and z, SI, by the temperature in °C; None where it is no cubic in it."""
    if effect.acts_on != "sensor" or effect.told_by == "bench":
        return None
    terms = axis_terms(effect, triad.correction.shapes.get(effect.name))
    values, courses = triad.section.effects[effect.name].values, []
    for of_axis in terms:
        course = Polynomial([0.0])
        for term in of_axis:
            part = _polynomial(term.value)
            if part is None:
                return None
            course += float(values[term.parameter] or 0.0) * part
        courses.append(course.trim())
    return courses if courses and max(one.degree() for one in courses) in ORDERS else None


def _polynomial(node: ast.expr) -> Polynomial | None:
    """An expression as a polynomial in the temperature, °C; None where it is none."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return Polynomial([float(number)])
        case ast.Name(id=name):
            return Polynomial([0.0, 1.0]) if name == TEMPERATURE else None
        case ast.UnaryOp(op=operator, operand=operand):
            inner = _polynomial(operand)
            return -inner if inner is not None and isinstance(operator, ast.USub) else inner
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=int() as power)):
            inner = _polynomial(left)
            return None if inner is None or power < 0 else inner**power
        case ast.BinOp(left=left, op=operator, right=right):
            one, other = _polynomial(left), _polynomial(right)
            if one is None or other is None:
                return None
            match operator:
                case ast.Add():
                    return one + other
                case ast.Sub():
                    return one - other
                case ast.Mult():
                    return one * other
                case ast.Div() if other.degree() == 0 and other.coef[0] != 0:
                    return one / float(other.coef[0])
    return None


def courses_about(triad: StoredTriad, centre_c: float) -> FloatArray:
    """Coefficients (orders + 1, 3), SI per K to the order, of the polynomials about ``centre_c``.
    """
    from_there = Polynomial([centre_c, 1.0])
    coefficients = np.zeros((len(ORDERS) + 1, len(AXES)))
    for axis, course in enumerate(temperature_courses(triad)):
        shifted = course(from_there).coef
        coefficients[: len(shifted), axis] = shifted
    return coefficients


#: Ranges to which INAV sets the sensors of this family, counts over the 16-bit half range.
INAV_ACCELEROMETER = 16 * STANDARD_GRAVITY_M_S2 / 32768  #: m/s² per count
INAV_GYROSCOPE = math.radians(2000.0) / 32768  #: rad/s per count
INAV_UNIT_GAIN = 4096  #: accgain of an axis with the nominal gain


def to_fusion(stored: Stored) -> Export:
    """``fusion_calibration.h`` for ``FusionModelInertial(counts, M, sensitivity, offset)``."""
    lines = [
        *map(c_comment, origin(stored)),
        c_comment("FusionModelInertial(counts, misalignment, sensitivity, offset) gives degrees "
                  "per second and g"),
        "#ifndef FUSION_CALIBRATION_H",
        "#define FUSION_CALIBRATION_H",
    ]
    for triad in stored.triads:
        unit, per_si = _fusion_unit(triad)
        counts, si = example(triad)
        lines += [
            "",
            c_comment(f"{triad.name}: counts ({plain_row(counts)}) are "
                      f"({plain_row(si * per_si)}) {unit}"),
            f"static const FusionMatrix {triad.name}Misalignment = "
            f"{{.element = {{{c_row(triad.alignment.ravel())}}}}};",
            f"static const FusionVector {triad.name}Sensitivity = "
            f"{{.axis = {{{c_row(triad.units_per_count * per_si)}}}}};",
            f"static const FusionVector {triad.name}Offset = "
            f"{{.axis = {{{c_row(triad.parameters.bias_counts)}}}}};",
        ]
    lines += ["", "#endif"]
    return Export(
        {"fusion_calibration.h": "\n".join(lines) + "\n"},
        (*no_sds(stored), *no_effects(stored, "Fusion")),
    )


def _fusion_unit(triad: StoredTriad) -> tuple[str, float]:
    if triad.name == "accelerometer":
        return "g", 1 / STANDARD_GRAVITY_M_S2
    return "deg/s", math.degrees(1.0)


def to_px4(stored: Stored) -> Export:
    """PX4 parameters: ``(reading - p(T) - OFF) * SCALE``, the gyroscope without ``SCALE``.

    ``Accelerometer::Correct`` and ``Gyroscope::Correct`` of PX4 (``src/lib/sensor_calibration``)
    rotate what comes out into the body. p is a cubic about ``TREF`` with T held within ``TMIN`` and
    ``TMAX`` (``TC_A0_X1_0`` and on, ``src/modules/temperature_compensation``), zero there.
    """
    lines = [hash_comment(line) for line in origin(stored)]
    lines.append("# Set CAL_ACC0_ID and CAL_GYRO0_ID, and TC_A0_ID and TC_G0_ID where they are "
                 "used, to the ids that your board shows; this file does not set them.")
    loses, span = [*no_sds(stored)], temperatures(stored)
    centre_c = float(np.clip(REFERENCE_TEMPERATURE_C, min(span), max(span))) if span else None
    warmed = {one.name: held for one in stored.triads if span and (held := held_effects(one))}
    for triad in stored.triads:
        name = {"accelerometer": "CAL_ACC0", "gyroscope": "CAL_GYRO0"}[triad.name]
        offset = nominal_offset(triad)
        if triad.name in warmed and centre_c is not None:
            course = courses_about(triad, centre_c)
            offset = offset + course[0]
            lines += _px4_temperatures(triad.name, course, centre_c, span)
        values = [(f"{axis.upper()}OFF", v) for axis, v in zip(AXES, offset, strict=True)]
        if triad.name == "accelerometer":
            values += [(f"{a.upper()}SCALE", v) for a, v in zip(AXES, gains(triad), strict=True)]
        # vehicle, component, name, value, type (9 is a float)
        lines += [f"1\t1\t{name}_{key}\t{value:.10g}\t9" for key, value in values]
        loses.append(what_is_left(triad, "PX4", keeps_scale=triad.name == "accelerometer"))
    loses.append("The axes are those of the log, as the driver publishes them: PX4 rotates into "
                 "the body (CAL_ACC0_ROT, CAL_GYRO0_ROT, SENS_BOARD_ROT) after the correction.")
    loses += no_effects(stored, "PX4", warmed)
    return Export({"px4.params": "\n".join(lines) + "\n"}, tuple(loses))


def _px4_temperatures(
    triad: str, course: FloatArray, centre_c: float, span: list[float]
) -> Iterator[str]:
    """The lines of a polynomial ``course`` (orders + 1, 3) about ``centre_c``."""
    letter = {"accelerometer": "A", "gyroscope": "G"}[triad]
    yield f"1\t1\tTC_{letter}_ENABLE\t1\t6"  # 6 is a whole number
    values = {"TREF": centre_c, "TMIN": min(span), "TMAX": max(span)}
    values |= {f"X{order}_{axis}": float(course[order, axis] if order else 0.0)
               for order in (0, *ORDERS) for axis in range(len(AXES))}
    for key, value in values.items():
        yield f"1\t1\tTC_{letter}0_{key}\t{value:.10g}\t9"


def to_inav(stored: Stored) -> Export:
    """INAV's CLI: zeros in counts of the ranges that it sets, gains in 1/4096."""
    lines = [hash_comment(line) for line in origin(stored)]
    loses = [*no_sds(stored)]
    accelerometer = triad_named(stored, "accelerometer")
    if accelerometer is not None:
        zero = np.round(nominal_offset(accelerometer) / INAV_ACCELEROMETER)
        gain = np.round(gains(accelerometer) * INAV_UNIT_GAIN)
        lines += [f"set acczero_{axis} = {v:.0f}" for axis, v in zip(AXES, zero, strict=True)]
        lines += [f"set accgain_{axis} = {v:.0f}" for axis, v in zip(AXES, gain, strict=True)]
        lines.append(f"set ins_gravity_cmss = {100 * stored.gravity_m_s2:.3f}")
        loses.append(what_is_left(accelerometer, "INAV", keeps_scale=True))
    gyroscope = triad_named(stored, "gyroscope")
    if gyroscope is not None:
        zero = np.round(nominal_offset(gyroscope) / INAV_GYROSCOPE)
        lines += [f"set gyro_zero_{axis} = {v:.0f}" for axis, v in zip(AXES, zero, strict=True)]
        loses.append(what_is_left(gyroscope, "INAV", keeps_scale=False))
    lines.append("save")
    loses += [
        "INAV stores integer counts of its ranges of 16 g and 2000 °/s: the zeros are rounded to "
        f"{1000 * INAV_ACCELEROMETER:.2g} mm/s² and {math.degrees(INAV_GYROSCOPE):.2g} °/s.",
        *no_effects(stored, "INAV"),
    ]
    return Export({"inav.txt": "\n".join(lines) + "\n"}, tuple(loses))


def what_is_left(triad: StoredTriad, program: str, *, keeps_scale: bool) -> str:
    """The largest error that a format without T (and without K) leaves, as a note."""
    missing = triad.alignment - np.eye(3)
    lost = "misalignment"
    if not keeps_scale:
        missing = triad.parameters.matrix() / triad.correction.spec.nominal_scale - np.eye(3)
        lost = "scale and misalignment"
    share = float(np.linalg.svd(missing, compute_uv=False)[0])
    readings = [pose.reading for pose in triad.section.poses
                if None not in pose.reading]
    largest = float(np.linalg.norm(np.array(readings).reshape(-1, 3), axis=1).max(initial=0.0))
    return (
        f"{program} cannot store the {lost} of the {triad.name}: an error of up to "
        f"{100 * share:.2g} % of the reading remains, "
        f"{error_text(share * largest, triad.name)} at the largest reading of the session."
    )
