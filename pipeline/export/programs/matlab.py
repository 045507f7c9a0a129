"""MATLAB (and Octave) functions of whole logs: a row for each sample."""

from calib.poses.imu_log import SI_UNIT, FloatArray
from pipeline.export.parts import Export, no_sds, origin
from pipeline.export.programs.notes import notes_on
from pipeline.export.programs.routine import DOUBLE_TOLERANCE, STEPS, Routine, routine_of
from pipeline.export.programs.syntax import Syntax
from pipeline.results.read import Stored
from pipeline.text.plain import ascii_line

MATLAB = Syntax(
    number=lambda value: repr(float(value)),
    power=lambda base, exponent: f"({base} .^ ({float(exponent)!r}))",
    functions={name: f"{name}({{0}})"
               for name in ("abs", "cos", "exp", "log", "sign", "sin", "sqrt", "tanh")},
    operators={"*": ".*", "/": "./"},
    component=lambda vector, i: f"{vector}(:, {i + 1})",
    column=lambda name: f"{name}(:)",
)


def to_matlab(stored: Stored) -> Export:
    """``calibrate_accelerometer.m`` and ``calibrate_gyroscope.m``."""
    routines = [routine_of(each) for each in stored.triads]
    files = {f"calibrate_{each.triad}.m": "\n".join(_function(stored, each)) + "\n"
             for each in routines}
    return Export(files, (*no_sds(stored), *notes_on(stored, routines, "The function")))


def _function(stored: Stored, routine: Routine) -> list[str]:
    arguments = ", ".join(name for name, _ in routine.arguments)
    notes = [*(f"{name}: {meaning}" for name, meaning in routine.arguments),
             f"All have a row for each sample; si is in {SI_UNIT[routine.triad]}.",
             f"Example: {routine.example}", *origin(stored)]
    codes = routine.wraps_at
    wrapped = [f"  counts = counts - {codes} * (counts >= {codes // 2});"] if codes else []
    return [
        f"function si = calibrate_{routine.triad}({arguments})",
        *(f"% {ascii_line(note)}" for note in notes),
        f"  bias = [{_row(routine.bias)}];",
        f"  gain = [{_row(routine.gain)}];",
        f"  alignment = [{'; '.join(map(_row, routine.alignment))}];",
        *wrapped,
        "  w = bsxfun(@times, bsxfun(@minus, counts, bias), gain);",
        "  u = w;",
        *_fixed_point(routine),
        "  si = u * alignment';",
        "end",
    ]


def _fixed_point(routine: Routine) -> list[str]:
    if not routine.formulas:
        return []
    effects = ", ".join(ascii_line(each.effect) for each in routine.formulas)
    return [
        f"  % errors of {effects}",
        "  e = zeros(size(u));",
        f"  for step = 1:{STEPS}",
        *(f"    e(:, {i + 1}) = {error};" for i, error in enumerate(MATLAB.errors(routine))),
        "    change = max(max(abs(w - e - u)));",
        "    u = w - e;",
        f"    if change <= {DOUBLE_TOLERANCE} * max(max(abs(u)))",
        "      break",
        "    end",
        "  end",
    ]


def _row(values: FloatArray) -> str:
    return ", ".join(repr(float(value)) for value in values)
