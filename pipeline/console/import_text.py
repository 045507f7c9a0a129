"""Output of `pipeline import`: columns with the reasons, the first rows, and doubts."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from calib.numbers import RPM
from calib.poses.imu_log import TEMPERATURE, TRIADS
from pipeline.config.types import STOPPED
from pipeline.guess.checked import CheckedConfig
from pipeline.guess.session import PoseSource, SessionGuess
from pipeline.guess.table_guess import TableGuess
from pipeline.logs.clock import EPOCH_S
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME, our_name
from pipeline.text.formatting import count
from pipeline.text.tables import table_lines

ROWS_SHOWN = 3  #: first rows of a table: enough to see a unit by; chosen
LONGEST_NAMES = 44  #: characters of a triad's columns
FURTHER = 4  #: columns that a line names; layout
TABLES_SHOWN = 3  #: tables shown of files that are all the same; chosen

LAYOUTS = {"files": "each is one pose", "log": "the static intervals are the poses",
           "means": "each row is the mean of a pose"}


def guess_lines(guess: SessionGuess) -> Iterator[str]:
    """The first table of each set of poses, and doubts."""
    known: set[TableGuess] = set()
    rates: dict[tuple[TableGuess, ...], list[str]] = {}
    for source in guess.sources:
        rates.setdefault(source.tables, []).append(_rate(guess, source))
    for source in {source.tables: source for source in guess.sources}.values():
        shown = source.tables[:1] if source.layout == "files" else source.tables[:TABLES_SHOWN]
        for table in (table for table in shown if table not in known):
            known.add(table)
            yield from guessed_table(table)
        yield (f"{count(len(source.tables), 'table')}, {', '.join(rates[source.tables])}: "
               f"{LAYOUTS[source.layout]}")
        yield ""
    if guess.doubts:
        yield "not sure:"
        for doubt in guess.doubts:
            yield f"  - {doubt}"


def _rate(guess: SessionGuess, source: PoseSource) -> str:
    """The rate of the plate in a source, in words."""
    is_dead = "gyroscope" in guess.dead
    if guess.gyroscope is not None and guess.gyroscope.is_unusual:
        return "at rest or turning, by what unit the gyroscope has"
    if source.rate == STOPPED and source.layout == "log" and not source.has("gyroscope"):
        return "taken as at rest, since no gyroscope shows a plate"
    if source.rate == STOPPED:
        return "at rest or turned about the dead axis" if is_dead else "at rest"
    clip = f", as in {source.clip.path.name}" if source.clip else ""
    return "turning" if guess.scales or is_dead else (
        f"turning at {source.rate_rad_s / RPM:+.4g} rpm{clip}")


def guessed_table(table: TableGuess) -> list[str]:
    """The columns of one table with their units and reasons, and its first rows."""
    clock, rate_hz = table.clock, _rate_hz(table)
    seconds = float(clock.time_s[-1] - clock.time_s[0])
    rate = f", {rate_hz:.4g} Hz, {seconds:.4g} s" if seconds and rate_hz else ""
    lines = [f"{table.path}: {count(table.table.rows, 'row')}{'' if table.are_means else rate}"]
    rows = []
    if clock.column is not None:
        rows.append(["  time", clock.column, clock.unit or f"{our_name(clock.column)[1]:g} s",
                     clock.because])
    elif not table.are_means:
        shown = "not known" if clock.rate_hz is None else f"{clock.rate_hz:g} Hz"
        rows.append(["  time", "-", shown, clock.because])
    for name in TRIADS:
        triad = getattr(table, name)
        if triad is not None:
            rows.append([f"  {name}", _names(triad.columns), triad.unit, triad.because])
    if table.further:
        more = f" and {len(table.further) - FURTHER} more" if table.further[FURTHER:] else ""
        rows.append(["  further", ", ".join(table.further[:FURTHER]) + more, "",
                     "logged beside them"])
    lines += table_lines(rows)
    readings = [name for name in table.theirs if our_name(name)[0] in (
        TIME, *ACCELEROMETER, *GYROSCOPE, TEMPERATURE)]
    head = [[f"  {name}" if i == 0 else name for i, name in enumerate(readings)]]
    for row in range(min(ROWS_SHOWN, table.table.rows)):
        values = [_cell(table.table.columns[table.theirs[name]][row]) for name in readings]
        head.append([f"  {values[0]}", *values[1:]])
    return [*lines, "  first rows:", *table_lines(head)]


def _cell(value: float) -> str:
    """A number of a log; stamps since 1970 keep their milliseconds."""
    if float(value).is_integer():
        return f"{value:.0f}"
    return f"{value:.3f}" if abs(value) > EPOCH_S[0] else f"{value:.10g}"


def _names(columns: Sequence[str]) -> str:
    """Three names, or the first and the last of long ones."""
    whole = ", ".join(columns)
    if len(whole) <= LONGEST_NAMES:
        return whole
    return f"{columns[0]} to {columns[-1]}"


def guess_json(guess: SessionGuess, checked: CheckedConfig) -> dict[str, Any]:
    """The same output for programs."""
    return {
        "tables": [
            {
                "path": str(table.path),
                "rows": table.table.rows,
                "columns": table.theirs,
                "rate_hz": _rate_hz(table),
                "time_unit": table.clock.unit,
                "are_means": table.are_means,
                "accelerometer": dict(table.accelerometer.sheet) if table.accelerometer else None,
                "gyroscope": dict(table.gyroscope.sheet) if table.gyroscope else None,
                "turning_rad_s": table.turning_rad_s,
            }
            for table in guess.tables
        ],
        "doubts": list(guess.doubts),
        "changes": list(checked.changes),
        "runs": checked.outcome is not None,
        "fault": checked.fault,
    }


def _rate_hz(table: TableGuess) -> float | None:
    """The usual sample rate: lost rows, whose steps are nearer to two than to one, leave it."""
    if table.clock.column is None:
        return table.clock.rate_hz
    step = np.diff(table.clock.time_s)
    usual = step[step < 1.5 * np.median(step)]
    return float(1 / usual.mean()) if usual.size and usual.mean() > 0 else None
