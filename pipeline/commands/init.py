"""``pipeline init [DIR]``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples("pipeline init my-session"))
@click.argument("folder", metavar="[DIR]", default=".", type=PathArgument())
def command(folder: Path) -> None:
    """Write a commented config.yaml into DIR (default: the current folder).

    The command never overwrites a file.
    """
    from pipeline.config.template import write_template

    path = write_template(folder)
    click.echo(f"{path} was written. Edit it, then type: pipeline check {path}")
