"""Running the stages at the terminal: a line for each, warnings, progress of the clips."""

from pathlib import Path

import click

from calib.mounting.mounting import Mounting
from pipeline.commands.interaction.output import echo_warnings
from pipeline.commands.interaction.progress import Progress
from pipeline.config.load import Config
from pipeline.console.rate_text import rate_line
from pipeline.console.run_text import installation_line, recordings_line, triad_line
from pipeline.stages.context import CACHE_NAME, RunContext
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recordings
from pipeline.stages.run import Outcome, StageResult, run_stages
from pipeline.stages.triads import TriadResult


def say_waiting(folder: Path) -> None:
    """Report that another command is working on this session."""
    click.echo(f"{folder}: another command is working on this session; waiting for it to end "
               f"(Ctrl-C to give up)", err=True)


def _line(result: StageResult) -> str:
    match result:
        case SettingRate():
            return rate_line(result)
        case Recordings():
            return recordings_line(result)
        case TriadResult():
            return triad_line(result)
    return installation_line(result)


def run_shown(
    config: Config, folder: Path, allow_python: bool = False, *, lines: bool = False,
    bars: bool = True, warnings: bool = True, before: Outcome | None = None,
) -> Outcome:
    """Run every stage of ``config`` with its warnings; phase tracks are kept in ``folder``.

    ``warnings`` prints these on standard error; without it the caller does. ``lines`` shows a line
    for each stage on standard output, ``bars`` the progress of the clips. Results of ``before``, an
    outcome with another model, are reused.
    """
    with Progress(bars) as progress:
        def show(result: StageResult) -> None:
            progress.close()
            if warnings:
                echo_warnings(result.notes if isinstance(result, Mounting) else result.warnings)
            if lines and (line := _line(result)):
                click.echo(line)

        context = RunContext(folder / CACHE_NAME, progress, allow_python)
        return run_stages(config, context, show, before)
