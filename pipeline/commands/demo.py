"""``pipeline demo [DIR]``."""

from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.output import quiet_option


@click.command(epilog=examples(
    "pipeline demo",
    "pipeline demo /tmp/demo",
))
@click.argument("folder", metavar="[DIR]", default="pipeline-demo", type=PathArgument())
@quiet_option("the path of the report")
def command(folder: Path, quiet: bool) -> None:
    """Copy the example session into DIR (default: pipeline-demo) and calibrate it.

    The session is simulated: an MPU-6050 in 18 poses at rest and on a record player at two speeds
    in both directions, with four clips. Its gyroscope has an error that the model does not
    describe. The command prints what to type to find it.
    """
    from pipeline.config.template import copy_session
    from pipeline.text.names import command as proposed

    config = copy_session(folder)
    if not quiet:
        click.echo(f"{config} was written. Now: {proposed('run', config)}", err=True)
    from pipeline.commands.run import command as run

    click.get_current_context().invoke(run, config=config, quiet=quiet)
    if quiet:
        return
    click.echo()
    click.echo(paragraph(
        "This session is yours to change. The line that begins with `next:` names the effect that "
        "is missing; the report shows the same with boxes to tick."))
    click.echo(f"afterwards: {proposed('history', config)}")
