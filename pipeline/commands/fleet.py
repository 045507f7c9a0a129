"""``pipeline fleet 'GLOB' --output DIR``, or one table of pose means with ``--design``."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.output import echo_whole, python_option

if TYPE_CHECKING:
    from pipeline.fleet.finish import FleetSummary
    from pipeline.fleet.limits import Limits


@click.command(epilog=examples(
    "pipeline fleet 'sessions/*/config.yaml' --output lot",
    "pipeline fleet 'lot7/{sensor}/*/config.yaml' --output lot7.fleet --workers 8",
    "pipeline fleet 'sessions/*/config.yaml' --output lot --scheduler tcp://10.0.0.5:8786",
    "pipeline fleet lot.parquet --design design.yaml --output lot",
    "pipeline fleet 'lot7/*/config.yaml' --output lot7.fleet --limits limits.yaml",
))
@click.argument("patterns", metavar="GLOB", nargs=-1, required=True)
@click.option("--output", type=PathArgument(file_okay=False), required=True,
              help="Folder for the table, the report, and the results of each session.")
@click.option("--design", type=PathArgument(exists=True, dir_okay=False), default=None,
              help="Configuration of one sensor without logs; GLOB is then one table.")
@click.option("--limits", "limits_path", type=PathArgument(exists=True, dir_okay=False),
              default=None, help="Limits on columns of the table (YAML): pass, fail or undecided.")
@click.option("--scheduler", metavar="ADDRESS",
              help="Scheduler of a Dask cluster, as tcp://HOST:PORT; default: this machine.")
@click.option("--workers", type=click.IntRange(min=1), default=None,
              help="Processes on this machine; default: one for each processor.")
@click.option("--reports/--no-reports", default=True,
              help="Write report.html of each session, about 1 MB.  [default: reports]")
@click.option("--json", "as_json", is_flag=True, help="Print population.json instead of text.")
@click.option("--quiet", is_flag=True, help="Print the path of the report only.")
@python_option
def command(
    patterns: tuple[str, ...], output: Path, design: Path | None, limits_path: Path | None,
    scheduler: str | None, workers: int | None, reports: bool, as_json: bool, quiet: bool,
    allow_python: bool,
) -> int:
    """Run many sessions, and write one table of all of them.

    Needs the extra `fleet`: pip install 'turntable-imu-calibration[fleet]'.

    GLOB is a pattern of configurations; in quotes, {sensor} in it matches any text, as * does, and
    this text names the sensor: the command compares the sessions of a sensor with each other. A
    session that fails does not stop the others; the table states the reason. The command fails if
    no session is calibrated. If you type it again, it continues where it stopped and runs only
    sessions whose files have changed.

    With --design, GLOB is a table (Parquet or CSV) with a row for each pose of each sensor: sensor,
    pose, run, the means acc_x ... gyr_z in counts and their sds sd_acc_x ..., and where they are
    known time_s, temperature_c and station. All sensors are fitted side by side, without a report
    of each.
    """
    from pipeline.fleet.finish import OUTPUTS, fleet_lines
    from pipeline.fleet.limits import read_limits
    from pipeline.fleet.page import PAGE_NAME
    from pipeline.fleet.population import POPULATION_NAME
    from pipeline.fleet.table import require_libraries
    from pipeline.results.written import require_written

    if scheduler is not None and workers is not None:
        raise click.UsageError("--workers counts processes of this machine; a scheduler has its "
                               "own workers. Leave one of the two out.")
    require_libraries()
    limits = None if limits_path is None else read_limits(limits_path)
    where = output.resolve()
    require_written(where, OUTPUTS)
    if design is None:
        summary = _sessions(patterns, where, scheduler, workers, reports, quiet, allow_python,
                            limits)
    elif len(patterns) > 1:
        raise click.UsageError(f"--design expects one table; {len(patterns)} files are named.")
    else:
        summary = _table(Path(patterns[0]), where, design, allow_python, limits)
    if as_json:
        echo_whole((output / POPULATION_NAME).read_bytes())
    elif quiet:
        click.echo(output / PAGE_NAME)
    else:
        for line in fleet_lines(summary):
            click.echo(paragraph(line, "  "))
    return summary.exit_code


def _sessions(
    patterns: tuple[str, ...], output: Path, scheduler: str | None, workers: int | None,
    reports: bool, quiet: bool, allow_python: bool, limits: "Limits | None",
) -> "FleetSummary":
    """Run the sessions of a pattern, or of the files that a shell made of it, on Dask."""
    from pipeline.commands.interaction.progress import Progress
    from pipeline.errors import DONE
    from pipeline.fleet.cluster import connected, run_fleet
    from pipeline.fleet.finish import finish_fleet
    from pipeline.fleet.sessions import SessionRecord, find_sessions, named_sessions
    from pipeline.fleet.worker import FleetTask

    sessions = find_sessions(*patterns) if len(patterns) == 1 else named_sessions(patterns)
    tasks = [FleetTask(session, output, allow_python, reports) for session in sessions]
    records: list[SessionRecord] = []
    failed = 0
    with (
        connected(scheduler, min(workers or os.cpu_count() or 1, len(tasks))) as client,
        Progress(not quiet, "sessions") as progress,
    ):
        progress("fleet", 0, len(tasks))

        def on_record(record: SessionRecord) -> None:
            nonlocal failed
            records.append(record)
            failed += record.exit_code != DONE
            progress("fleet", len(records), len(tasks),
                     f", {failed} not calibrated" if failed else "")

        run_fleet(client, tasks, on_record)
    return finish_fleet(records, output, reports, limits)


def _table(
    table: Path, output: Path, design: Path, allow_python: bool, limits: "Limits | None"
) -> "FleetSummary":
    """Calibrate the sensors of one table."""
    from pipeline.errors import UnreadableInput
    from pipeline.fleet.lot_run import run_lot
    from pipeline.fleet.lot_sets import LotSets, load_design
    from pipeline.fleet.lot_table import TABLES
    from pipeline.stages.context import RunContext

    if table.suffix.lower() not in TABLES or not table.is_file():
        raise UnreadableInput(f"{table}: with --design one table is expected, an existing file "
                              f"whose name ends in .parquet or .csv.")
    sets = LotSets.of(load_design(design, table), table, RunContext(allow_python=allow_python))
    return run_lot(sets, output, limits)
