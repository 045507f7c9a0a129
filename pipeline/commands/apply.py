"""``pipeline apply RESULTS LOG``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import RATE_HZ, PathArgument
from pipeline.commands.interaction.output import (
    echo_warnings,
    echo_whole,
    named_results,
    python_option,
)
from pipeline.logs.columns import SECONDS_PER

if TYPE_CHECKING:
    from calib.poses.imu_log import ImuLog
    from pipeline.logs.clock import StatedClock
    from pipeline.logs.columns import ColumnNames, TimeUnit
    from pipeline.results.read import Stored


@click.command(epilog=examples(
    "pipeline apply config.run drive.csv --output drive.calibrated.csv",
    "pipeline apply config.run raw.txt --columns acc_x,acc_y,acc_z --rate-hz 100",
    "pipeline apply config.run a.csv --columns time_s=t,acc_x=ax,acc_y=ay,acc_z=az --time-unit ms",
))
@click.argument("results", type=PathArgument())
@click.argument("log", type=PathArgument())
@click.option("--output", type=PathArgument(dir_okay=False),
              help="File for the corrected log; default: standard output.")
@click.option("--force", is_flag=True, help="Replace a file that this program did not write.")
@click.option("--columns",
              help="Names of the columns of a log without a header, separated by commas; or "
                   "ours=theirs for the names in its header. Default: those of the session.")
@click.option("--rate-hz", type=RATE_HZ,
              help="Sample rate of a log without a time column.")
@click.option("--time-unit", type=click.Choice(tuple(SECONDS_PER)),
              help="Unit of the time column, if its name does not state it.")
@click.option("--session-clock", is_flag=True,
              help="The time of the log is that of the calibration session: correct drifts.")
@click.option("--anyway", is_flag=True,
              help="Use results that do not determine the calibration, or correct a log that "
                   "contradicts it, for example by its gravity.")
@python_option
def command(
    results: Path,
    log: Path,
    output: Path | None,
    force: bool,
    columns: str | None,
    rate_hz: float | None,
    time_unit: "TimeUnit | None",
    session_clock: bool,
    anyway: bool,
    allow_python: bool,
) -> None:
    """Correct LOG with the calibration in RESULTS; CSV in SI units.

    RESULTS is results.json, its folder, or the configuration that was run. If it contains a
    mounting, both triads are rotated into the axes of the vehicle. The column `saturated` is 1 in
    samples with an axis at the end of its range. The command refuses logs that this sensor cannot
    have written, and lists the values outside the range of the calibration.
    """
    from calib.errors import CalibrationError
    from pipeline.errors import PipelineError
    from pipeline.export.apply import applied_csv, apply_results
    from pipeline.export.limits import compare_with_gravity, require_counts, warnings_of
    from pipeline.export.parts import stood_for
    from pipeline.logs.clock import StatedClock
    from pipeline.logs.read import read_log
    from pipeline.results.fitness import require_fit
    from pipeline.results.inputs import files_of_session, require_no_pose
    from pipeline.results.written import write_output

    stored = named_results(results, allow_python)
    if output is not None:
        require_no_pose(stored, output)
    notes = [*require_fit(stored, anyway)]
    clock = StatedClock(rate_hz, time_unit)
    readings = (_read_as_session(log, stored, clock) if columns is None
                else read_log(log, _columns(columns), clock))
    try:
        require_counts(stored, readings)
    except (PipelineError, CalibrationError) as refused:
        if not anyway:
            raise
        notes.append(f"--anyway overrules: {refused}")
    applied = apply_results(stored, readings, session_clock)
    try:
        notes += compare_with_gravity(stored, readings, applied)
    except (PipelineError, CalibrationError) as refused:
        if not anyway:
            raise
        notes.append(f"--anyway overrules: {refused}")
    notes += [*applied.left_out, *stood_for(stored), *warnings_of(stored, readings, session_clock)]
    echo_warnings(notes)
    click.echo(f"columns are in {applied.axes}", err=True)
    if output is None:
        echo_whole(applied_csv(applied))
        return
    write_output(stored.folder, output, applied_csv(applied), force=force,
                 inputs=(log, results, *files_of_session(stored)))
    click.echo(output)


def _read_as_session(log: Path, stored: "Stored", clock: "StatedClock") -> "ImuLog":
    """The log by the ``columns`` of the session where they fit, else by its own header; the sample
    rate of the session is that of a log without times.

    A file of several sensors is read by the tables of the session's file.
    """
    from dataclasses import replace
    from itertools import zip_longest

    from pipeline.errors import NoReadings, UnreadableInput
    from pipeline.guess.sensor_files import hint_of
    from pipeline.logs.columns import Renamed
    from pipeline.logs.formats.kinds import split_member
    from pipeline.logs.join import join_logs
    from pipeline.logs.read import read_log

    rates = stored.contents.sample_rates_hz
    clocks = [clock] if clock.rate_hz or len(rates) != 1 else [
        clock, replace(clock, rate_hz=rates[0])]
    sensor = hint_of(log)  # of the files of two sensors whose columns have the same names
    stated = sorted(zip_longest(stored.contents.columns, stored.contents.tables, fillvalue=""),
                    key=lambda row: not any(name.startswith(sensor) for name in row[0]))
    rows = [*((table, Renamed(tuple(row.items())) if isinstance(row, dict) else row)
              for row, table in stated), ("", None)]
    named = split_member(log)[1]
    of_tables = [(log / table, names) for table, names in rows if table and not named]
    for parts in [of_tables, *([(log, names)] for table, names in rows if named in ("", table))]:
        for time in clocks if parts else ():
            try:
                return join_logs([read_log(path, names, time) for path, names in parts])
            except UnreadableInput:  # another logger's file, or one with a header of our names
                continue
    try:
        return read_log(log, None, clock)
    except UnreadableInput as error:
        if isinstance(error, NoReadings) or not log.is_file():
            raise  # there are no columns that an option could name
        raise UnreadableInput(
            f"{error} Here `--columns acc_x=THEIRS,...` names them, and `--time-unit` states the "
            f"unit of the time.") from error


def _columns(typed: str) -> "ColumnNames":
    """``acc_x,acc_y,acc_z``, or ``acc_x=ax,acc_y=ay,acc_z=az`` as pairs of names."""
    from pipeline.logs.columns import Renamed

    names = [name.strip() for name in typed.split(",")]
    if "=" not in typed:
        return names
    pairs = [tuple(part.strip() for part in name.split("=", 1)) for name in names]
    if any(len(pair) != 2 for pair in pairs):
        raise click.UsageError("--columns: write all as ours=theirs, or none")
    return Renamed(tuple((pair[0], pair[1]) for pair in pairs))
