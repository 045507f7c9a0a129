"""``pipeline check CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples("pipeline check config.yaml"))
@click.argument("config", type=PathArgument())
def command(config: Path) -> None:
    """Validate CONFIG, find its files, and list every error with its line.

    The command measures nothing and writes nothing.
    """
    from pipeline.config.load import load_config
    from pipeline.console.triad_text import summary_lines
    from pipeline.stages.logged_columns import check_covariates
    from pipeline.stages.user_effects import check_user_effects

    loaded = load_config(config)
    if loaded.effects:
        check_user_effects(loaded)
    check_covariates(loaded)
    for line in summary_lines(loaded):
        click.echo(line)
