"""``pipeline add CONFIG TARGET``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import python_option, quiet_option


@click.command(epilog=examples(
    "pipeline add config.yaml gyroscope.g_sensitivity",
    "pipeline add config.yaml accelerometer.quadratic accelerometer.temperature_bias",
    "pipeline add config.yaml rate.slow.once_per_rev",
    "pipeline add config.yaml --auto",
))
@click.argument("config", type=ConfigArgument())
@click.argument("targets", metavar="[TARGET...]", nargs=-1)
@click.option("--auto", is_flag=True,
              help="Add effects until the diagnosis names none.")
@click.option("--anyway", is_flag=True,
              help="Add an effect that these data do not show, or cannot separate from another.")
@python_option
@quiet_option("the verdicts and the next command")
def command(
    config: Path, targets: tuple[str, ...], auto: bool, anyway: bool, allow_python: bool,
    quiet: bool,
) -> None:
    """Add effects to the model in CONFIG, run again, and print the errors before and after.

    TARGET is accelerometer.NAME, gyroscope.NAME, or rate.SETTING.TERM. Comments in CONFIG are kept.
    Several effects are added one after the other; if one is refused, CONFIG stays as it was. What
    the diagnosis names can always be added. The command refuses any other effect that these data
    cannot determine, do not show or cannot separate from another one, and states the measurement
    that would allow it.
    """
    from pipeline.commands.interaction.model_change import (
        Manner,
        add_until_settled,
        change_and_show,
    )

    if auto == bool(targets):
        raise click.UsageError("name effects to add, as in gyroscope.g_sensitivity, or --auto")
    manner = Manner(allow_python, quiet)
    if auto:
        add_until_settled(config, manner)
    else:
        change_and_show(config, targets, manner, anyway=anyway)
