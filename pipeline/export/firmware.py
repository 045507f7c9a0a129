"""Formats of microcontrollers: C headers, and the parameters of two flight controllers."""

import math
import re
from collections.abc import Sequence

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import AXES, FloatArray
from pipeline.export.parts import (
    Export,
    example,
    example_text,
    matrix,
    no_effects,
    no_sds,
    origin,
    short_name,
    triad_named,
)
from pipeline.export.robotics import nominal_offset
from pipeline.plain_text import ascii_line
from pipeline.results.read import Stored, StoredTriad

#: Ranges that INAV sets the sensors of this family to, counts over the 16-bit half range.
INAV_ACCELEROMETER = 16 * STANDARD_GRAVITY_M_S2 / 32768  #: m/s² per count
INAV_GYROSCOPE = math.radians(2000.0) / 32768  #: rad/s per count
COMMENT_SIGNS = re.compile(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)")
INAV_UNIT_GAIN = 4096  #: accgain of an axis that is right


def to_arduino(stored: Stored) -> Export:
    """``imu_calibration.h``: matrix, bias and one function for each triad, with a worked number."""
    lines = [
        *_comment([*origin(stored), "calibrated = C * (counts - B), in SI units"]),
        "#ifndef IMU_CALIBRATION_H",
        "#define IMU_CALIBRATION_H",
    ]
    for each in stored.triads:
        name = short_name(each)
        const = {"acc": "ACC", "gyro": "GYR"}[name]
        lines += [
            "",
            *_comment([f"{each.triad}: {example_text(each)}"]),
            f"static const float {const}_C[3][3] = {{",
            *(f"    {{{_c_row(row)}}}," for row in matrix(each)),
            "};",
            f"static const float {const}_B[3] = {{{_c_row(each.bias_counts)}}};",
            "",
            f"static inline void calibrate_{each.triad}(const float counts[3], float si[3])",
            "{",
            "    for (int i = 0; i < 3; i++) {",
            "        si[i] = 0.0f;",
            "        for (int j = 0; j < 3; j++) {",
            f"            si[i] += {const}_C[i][j] * (counts[j] - {const}_B[j]);",
            "        }",
            "    }",
            "}",
        ]
    lines += ["", "#endif"]
    return Export(
        {"imu_calibration.h": "\n".join(lines) + "\n"},
        (*no_sds(stored), *no_effects(stored, "The header")),
    )


def to_fusion(stored: Stored) -> Export:
    """``fusion_calibration.h`` for ``FusionModelInertial(counts, M, sensitivity, offset)``."""
    lines = [
        *_comment([*origin(stored), "FusionModelInertial(counts, misalignment, sensitivity, "
                   "offset) gives degrees per second and g"]),
        "#ifndef FUSION_CALIBRATION_H",
        "#define FUSION_CALIBRATION_H",
    ]
    for each in stored.triads:
        unit, per_si = _fusion_unit(each)
        counts, si = example(each)
        lines += [
            "",
            *_comment([f"{each.triad}: counts ({_plain_row(counts)}) are "
                       f"({_plain_row(si * per_si)}) {unit}"]),
            f"static const FusionMatrix {each.triad}Misalignment = "
            f"{{.element = {{{_c_row(each.alignment.ravel())}}}}};",
            f"static const FusionVector {each.triad}Sensitivity = "
            f"{{.axis = {{{_c_row(each.units_per_count * per_si)}}}}};",
            f"static const FusionVector {each.triad}Offset = "
            f"{{.axis = {{{_c_row(each.bias_counts)}}}}};",
        ]
    lines += ["", "#endif"]
    return Export(
        {"fusion_calibration.h": "\n".join(lines) + "\n"},
        (*no_sds(stored), *no_effects(stored, "Fusion")),
    )


def _fusion_unit(each: StoredTriad) -> tuple[str, float]:
    if each.triad == "accelerometer":
        return "g", 1 / STANDARD_GRAVITY_M_S2
    return "deg/s", math.degrees(1.0)


