"""The complete correction as source code: one template for each language."""

from collections.abc import Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined

from pipeline.export.parts import Export, lost_effects, no_sds, origin
from pipeline.export.programs.routine import STEPS, Routine, routine_of
from pipeline.export.programs.syntax import MATLAB, PYTHON, C, Syntax
from pipeline.results.read import Stored


def to_arduino(stored: Stored) -> Export:
    """``imu_calibration.h``: one function for each triad, with a worked number."""
    routines = _routines(stored)
    text = _source("imu_calibration.h", C, stored, routines)
    return Export({"imu_calibration.h": text}, _notes(stored, routines, "The header"))


def to_python(stored: Stored) -> Export:
    """``imu_calibration.py``: one function for each triad, plain numbers in and out."""
    routines = _routines(stored)
    text = _source("imu_calibration.py", PYTHON, stored, routines)
    return Export({"imu_calibration.py": text}, _notes(stored, routines, "The module"))


def to_matlab(stored: Stored) -> Export:
    """``calibrate_accelerometer.m`` and ``calibrate_gyroscope.m``."""
    routines = _routines(stored)
    files = {f"calibrate_{one.triad}.m": _source("calibrate.m", MATLAB, stored, [one])
             for one in routines}
    return Export(files, _notes(stored, routines, "The function"))


def _routines(stored: Stored) -> list[Routine]:
    return [routine_of(triad) for triad in stored.triads]


def _source(
    template: str, syntax: Syntax, stored: Stored, routines: Sequence[Routine]
) -> str:
    environment = Environment(
        loader=PackageLoader("pipeline.export", "templates"), undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    environment.filters |= {"comment": syntax.comment, "number": syntax.number}
    return environment.get_template(f"{template}.jinja").render(
        routines=routines, origin=origin(stored), syntax=syntax, steps=STEPS)


def _notes(stored: Stored, routines: Sequence[Routine], program: str) -> tuple[str, ...]:
    """Effects that the program does not correct, and its assumptions."""
    notes: list[str] = [*no_sds(stored)]
    for triad, routine in zip(stored.triads, routines, strict=True):
        lost = [name for name in routine.left_out if name in triad.section.effects]
        notes += lost_effects(stored, triad, lost, program)
        if any(one.column == "time_s" for one in routine.inputs):
            timed = [one.effect for one in routine.formulas if "time_s" in one.names]
            notes.append(
                f"{', '.join(timed)} of the {triad.name} holds on the clock of the calibration "
                f"session: pass time_s in seconds since its first sample. On another day it is not "
                f"known.")
        further = [f"{one.identifier} ({one.meaning})" for one in routine.inputs
                   if one.column != "time_s"]
        further += ["force (the corrected specific force)"] if routine.needs_force else []
        if further:
            notes.append(f"calibrate_{triad.name} also takes {', '.join(further)}.")
    return tuple(notes)
