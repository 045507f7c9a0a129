"""Options that state the unit of a gyroscope, and a log that is read by them."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.interaction.arguments import POSITIVE

if TYPE_CHECKING:
    from calib.poses.imu_log import ImuLog

UNITS = ("rad_s", "deg_s", "mrad_s", "mdeg_s", "ddeg_s", "cdeg_s", "deg_h", "rpm")
PARAMETER = "gyroscope_scale"


def gyroscope_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """``--gyroscope-range``, ``--gyroscope-unit``; one of them is the parameter gyroscope_scale."""
    of_unit = click.option(
        "--gyroscope-unit", type=click.Choice(UNITS), expose_value=False, callback=_state,
        help="Unit of a gyroscope, where nothing in the logs shows it.")
    of_range = click.option(
        "--gyroscope-range", type=POSITIVE, metavar="DEG_S", expose_value=False, callback=_state,
        help="Full scale of a gyroscope in counts, in °/s, where nothing shows it.")
    return of_range(of_unit(command))


def _state(context: click.Context, _: click.Parameter, value: str | float | None) -> None:
    if value is not None and context.params.get(PARAMETER) is not None:
        raise click.UsageError("--gyroscope-range and --gyroscope-unit both state the unit of the "
                               "gyroscope; give one of them.")
    context.params[PARAMETER] = context.params.get(PARAMETER) or value


def log_in_si(
    log: Path, config: Path | None, gyroscope_scale: str | float | None,
    rate_hz: float | None = None,
) -> "ImuLog":
    """The readings of a log in SI units, by a configuration or by guesses that are printed."""
    from pipeline.guess.readings import readings_in_si

    if config is not None and gyroscope_scale is not None:
        raise click.UsageError("--config states the unit of the gyroscope; leave out "
                               "--gyroscope-range and --gyroscope-unit.")
    return readings_in_si(
        log, config, rate_hz, gyroscope_scale,
        lambda line: click.echo(f"guessed: {line}; --config states it", err=True))
