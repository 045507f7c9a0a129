"""Running the stages in front of a user: a line for each, warnings, progress of the clips."""

from pathlib import Path
from typing import Any

import click

from pipeline.commands.progress import ClipProgress
from pipeline.config.load import Config
from pipeline.console.run_text import stage_lines, stage_warnings
from pipeline.stages.context import Workplace
from pipeline.stages.run import OnStage, Outcome, run_stages

CACHE_NAME = "cache"  #: folder of the phase tracks, in that of the results


def say_waiting(folder: Path) -> None:
    """Another command is working on this session."""
    click.echo(f"{folder}: another command is working on this session; waiting for it to end "
               f"(Ctrl-C to give up)", err=True)


def show_warnings(_name: str, artefact: Any) -> None:
    """Warnings of a stage to standard error."""
    for warning in stage_warnings(artefact):
        click.secho(f"warning: {warning}", fg="yellow", err=True)


def show_stage(name: str, artefact: Any) -> None:
    """Warnings of a stage to standard error, its lines to standard output."""
    show_warnings(name, artefact)
    for line in stage_lines(name, artefact):
        click.echo(line)


def run_watched(config: Config, folder: Path, allow_python: bool = False) -> Outcome:
    """Run every stage of ``config``; phase tracks are kept in ``folder``."""
    return _run(config, folder, allow_python, show_stage)


def run_quietly(config: Config, folder: Path, allow_python: bool = False) -> Outcome:
    """The same with warnings and progress only, for commands that show what they compare."""
    return _run(config, folder, allow_python, show_warnings)


def _run(config: Config, folder: Path, allow_python: bool, show: OnStage) -> Outcome:
    with ClipProgress() as progress:

        def on_stage(name: str, artefact: Any) -> None:
            progress.close()
            show(name, artefact)

        workplace = Workplace(folder / CACHE_NAME, progress, allow_python)
        return run_stages(config, workplace, on_stage)
