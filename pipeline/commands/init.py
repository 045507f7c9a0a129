"""``pipeline init [DIR]``."""

import sys
from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import (
    HEIGHT_M,
    LATITUDE_DEG,
    PathArgument,
    ask_latitude,
)

POSES, BENCH, LEANING = "poses.svg", "bench.svg", "leaning.svg"
"""Pictures copied beside the configuration; they are in ``data/docs``."""


@click.command(epilog=examples(
    "pipeline init my-session",
    "pipeline init my-session --latitude 59.91 --height 20",
    "pipeline init my-session --tilted",
))
@click.argument("folder", metavar="[DIR]", default=".", type=PathArgument())
@click.option("--latitude", type=LATITUDE_DEG,
              help="Latitude of the site in degrees, which determines gravity.")
@click.option("--height", type=HEIGHT_M, default=0.0,
              help="Height of the site in metres; with --latitude.")
@click.option("--tilted", is_flag=True,
              help="Both triads from a record player with 5 cm under one side.")
def command(folder: Path, latitude: float | None, height: float, tilted: bool) -> None:
    """Write a commented config.yaml and drawings of bench and poses into DIR (default: here).

    On a terminal the command asks for the latitude of the site. Without one the file states gravity
    anywhere on Earth with its uncertainty. The command never overwrites a file.
    """
    from pipeline.config.template import shipped_file, site_text, template_text, write_template
    from pipeline.files import write_whole
    from pipeline.text.names import command as proposed

    if latitude is None and sys.stdin.isatty():
        latitude = ask_latitude()
    site = None if latitude is None else site_text(latitude, height)
    path = write_template(folder, template_text(site, tilted))
    poses, bench, leaning = sheets = [path.parent / name for name in (POSES, BENCH, LEANING)]
    for sheet in sheets:
        if not sheet.exists() and (tilted or sheet != leaning):
            write_whole(sheet, shipped_file("docs", sheet.name).read_bytes())
    click.echo(f"{path} was written. Edit it, then type: {proposed('plan', path)}, and with the "
               f"logs in place: {proposed('check', path)}")
    under = f", {leaning} what to put under the player" if tilted else ""
    click.echo(f"{poses} shows the 18 poses, {bench} the plate with its marks, the camera and a "
               f"wedge{under}; print them for the bench.")

