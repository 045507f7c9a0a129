"""A model change at the command line: run, change the model, run again, show before and after."""

from collections.abc import Callable
from pathlib import Path

import click

from pipeline.commands.run_with_progress import run_quietly
from pipeline.config.load import Config, load_config
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
from pipeline.report.outputs import write_outputs
from pipeline.stages.run import Outcome


def change_and_show(
    path: Path,
    target: str,
    allow_python: bool,
    *,
    remove: bool = False,
    although_aliased: bool = False,
) -> None:
    """Change the model once; show and write what it brought."""
    config = load_config(path)
    change = change_model(
        config,
        read_target(config, target),
        _runner(config, allow_python),
        remove=remove,
        although_aliased=although_aliased,
    )
    _show(change)
    _finish(change.after, config)


def add_until_settled(path: Path, allow_python: bool) -> None:
    """Add what the diagnosis names, again and again, while the leave-one-out error falls."""
    config = load_config(path)
    run = _runner(config, allow_python)
    outcome = run(config)
    write_outputs(outcome, config.output_folder)
    refused: list[Target] = []
    for _ in range(MOST_CHANGES):
        target = next_target(outcome, refused)
        if target is None:
            break
        change = change_model(outcome.config, target, run, before=outcome, only_if_better=True)
        _show(change)
        if not predicts_better(change):
            click.echo(f"{target} is not kept: the leave-one-out error does not fall with it.")
            refused.append(target)
            continue
        outcome = change.after
        write_outputs(outcome, config.output_folder)
    for result in outcome.triads:
        click.secho(verdict_line(result), bold=True)
    if outcome.config.source.text == config.source.text:
        click.echo(f"{config.source.path} is as it was: nothing was added.")
        click.echo(next_step(outcome, config.output_folder))
        return
    _finish(outcome, config, written=True)


def _runner(config: Config, allow_python: bool) -> Callable[[Config], Outcome]:
    return lambda changed: run_quietly(changed, config.output_folder, allow_python)


def _show(change: ModelChange) -> None:
    for line in change_lines(change):
        click.echo(line)
    click.echo()


def _finish(outcome: Outcome, config: Config, written: bool = False) -> None:
    if not written:
        write_outputs(outcome, config.output_folder)
    click.echo(f"{config.source.path} is changed; `pipeline history {config.source.path}` shows "
               f"every step")
    click.echo(next_step(outcome, config.output_folder))
