"""``pipeline remove CONFIG TARGET``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import python_option, quiet_option


@click.command(epilog=examples(
    "pipeline remove config.yaml gyroscope.g_sensitivity",
    "pipeline remove config.yaml accelerometer.quadratic rate.slow.once_per_rev",
))
@click.argument("config", type=ConfigArgument())
@click.argument("targets", metavar="TARGET...", nargs=-1, required=True)
@python_option
@quiet_option("the verdicts and the next command")
def command(config: Path, targets: tuple[str, ...], allow_python: bool, quiet: bool) -> None:
    """Remove effects from the model in CONFIG and print the errors before and after.

    TARGET is accelerometer.NAME, gyroscope.NAME, or rate.SETTING.TERM. Comments in CONFIG are kept.
    """
    from pipeline.commands.interaction.model_change import Manner, change_and_show

    change_and_show(config, targets, Manner(allow_python, quiet), remove=True)
