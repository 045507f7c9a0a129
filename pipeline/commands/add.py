"""``pipeline add CONFIG TARGET``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.argument("target", required=False)
@click.option("--auto", is_flag=True,
              help="Repeat until nothing is missing or the data cannot tell.")
@click.option("--although-aliased", is_flag=True,
              help="Add an effect although these data cannot tell it from another.")
@click.option("--allow-python", is_flag=True,
              help="Let Python files that CONFIG names for its own effects run.")
def command(
    config: Path, target: str | None, auto: bool, although_aliased: bool, allow_python: bool
) -> None:
    """Put an effect into CONFIG (comments kept), rerun, and show before → after.

    TARGET is accelerometer.NAME, gyroscope.NAME, or rate.SETTING.TERM. What these data cannot see
    or cannot tell apart is refused, with the measurement that would allow it.
    """
    from pipeline.commands.model_change import add_until_settled, change_and_show

    if auto == (target is not None):
        raise click.UsageError("name one effect to add, as in gyroscope.g_sensitivity, or --auto")
    if target is None:
        add_until_settled(config, allow_python)
    else:
        change_and_show(config, target, allow_python, although_aliased=although_aliased)
