"""Types of arguments: paths, finite numbers, and the unit of a gyroscope with its log."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.logs.columns import SAMPLE_RATES_HZ

if TYPE_CHECKING:
    from calib.poses.imu_log import ImuLog


CONFIG_NAME = "config.yaml"  #: file that `pipeline init` writes
LISTED = 5  #: files of a folder that a message names
LONGEST_S = 86_400.0  #: a day; a longer duration is a slip of the keyboard


class PathArgument(click.Path):
    """A path."""

    def __init__(self, **kinds: bool) -> None:
        super().__init__(path_type=Path, **kinds)


class ConfigArgument(PathArgument):
    """The file of a configuration, or the folder that contains it as ``config.yaml``."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path of the file; in a folder the ``config.yaml`` or the only YAML file."""
        path: Any = super().convert(value, param, ctx)
        if not path.is_dir():
            return path
        every = sorted([*path.glob("*.yaml"), *path.glob("*.yml")])
        if (path / CONFIG_NAME) in every:
            return path / CONFIG_NAME
        if len(every) == 1:
            return every[0]
        names = ", ".join(file.name for file in every[:LISTED]) or "no YAML file"
        self.fail(f"{path} is a folder without {CONFIG_NAME}; it has {names}. Name the "
                  "configuration itself.", param, ctx)


class Finite(click.FloatRange):
    """A finite number within limits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; ``nan``, ``inf`` and numbers outside the limits are refused."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is no finite number.", param, ctx)
        return number


POSITIVE = Finite(min=0, min_open=True)  #: range by definition
RATE_HZ = Finite(*SAMPLE_RATES_HZ)
LATITUDE = re.compile(r"(?P<before>[NS]?)\s*(?P<deg>[-+]?\d+(?:[.,]\d*)?)\s*(?:°|º|deg)?\s*"
                      r"(?P<behind>[NS]?)", re.IGNORECASE)


class Latitude(Finite):
    """Degrees, negative in the south, with a point or a comma; N or S may state the side."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The latitude in degrees; an error shows answers that are read."""
        typed = LATITUDE.fullmatch(str(value).strip())
        sides = typed["before"] + typed["behind"] if typed else ""
        if not typed or len(sides) > 1 or (sides and typed["deg"][0] in "+-"):
            self.fail(f"{value!r} is no latitude in decimal degrees. Type 59.91 or 59.91 N; south "
                      f"of the equator -33.87 or 33.87 S. East or west is the longitude, which is "
                      f"not needed.", param, ctx)
        degrees = typed["deg"].replace(",", ".")
        return super().convert(f"-{degrees}" if sides in ("S", "s") else degrees, param, ctx)


LATITUDE_DEG = Latitude(min=-90, max=90)  #: range by definition
HEIGHT_M = Finite(min=-500, max=9000)  #: range of places on land


def ask_latitude() -> float | None:
    """Ask for the latitude of the site in degrees; None if it is left out."""
    latitude: float | None = click.prompt(
        "Latitude of your site in degrees (Enter leaves it out)", default="",
        show_default=False, err=True, value_proc=_latitude)
    return latitude


def _latitude(typed: str) -> float | None:
    if not typed.strip():
        return None
    latitude: float = LATITUDE_DEG.convert(typed, None, None)
    return latitude


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
