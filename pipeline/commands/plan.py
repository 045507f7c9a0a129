"""``pipeline plan CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples(
    "pipeline plan config.yaml",
    "pipeline plan config.yaml --effect g_sensitivity",
))
@click.argument("config", type=PathArgument())
@click.option("--effect", "effects", multiple=True, metavar="NAME",
              help="Print what to record to determine this effect; may be repeated.")
@click.option("--allow-python", is_flag=True,
              help="Run the Python files of user-defined effects.")
def command(config: Path, effects: tuple[str, ...], allow_python: bool) -> None:
    """Print what the poses of CONFIG determine, and which pose to record next.

    Before the first pose the command uses the data sheet and the typical noise of the sensor, later
    the recorded poses and those that are still missing.
    """
    from calib.effects.catalogue import find_effect
    from pipeline.config.load import load_config
    from pipeline.config.sensor import triad_spec
    from pipeline.console.plan_text import plan_lines
    from pipeline.errors import ConfigError
    from pipeline.plan.outlook import plan_of
    from pipeline.stages.user_effects import user_effects

    loaded = load_config(config, files_may_be_missing=True)
    if loaded.accelerometer is None and loaded.gyroscope is None:
        raise ConfigError(f"{config}: contains no poses to plan. Add the section accelerometer, "
                          "gyroscope or both.")
    for name in effects:
        if name not in loaded.effects:
            find_effect(name)  # a wrong name is an error before anything slow
    for plan in plan_of(loaded, allow_python):
        sheet = getattr(loaded.sensor, plan.triad)
        user_defined = user_effects(loaded, plan.triad, allow_python)
        wanted = [user_defined[name] if name in user_defined else find_effect(name)
                  for name in effects if name in user_defined or name not in loaded.effects]
        of_triad = [effect for effect in wanted if plan.triad in effect.triads]
        for line in plan_lines(plan, of_triad, triad_spec(sheet).full_scale):
            click.echo(line)
