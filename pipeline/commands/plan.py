"""``pipeline plan CONFIG``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import echo_json, json_option, python_option, quiet_option

if TYPE_CHECKING:
    from calib.effects.effect import Effect
    from calib.poses.imu_log import Triad
    from pipeline.config.load import Config


@click.command(epilog=examples(
    "pipeline plan config.yaml",
    "pipeline plan config.yaml --effect g_sensitivity",
    "pipeline plan config.yaml --json | jq .gyroscope.complete.sd_scale_relative",
))
@click.argument("config", type=ConfigArgument())
@click.option("--effect", "effects", multiple=True, metavar="NAME",
              help="Print what to record to determine this effect; may be repeated.")
@python_option
@json_option("the outlook of each triad")
@quiet_option("what the poses do not determine")
def command(
    config: Path, effects: tuple[str, ...], allow_python: bool, as_json: bool, quiet: bool
) -> None:
    """Print what the poses of CONFIG determine, and which pose to record next.

    Before the first pose the command uses the data sheet and the typical noise of the sensor, later
    the recorded poses and those that are still missing. If all these poses together cannot
    determine the model, the exit code is 4.
    """
    from calib.effects.catalogue import find_effect
    from pipeline.config.load import load_config
    from pipeline.config.sensor import triad_spec
    from pipeline.console.plan_text import plan_json, plan_lines
    from pipeline.errors import ConfigError
    from pipeline.plan.outlook import plan_of
    from pipeline.plan.so_far import require_sufficient

    loaded = load_config(config, files_may_be_missing=True)
    if not loaded.triads:
        raise ConfigError(f"{config}: contains no poses to plan. Add the section accelerometer, "
                          "gyroscope or both.")
    for name in effects:
        if name not in loaded.effects:
            find_effect(name)  # a wrong name is an error before anything slow
    plans = tuple(plan_of(loaded, allow_python))
    if as_json:
        echo_json({plan.triad: plan_json(plan) for plan in plans})
    for plan in plans if not (as_json or quiet) else ():
        sheet = getattr(loaded.sensor, plan.triad)
        wanted = _effects_of(loaded, plan.triad, effects, allow_python)
        click.echo("\n".join(plan_lines(plan, wanted, triad_spec(sheet).full_scale)))
    require_sufficient(config, plans, reasons=as_json or quiet)


def _effects_of(
    config: "Config", triad: "Triad", names: Sequence[str], allow_python: bool
) -> "list[Effect]":
    """The named effects that act on ``triad``."""
    from calib.effects.catalogue import find_effect
    from pipeline.stages.user_effects import user_effects

    user_defined = user_effects(config, triad, allow_python)
    wanted = [user_defined[name] if name in user_defined else find_effect(name)
              for name in names if name in user_defined or name not in config.effects]
    return [effect for effect in wanted if triad in effect.triads]
