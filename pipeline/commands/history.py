"""``pipeline history CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples("pipeline history config.yaml"))
@click.argument("config", type=PathArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder of the results, if `pipeline run` had this option.")
def command(config: Path, output: Path | None) -> None:
    """List all runs of CONFIG with model, errors and verdict. Equal runs are listed once."""
    from pipeline.config.load import load_config
    from pipeline.results.history import history_lines, read_history

    folder = output or load_config(config).output_folder
    for line in history_lines(read_history(folder)) or (
        f"{folder} contains no run yet. Type: pipeline run {config}",
    ):
        click.echo(line)
