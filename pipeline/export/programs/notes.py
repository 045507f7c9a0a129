"""What a program in source code does not correct, and what it assumes."""

from collections.abc import Sequence

from pipeline.export.parts import lost_effects
from pipeline.export.programs.routine import Routine
from pipeline.results.read import Stored


def notes_on(stored: Stored, routines: Sequence[Routine], program: str) -> tuple[str, ...]:
    """A note on each triad whose effects are not all in the program, or need a caller's care."""
    notes: list[str] = []
    for each, routine in zip(stored.triads, routines, strict=True):
        lost = [name for name in routine.left_out if name in each.effects]
        notes += lost_effects(stored, each, lost, program)
        if any(one.column == "time_s" for one in routine.inputs):
            timed = [one.effect for one in routine.formulas if "time_s" in one.names]
            notes.append(
                f"{', '.join(timed)} of the {each.triad} holds on the clock of the calibration "
                f"session: pass time_s in seconds since its first sample. On another day it is not "
                f"known.")
        further = [f"{one.identifier} ({one.meaning})" for one in routine.inputs
                   if one.column != "time_s"]
        further += ["force (the corrected specific force)"] if routine.needs_force else []
        if further:
            notes.append(f"calibrate_{each.triad} also takes {', '.join(further)}.")
    return tuple(notes)
