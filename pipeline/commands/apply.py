"""``pipeline apply RESULTS LOG``."""

from pathlib import Path

import click


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.argument("log", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path, dir_okay=False),
              help="The file to write, instead of standard output.")
@click.option("--columns", help="Names of the log's columns, with commas, where it has no header.")
@click.option("--rate-hz", type=click.FloatRange(min=0, min_open=True),
              help="Sample rate, where the log has no time.")
@click.option("--session-clock", is_flag=True,
              help="The log's time counts on the clock of the calibration session: correct drifts.")
def command(
    results: Path,
    log: Path,
    output: Path | None,
    columns: str | None,
    rate_hz: float | None,
    session_clock: bool,
) -> None:
    """Correct LOG by RESULTS (results.json, or its folder): CSV in SI units.

    Where RESULTS have an installation, both triads are turned into the vehicle's axes.
    """
    from pipeline.export.apply import applied_csv, apply_results
    from pipeline.files import write_whole
    from pipeline.logs.read import read_log
    from pipeline.results.read import load_results

    stored = load_results(results)
    names = None if columns is None else [name.strip() for name in columns.split(",")]
    applied = apply_results(stored, read_log(log, names, rate_hz), session_clock)
    for says in applied.left_out:
        click.secho(f"warning: {says}", fg="yellow", err=True)
    click.echo(f"columns are in {applied.axes}", err=True)
    if output is None:
        click.echo(applied_csv(applied), nl=False)
        return
    write_whole(output, applied_csv(applied))
    click.echo(output)
