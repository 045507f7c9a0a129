"""``pipeline add CONFIG TARGET``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples(
    "pipeline add config.yaml gyroscope.g_sensitivity",
    "pipeline add config.yaml rate.slow.once_per_rev",
    "pipeline add config.yaml --auto",
))
@click.argument("config", type=PathArgument())
@click.argument("target", required=False)
@click.option("--auto", is_flag=True,
              help="Add effects until the diagnosis names none.")
@click.option("--although-aliased", is_flag=True,
              help="Add an effect although these data cannot separate it from another one.")
@click.option("--allow-python", is_flag=True,
              help="Run the Python files that CONFIG names for user-defined effects.")
def command(
    config: Path, target: str | None, auto: bool, although_aliased: bool, allow_python: bool
) -> None:
    """Add an effect to the model in CONFIG, run again, and print the errors before and after.

    TARGET is accelerometer.NAME, gyroscope.NAME, or rate.SETTING.TERM. Comments in CONFIG are kept.
    The command refuses an effect that these data cannot determine or cannot separate from another
    one, and states the measurement that would allow it.
    """
    from pipeline.commands.model_change import add_until_settled, change_and_show

    if auto == (target is not None):
        raise click.UsageError("name one effect to add, as in gyroscope.g_sensitivity, or --auto")
    if target is None:
        add_until_settled(config, allow_python)
    else:
        change_and_show(config, target, allow_python, although_aliased=although_aliased)
