"""``pipeline apply RESULTS LOG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import Finite, PathArgument

SLOWEST_HZ, FASTEST_HZ = 1e-3, 1e6  #: sample rates of inertial sensors


@click.command(epilog=examples(
    "pipeline apply config.run drive.csv --output drive.calibrated.csv",
    "pipeline apply config.run raw.txt --columns acc_x,acc_y,acc_z --rate-hz 100",
))
@click.argument("results", type=PathArgument())
@click.argument("log", type=PathArgument())
@click.option("--output", type=PathArgument(dir_okay=False),
              help="File for the corrected log; default: standard output.")
@click.option("--force", is_flag=True, help="Replace a file that this program did not write.")
@click.option("--columns",
              help="Names of the columns of a log without a header, separated by commas.")
@click.option("--rate-hz", type=Finite(min=SLOWEST_HZ, max=FASTEST_HZ),
              help="Sample rate of a log without a time column.")
@click.option("--session-clock", is_flag=True,
              help="The time of the log is that of the calibration session: correct drifts.")
@click.option("--although-unfit", is_flag=True,
              help="Use results whose data do not determine the calibration.")
@click.option("--although-unlike", is_flag=True,
              help="Correct a log that contradicts the calibration, for example by its gravity.")
@click.option("--allow-python", is_flag=True,
              help="Run the Python files of user-defined effects.")
def command(
    results: Path,
    log: Path,
    output: Path | None,
    force: bool,
    columns: str | None,
    rate_hz: float | None,
    session_clock: bool,
    although_unfit: bool,
    although_unlike: bool,
    allow_python: bool,
) -> None:
    """Correct LOG with the calibration in RESULTS (results.json or its folder); CSV in SI units.

    If RESULTS contains a mounting, both triads are rotated into the axes of the vehicle. The column
    `saturated` is 1 in samples with an axis at the end of its range. The command refuses logs that
    this sensor cannot have written, and names what lies beyond what the calibration has seen.
    """
    from pipeline.export.apply import applied_csv, apply_results
    from pipeline.export.limits import require_counts, require_gravity, warnings_of
    from pipeline.logs.clock import StatedClock
    from pipeline.logs.read import read_log
    from pipeline.results.fitness import require_fit
    from pipeline.results.read import load_results
    from pipeline.results.written import write_output

    stored = load_results(results, allow_python)
    names = None if columns is None else [name.strip() for name in columns.split(",")]
    notes = [*require_fit(stored, although_unfit)]
    readings = read_log(log, names, StatedClock(rate_hz))
    if not although_unlike:
        require_counts(stored, readings)
    applied = apply_results(stored, readings, session_clock)
    if not although_unlike:
        notes += require_gravity(stored, readings, applied)
    notes += [*applied.left_out, *warnings_of(stored, readings, session_clock)]
    for note in notes:
        click.secho(f"warning: {note}", fg="yellow", err=True)
    click.echo(f"columns are in {applied.axes}", err=True)
    if output is None:
        click.echo(applied_csv(applied), nl=False)
        return
    inputs = (log, stored.path)
    write_output(stored.folder, output, applied_csv(applied), force=force, inputs=inputs)
    click.echo(output)
