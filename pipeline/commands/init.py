"""``pipeline init [DIR]``."""

from pathlib import Path

import click


@click.command()
@click.argument("folder", metavar="[DIR]", default=".", type=click.Path(path_type=Path))
def command(folder: Path) -> None:
    """Write a commented config.yaml into DIR (default: here). Never overwrites."""
    from pipeline.config.template import write_template

    path = write_template(folder)
    click.echo(f"{path} is written. Edit it, then type: pipeline check {path}")
