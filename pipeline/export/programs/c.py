"""A C header: C89 but for ``inline``, single precision, nothing but ``math.h``."""

import re
from collections.abc import Iterable, Sequence

from calib.poses.imu_log import FloatArray
from pipeline.export.parts import Export, no_sds, origin
from pipeline.export.programs.notes import notes_on
from pipeline.export.programs.routine import STEPS, Routine, routine_of
from pipeline.export.programs.syntax import Syntax
from pipeline.results.read import Stored
from pipeline.text.plain import ascii_line

COMMENT_SIGNS = re.compile(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)")
SHORT = {"accelerometer": "ACC", "gyroscope": "GYR"}
TOLERANCE = "1e-6f"  #: relative change at which the fixed point ends; a float has 6e-8


def c_float(value: float) -> str:
    """A C constant of type float: it needs a point or an exponent before its f."""
    text = f"{value + 0.0:.9g}"
    return f"{text}f" if any(sign in text for sign in ".e") else f"{text}.0f"


def c_row(values: FloatArray) -> str:
    """Constants separated by commas."""
    return ", ".join(c_float(float(value)) for value in values)


def c_comments(lines: Iterable[str]) -> list[str]:
    """C comments; text that would end or begin a comment is parted, trigraphs too."""
    plain = [COMMENT_SIGNS.sub(" ", ascii_line(line)) for line in lines]
    return [f"/* {line} */" for line in plain]


def _power(base: str, exponent: float) -> str:
    whole = int(exponent)
    if whole == exponent and whole > 0:
        return f"({' * '.join([base] * whole)})"
    return f"powf({base}, {c_float(exponent)})"


C = Syntax(
    number=c_float,
    power=_power,
    functions={name: f"{name}f({{0}})" for name in ("cos", "exp", "log", "sin", "sqrt", "tanh")}
    | {"abs": "fabsf({0})", "sign": "(float)(({0} > 0.0f) - ({0} < 0.0f))"},
    operators={},
    component=lambda vector, i: f"{vector}[{i}]",
    column=lambda name: name,
)


def to_arduino(stored: Stored) -> Export:
    """``imu_calibration.h``: one function for each triad, with a worked number."""
    routines = [routine_of(each) for each in stored.triads]
    lines = [
        *c_comments([*origin(stored), "calibrated = T * (K * (counts - B) - errors), in SI units"]),
        "#ifndef IMU_CALIBRATION_H",
        "#define IMU_CALIBRATION_H",
    ]
    if any(each.formulas for each in routines):
        lines += ["", "#include <math.h>"]
    for each in routines:
        lines += ["", *_function(each)]
    lines += ["", "#endif"]
    return Export({"imu_calibration.h": "\n".join(lines) + "\n"},
                  (*no_sds(stored), *notes_on(stored, routines, "The header")))


def _function(routine: Routine) -> list[str]:
    name = SHORT[routine.triad]
    parameters = ["const float counts[3]"]
    parameters += ["const float force[3]"] if routine.needs_force else []
    parameters += [f"float {each.identifier}" for each in routine.inputs]
    parameters.append("float si[3]")
    return [
        *c_comments([f"{routine.triad}: {routine.example}",
                     *(f"{argument}: {meaning}" for argument, meaning in routine.arguments[1:])]),
        f"static const float {name}_B[3] = {{{c_row(routine.bias)}}};",
        f"static const float {name}_K[3] = {{{c_row(routine.gain)}}};",
        f"static const float {name}_T[3][3] = {{",
        *(f"    {{{c_row(row)}}}," for row in routine.alignment),
        "};",
        "",
        f"static inline void calibrate_{routine.triad}({', '.join(parameters)})",
        "{",
        *_indented(["float u[3];", *(_fixed_point_names(routine)), "int i;",
                    *_nominal(routine, name)]),
        *_indented(_fixed_point(routine)),
        *_indented(["for (i = 0; i < 3; i++) {",
                    f"    si[i] = {name}_T[i][0] * u[0] + {name}_T[i][1] * u[1] + "
                    f"{name}_T[i][2] * u[2];",
                    "}"]),
        "}",
    ]


def _nominal(routine: Routine, name: str) -> list[str]:
    """u from the counts, before the effects."""
    target = "w[i] = u[i]" if routine.formulas else "u[i]"
    count = "counts[i]"
    if routine.wraps_at is not None:
        half, codes = c_float(routine.wraps_at / 2), c_float(float(routine.wraps_at))
        count = f"(counts[i] >= {half} ? counts[i] - {codes} : counts[i])"
    return ["for (i = 0; i < 3; i++) {", f"    {target} = {name}_K[i] * ({count} - {name}_B[i]);",
            "}"]


def _fixed_point_names(routine: Routine) -> list[str]:
    return ["float w[3], e[3], change, size;", "int step;"] if routine.formulas else []


def _fixed_point(routine: Routine) -> list[str]:
    """Iteration of ``u = w - e(u)``."""
    if not routine.formulas:
        return []
    return [
        *c_comments([f"errors of {', '.join(each.effect for each in routine.formulas)}"]),
        f"for (step = 0; step < {STEPS}; step++) {{",
        *_indented(f"e[{i}] = {error};" for i, error in enumerate(C.errors(routine))),
        "    change = size = 0.0f;",
        "    for (i = 0; i < 3; i++) {",
        "        change += fabsf(w[i] - e[i] - u[i]);",
        "        u[i] = w[i] - e[i];",
        "        size += fabsf(u[i]);",
        "    }",
        f"    if (change <= {TOLERANCE} * size) break;",
        "}",
    ]


def _indented(lines: Iterable[str] | Sequence[str]) -> list[str]:
    return [f"    {line}" for line in lines]
