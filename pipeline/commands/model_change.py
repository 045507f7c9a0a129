"""Turns of the loop in front of a user: run, change the model, run again, show both sides."""

from collections.abc import Callable
from pathlib import Path

import click

from pipeline.commands.run_with_progress import run_quietly, say_waiting
from pipeline.config.load import Config
from pipeline.console.model_change_text import turn_lines
from pipeline.console.run_text import next_step, verdict_line
from pipeline.model_change import MOST_TURNS, Turn, next_target, read_target, turn
from pipeline.report.outputs import outputs_of
from pipeline.session_folder import working_on, write_session
from pipeline.stages.run import Outcome


def make_turn(
    path: Path,
    target: str,
    allow_python: bool,
    *,
    remove: bool = False,
    although_aliased: bool = False,
) -> None:
    """One change of the model, shown and written."""
    with working_on(path, on_wait=say_waiting) as (config, folder):
        done = turn(
            config,
            read_target(config, target),
            _runner(folder, allow_python),
            remove=remove,
            although_aliased=although_aliased,
        )
        _show(done)
        _write(done, folder)
    _finish(done.after, folder)


def add_until_settled(path: Path, allow_python: bool) -> None:
    """Add what the diagnosis names, again and again, until it names nothing more."""
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = _runner(folder, allow_python)
        outcome = run(config)
        write_session(folder, outputs_of(outcome, folder))
        for _ in range(MOST_TURNS):
            target = next_target(outcome)
            if target is None:
                break
            done = turn(outcome.config, target, run, before=outcome)
            _show(done)
            _write(done, folder)
            outcome = done.after
    for result in outcome.triads:
        click.secho(verdict_line(result), bold=True)
    if outcome.config.source.text == config.source.text:
        click.echo(f"{path} is as it was: nothing was added.")
        click.echo(next_step(outcome, folder))
        return
    _finish(outcome, folder)


def _runner(folder: Path, allow_python: bool) -> Callable[[Config], Outcome]:
    return lambda config: run_quietly(config, folder, allow_python)


def _show(done: Turn) -> None:
    for line in turn_lines(done):
        click.echo(line)
    click.echo()


def _write(done: Turn, folder: Path) -> None:
    """The configuration and its results change together."""
    text = done.after.config.source.text
    write_session(folder, outputs_of(done.after, folder), done.before.config, text)


def _finish(outcome: Outcome, folder: Path) -> None:
    path = outcome.config.source.path
    click.echo(f"{path} is changed; `pipeline history {path}` shows every step")
    click.echo(next_step(outcome, folder))
