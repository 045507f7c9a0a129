"""A model change at the terminal: run, change the model, run again, print both results."""

from collections.abc import Callable
from pathlib import Path

import click

from pipeline.commands import paragraph
from pipeline.commands.run_with_progress import run_quietly, say_waiting
from pipeline.config.load import Config
from pipeline.console.model_change_text import change_lines
from pipeline.console.run_text import next_step, verdict_line
from pipeline.model_change import (
    MOST_CHANGES,
    ModelChange,
    Target,
    change_model,
    next_target,
    predicts_better,
    read_target,
)
from pipeline.report.outputs import outputs_of
from pipeline.session_folder import working_on, write_session
from pipeline.stages.run import Outcome


def change_and_show(
    path: Path,
    target: str,
    allow_python: bool,
    *,
    remove: bool = False,
    although_aliased: bool = False,
) -> None:
    """Make one change of the model; print it and write the results."""
    with working_on(path, on_wait=say_waiting) as (config, folder):
        change = change_model(
            config,
            read_target(config, target),
            _runner(folder, allow_python),
            remove=remove,
            although_aliased=although_aliased,
        )
        _show(change)
        _write(change, folder)
    _finish(change.after, folder)


def add_until_settled(path: Path, allow_python: bool) -> None:
    """Add what the diagnosis names, again and again, while the leave-one-out error falls."""
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = _runner(folder, allow_python)
        outcome = run(config)
        write_session(folder, outputs_of(outcome, folder))
        refused: list[Target] = []
        for _ in range(MOST_CHANGES):
            target = next_target(outcome, refused)
            if target is None:
                break
            change = change_model(outcome.config, target, run, before=outcome)
            _show(change)
            if not predicts_better(change):
                click.echo(f"{target} is not kept: the leave-one-out error does not fall with it.")
                refused.append(target)
                continue
            _write(change, folder)
            outcome = change.after
    for result in outcome.triads:
        click.secho(paragraph(verdict_line(result)), bold=True)
    if outcome.config.source.text == config.source.text:
        click.echo(f"{path} was not changed: the diagnosis names no effect to add.")
        click.echo(next_step(outcome, folder))
        return
    _finish(outcome, folder)


def _runner(folder: Path, allow_python: bool) -> Callable[[Config], Outcome]:
    return lambda config: run_quietly(config, folder, allow_python)


def _show(change: ModelChange) -> None:
    for line in change_lines(change):
        click.echo(line)
    click.echo()


def _write(change: ModelChange, folder: Path) -> None:
    """The configuration and its results change together."""
    text = change.after.config.source.text
    write_session(folder, outputs_of(change.after, folder), change.before.config, text)


def _finish(outcome: Outcome, folder: Path) -> None:
    path = outcome.config.source.path
    click.echo(f"{path} was changed. `pipeline history {path}` lists all runs.")
    click.echo(next_step(outcome, folder))