def to_px4(stored: Stored) -> Export:
    """PX4 parameters: ``(reading - OFF) * SCALE`` for the accelerometer, ``reading - OFF`` else."""
    lines = _hash_comments(origin(stored))
    lines.append("# Set CAL_ACC0_ID and CAL_GYRO0_ID to the ids that your board shows; this file "
                 "does not set them.")
    loses = [*no_sds(stored)]
    for each in stored.triads:
        name = {"accelerometer": "CAL_ACC0", "gyroscope": "CAL_GYRO0"}[each.triad]
        values = [(f"{axis.upper()}OFF", v) for axis, v in zip(AXES, nominal_offset(each),
                                                               strict=True)]
        if each.triad == "accelerometer":
            gains = _gains(each)
            values += [(f"{a.upper()}SCALE", v) for a, v in zip(AXES, gains, strict=True)]
        # vehicle, component, name, value, type (9 is a float)
        lines += [f"1\t1\t{name}_{key}\t{value:.10g}\t9" for key, value in values]
        loses.append(_what_is_left(each, "PX4", keeps_scale=each.triad == "accelerometer"))
    loses.append("The axes are those of the log; PX4 rotates them by _ROT first if it is set.")
    loses += no_effects(stored, "PX4")
    return Export({"px4.params": "\n".join(lines) + "\n"}, tuple(loses))


def to_inav(stored: Stored) -> Export:
    """INAV's CLI: zeros in counts of the ranges that it sets, gains in 1/4096."""
    lines = _hash_comments(origin(stored))
    loses = [*no_sds(stored)]
    accelerometer = triad_named(stored, "accelerometer")
    if accelerometer is not None:
        zero = np.round(nominal_offset(accelerometer) / INAV_ACCELEROMETER)
        gain = np.round(_gains(accelerometer) * INAV_UNIT_GAIN)
        lines += [f"set acczero_{axis} = {v:.0f}" for axis, v in zip(AXES, zero, strict=True)]
        lines += [f"set accgain_{axis} = {v:.0f}" for axis, v in zip(AXES, gain, strict=True)]
        gravity = stored.contents["accelerometer"]["gravity"]
        lines.append(f"set ins_gravity_cmss = {100 * gravity['value_m_s2']:.3f}")
        loses.append(_what_is_left(accelerometer, "INAV", keeps_scale=True))
    gyroscope = triad_named(stored, "gyroscope")
    if gyroscope is not None:
        zero = np.round(nominal_offset(gyroscope) / INAV_GYROSCOPE)
        lines += [f"set gyro_zero_{axis} = {v:.0f}" for axis, v in zip(AXES, zero, strict=True)]
        loses.append(_what_is_left(gyroscope, "INAV", keeps_scale=False))
    lines.append("save")
    loses += [
        "INAV stores integer counts of its ranges of 16 g and 2000 °/s: the zeros are rounded to "
        f"{1000 * INAV_ACCELEROMETER:.2g} mm/s² and {math.degrees(INAV_GYROSCOPE):.2g} °/s.",
        *no_effects(stored, "INAV"),
    ]
    return Export({"inav.txt": "\n".join(lines) + "\n"}, tuple(loses))


def _gains(each: StoredTriad) -> FloatArray:
    """Factors for nominal readings, about 1, shape (3,)."""
    return np.asarray(each.units_per_count / each.correction.spec.nominal_scale)


def _what_is_left(each: StoredTriad, program: str, *, keeps_scale: bool) -> str:
    """The largest error that a format without T (and without K) leaves, as a note."""
    missing = each.alignment - np.eye(3)
    lost = "misalignment"
    if not keeps_scale:
        missing = matrix(each) / each.correction.spec.nominal_scale - np.eye(3)
        lost = "scale and misalignment"
    share = float(np.linalg.svd(missing, compute_uv=False)[0])
    return (
        f"{program} cannot store the {lost} of the {each.triad}: an error of up to "
        f"{100 * share:.2g} % of the reading remains."
    )


def _comment(lines: Sequence[str]) -> list[str]:
    """C comments; text that would end or begin a comment is parted, trigraphs too."""
    plain = [COMMENT_SIGNS.sub(" ", ascii_line(line)) for line in lines]
    return [f"/* {line} */" for line in plain]


def _hash_comments(lines: Sequence[str]) -> list[str]:
    """Comments of the parameter files and of the command line."""
    return [f"# {ascii_line(line)}" for line in lines]


def _c_row(values: FloatArray) -> str:
    return ", ".join(_c_float(float(value)) for value in values)


def _c_float(value: float) -> str:
    """A C constant of type float: it needs a point or an exponent before its f."""
    text = f"{value + 0.0:.9g}"
    return f"{text}f" if any(sign in text for sign in ".e") else f"{text}.0f"


def _plain_row(values: FloatArray) -> str:
    return ", ".join(f"{value:.8g}" for value in values)
