"""Types of arguments: paths that a system can have, and finite numbers."""

import math
from pathlib import Path
from typing import Any

import click

from pipeline.files import LONGEST_NAME

CONFIG_NAME = "config.yaml"  #: file that `pipeline init` writes
LISTED = 5  #: files of a folder that a message names
SHOWN = 60  #: characters of a wrong argument that a message repeats
LONGEST_S = 86_400.0  #: a day; a longer duration is a slip of the keyboard


class PathArgument(click.Path):
    """A path whose names a file system can hold."""

    def __init__(self, **kinds: bool) -> None:
        super().__init__(path_type=Path, **kinds)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path; a name with a zero byte or of more than 255 bytes is refused."""
        text = str(value)
        if "\0" in text:
            self.fail("the name of a file cannot contain a zero byte.", param, ctx)
        for name in Path(text).parts:
            size = len(name.encode(errors="surrogateescape"))
            if size > LONGEST_NAME:
                self.fail(f"the name {name[:SHOWN]}... has {size} bytes; a file system holds names "
                          f"of at most {LONGEST_NAME}.", param, ctx)
        return super().convert(value, param, ctx)


class ConfigArgument(PathArgument):
    """The file of a configuration, or the folder that contains it as ``config.yaml``."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path of the file; in a folder the ``config.yaml`` or the only YAML file."""
        path: Path = super().convert(value, param, ctx)
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
LATITUDE_DEG = Finite(min=-90, max=90)  #: range by definition
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
