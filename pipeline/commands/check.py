"""``pipeline check CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples("pipeline check config.yaml"))
@click.argument("config", type=PathArgument())
def command(config: Path) -> None:
    """Validate CONFIG, read its logs, and list every error with its line.

    The command refuses what `pipeline run` would refuse before it tracks the clips. It measures
    nothing and writes nothing.
    """
    from pipeline.config.load import load_config
    from pipeline.console.triad_text import summary_lines
    from pipeline.stages.run import check_session

    loaded = load_config(config)
    check_session(loaded)
    for line in summary_lines(loaded):
        click.echo(line)
