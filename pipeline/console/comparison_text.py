"""Comparison of several calibrations of one sensor: a table, and a sentence on the differences."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from calib.effects.units import display_unit
from calib.poses.imu_log import Triad
from calib.rounding import duration, in_digits, two_digits
from pipeline.results.ageing import DAY_S, Ageing
from pipeline.results.comparison import ComparedParameter, ComparedTriad
from pipeline.results.fitness import parts_of_error
from pipeline.results.schema.triad import TriadSection
from pipeline.text.formatting import DISPLAY, short_model, with_sd
from pipeline.text.tables import table_lines

NONE = "-"
APART = "apart [sd]"
WHOLE = 100.0  #: sds; from here on shown without decimals: layout


def comparison_lines(compared: ComparedTriad, names: Sequence[str]) -> list[str]:
    """The table of one triad, a column for each of ``names``."""
    unit, factor = DISPLAY[compared.triad]
    rows = [[compared.triad, names[0], *(text for name in names[1:] for text in (name, APART))]]
    of_section: Mapping[str, Callable[[TriadSection], str]] = {
        "model": lambda s: short_model(s.model),
        "verdict": lambda s: s.diagnosis.verdict,
        f"RMS [{unit}]": lambda s: _scaled(s.residual_rms, factor),
        f"leave-one-out [{unit}]": lambda s: _scaled(s.loo_rms, factor),
        "chi²/dof": lambda s: f"{s.chi2 / s.dof:.2f}" if s.dof else NONE,
        f"to expect [{unit}]": lambda s: NONE if s.prediction is None else _scaled(
            s.prediction.sd_median, factor),
        "cannot see": lambda s: ", ".join(parts_of_error(s)[1]) or NONE,
    }
    for title, cell in of_section.items():
        rows.append(_row(title, [NONE if one is None else cell(one.section)
                                  for one in compared.stored]))
    for name, errors in zip(names, compared.error_on_poses, strict=True):
        if np.isfinite(errors).any():
            rows.append(_row(f"error on the poses of {name} [{unit}]",
                             [_scaled(error, factor) for error in errors]))
    rows += [_parameter_row(parameter) for parameter in compared.parameters]
    return table_lines(rows, indent="")


def conclusions(compared: ComparedTriad, names: Sequence[str]) -> Iterator[str]:
    """A sentence for each calibration on how it differs from the first."""
    for k in range(1, len(names)):
        if compared.stored[0] is not None and compared.stored[k] is not None:
            yield f"{compared.triad}: {_conclusion(compared, names, k)}"


def ageing_text(ageing: Ageing, triad: Triad) -> str:
    """Changes between the sessions, and the time when the expected error will pass the limit."""
    unit, factor = DISPLAY[triad]
    moved, noise, now, limit = (f"{two_digits(value * factor)} {unit}" for value in (
        ageing.moved, ageing.noise, ageing.now, ageing.limit))
    over = f"over {duration(ageing.days * DAY_S)}"
    if limit == now or ageing.limit <= ageing.now:
        return (f"the error to expect of the last calibration, {now}, is not below the "
                f"limit of {limit}. Calibrate better: the report shows what its sds are made of (a "
                f"rate, gravity, noise), and `pipeline plan` which poses help against noise.")
    earliest, estimate, latest = (duration(days * DAY_S) for days in ageing.due_days)
    if not ageing.most:
        return (f"{over} nothing moved beyond the noise ({noise} between sessions). The error to "
                f"expect, {now} now, will not pass {limit} for {earliest} at least (95 %), "
                f"if the sensor goes on so.")
    way = ", always the same way" if ageing.is_steady else ""
    return (f"{over} corrected magnitudes moved by {moved} from session to session beyond the "
            f"noise of {noise}{way}, {ageing.most} most. At that pace the error to expect, {now} "
            f"now, passes {limit} after {estimate} ({earliest} to {latest}): "
            f"recalibrate then.")


def _row(title: str, cells: Sequence[str], apart: Sequence[float] = ()) -> list[str]:
    """A row of the table: after each cell but the first, its distance from the first."""
    row = [f"  {title}", cells[0]]
    for cell, sds in zip(cells[1:], apart[1:] or [math.nan] * len(cells[1:]), strict=True):
        row += [cell, sds_text(sds, "+") if math.isfinite(sds) else ""]
    return row


def sds_text(value: float, sign: str = "") -> str:
    """A number of sds, to one decimal or three digits."""
    return f"{value:{sign}.1f}" if abs(value) < WHOLE else f"{value:{sign}.0f}"


def _scaled(value: float | None, factor: float) -> str:
    known = value is not None and math.isfinite(value)
    return in_digits(value * factor, 3) if value is not None and known else NONE


def _parameter_row(parameter: ComparedParameter) -> list[str]:
    unit, factor = parameter.unit, 1.0
    if parameter.is_effect:
        unit, factor = display_unit(unit, parameter.values[np.isfinite(parameter.values)])
    cells = [with_sd(value * factor, sd * factor) if math.isfinite(value) else NONE
             for value, sd in zip(parameter.values, parameter.sds, strict=True)]
    return _row(f"{parameter.name} [{unit}]", cells, parameter.apart_sd.tolist())


def _conclusion(compared: ComparedTriad, names: Sequence[str], k: int) -> str:
    first, other = names[0], names[k]
    if compared.is_same_poses(k):
        return (f"{first} and {other} are of the same poses. What differs is due to the "
                f"model or the reference, and the sds do not apply to it.")
    if not compared.is_same_sheet(k):
        return (f"{first} and {other} have other data sheets (range, bits or encoding), so counts "
                f"of one are no counts of the other: only the misalignments are compared.")
    far = compared.farthest(k)
    if far is None:
        return f"{first} and {other} have no fitted parameter in common."
    apart, limit = abs(float(far.apart_sd[k])), compared.chance_limit_sd(k)
    if apart <= limit:
        return (f"{first} and {other} agree: no parameter differs by more than "
                f"{apart:.1f} sds, and {limit:.1f} are expected by chance in 1 of 100 cases.")
    return (f"{first} and {other} differ: {far.name} by {sds_text(apart)} sds, more than the "
            f"{limit:.1f} that chance explains. Either the sensor changed between the sessions, or "
            f"a model lacks an effect, or they are of two sensors; the errors on each other's "
            f"poses show by how much.")
