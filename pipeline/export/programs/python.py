"""A Python module that imports nothing but ``math``."""

from calib.poses.imu_log import SI_UNIT
from pipeline.export.parts import Export, no_sds, origin
from pipeline.export.programs.notes import notes_on
from pipeline.export.programs.routine import DOUBLE_TOLERANCE, STEPS, Routine, routine_of
from pipeline.export.programs.syntax import Syntax
from pipeline.results.read import Stored
from pipeline.text.plain import ascii_line


def _power(base: str, exponent: float) -> str:
    whole = int(exponent)
    return f"{base} ** {whole}" if whole == exponent else f"math.pow({base}, {exponent!r})"


PYTHON = Syntax(
    number=lambda value: repr(float(value)),
    power=lambda base, exponent: f"({_power(base, exponent)})",
    functions={name: f"math.{name}({{0}})" for name in ("cos", "exp", "log", "sin", "sqrt", "tanh")}
    | {"abs": "abs({0})", "sign": "(({0} > 0) - ({0} < 0))"},
    operators={},
    component=lambda vector, i: f"{vector}[{i}]",
    column=lambda name: name,
)


def to_python(stored: Stored) -> Export:
    """``imu_calibration.py``: one function for each triad, plain numbers in and out."""
    routines = [routine_of(each) for each in stored.triads]
    lines = [f"# {ascii_line(line)}" for line in origin(stored)]
    lines.append("# calibrated = T (K (counts - B) - errors), in SI units")
    if any(each.formulas for each in routines):
        lines += ["", "import math"]
    for each in routines:
        lines += ["", "", *_function(each)]
    return Export({"imu_calibration.py": "\n".join(lines) + "\n"},
                  (*no_sds(stored), *notes_on(stored, routines, "The module")))


def _function(routine: Routine) -> list[str]:
    arguments = ", ".join(name for name, _ in routine.arguments)
    notes = [f"{name}: {meaning}" for name, meaning in routine.arguments]
    notes += [f"returns three numbers in {SI_UNIT[routine.triad]}", f"example: {routine.example}"]
    count = "count"
    if routine.wraps_at is not None:
        count = f"(count - {routine.wraps_at} if count >= {routine.wraps_at // 2} else count)"
    return [
        f"def calibrate_{routine.triad}({arguments}):",
        *(f"    # {ascii_line(note)}" for note in notes),
        f"    bias = {routine.bias.tolist()!r}",
        f"    gain = {routine.gain.tolist()!r}",
        f"    alignment = {routine.alignment.tolist()!r}",
        f"    w = [k * ({count} - b) for k, count, b in zip(gain, counts, bias)]",
        *_fixed_point(routine),
        "    return [row[0] * u[0] + row[1] * u[1] + row[2] * u[2] for row in alignment]",
    ]


def _fixed_point(routine: Routine) -> list[str]:
    if not routine.formulas:
        return ["    u = w"]
    effects = ", ".join(ascii_line(each.effect) for each in routine.formulas)
    return [
        "    u = list(w)",
        f"    for _ in range({STEPS}):  # errors of {effects}",
        "        e = [",
        *(f"            {error}," for error in PYTHON.errors(routine)),
        "        ]",
        "        new = [a - b for a, b in zip(w, e)]",
        "        change = max(abs(a - b) for a, b in zip(new, u))",
        "        u = new",
        f"        if change <= {DOUBLE_TOLERANCE} * max(map(abs, u)):",
        "            break",
    ]
