"""``pipeline check CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
def command(config: Path) -> None:
    """Validate CONFIG and find its files; every mistake is listed with its line.

    Nothing is measured and nothing is written.
    """
    from pipeline.config.load import load_config
    from pipeline.console.triad_text import summary_lines

    for line in summary_lines(load_config(config)):
        click.echo(line)
