"""``pipeline exclude CONFIG POSE``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import python_option, quiet_option


@click.command(epilog=examples(
    "pipeline exclude config.yaml gyroscope.pose_07",
    "pipeline exclude config.yaml accelerometer.pose_03 accelerometer.pose_12",
))
@click.argument("config", type=ConfigArgument())
@click.argument("poses", metavar="POSE...", nargs=-1, required=True)
@python_option
@quiet_option("the verdicts and the next command")
def command(config: Path, poses: tuple[str, ...], allow_python: bool, quiet: bool) -> None:
    """Leave poses out of the fit in CONFIG and print the errors before and after.

    POSE is accelerometer.NAME or gyroscope.NAME, with NAME as `pipeline run` prints it, the file's
    for example. The names stand as `exclude` in CONFIG; delete one there to take its pose back in.
    """
    from pipeline.commands.interaction.model_change import Manner, exclude_and_show

    exclude_and_show(config, poses, Manner(allow_python, quiet))
