"""``pipeline plan CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--effect", "effects", multiple=True, metavar="NAME",
              help="Say what to record to see this effect; may be given several times.")
@click.option("--allow-python", is_flag=True,
              help="Let Python files of user-defined effects run.")
def command(config: Path, effects: tuple[str, ...], allow_python: bool) -> None:
    """Say what the poses of CONFIG determine, recorded and still to come, and what next.

    Before the first pose it goes by the data sheet and the sensor's typical noise, then by the
    poses that are there.
    """
    from calib.effects.catalogue import find_effect
    from pipeline.config.load import load_config, triad_spec
    from pipeline.console.plan_text import plan_lines
    from pipeline.errors import ConfigError
    from pipeline.plan.outlook import plan_of
    from pipeline.stages.user_effects import user_effects

    loaded = load_config(config, files_may_be_missing=True)
    if loaded.accelerometer is None and loaded.gyroscope is None:
        raise ConfigError(f"{config}: names no poses to plan; add the section accelerometer, "
                          "gyroscope or both.")
    for name in effects:
        if name not in loaded.effects:
            find_effect(name)  # a wrong name is said before anything slow
    for plan in plan_of(loaded, allow_python):
        sheet = getattr(loaded.sensor, plan.triad)
        user_defined = user_effects(loaded, plan.triad, allow_python)
        wanted = [user_defined[name] if name in user_defined else find_effect(name)
                  for name in effects if name in user_defined or name not in loaded.effects]
        of_triad = [effect for effect in wanted if plan.triad in effect.triads]
        for line in plan_lines(plan, of_triad, triad_spec(sheet).full_scale):
            click.echo(line)
