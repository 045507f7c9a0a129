"""What may be typed: paths that a system can have, and numbers that are finite."""

import math
from pathlib import Path
from typing import Any

import click

from pipeline.files import LONGEST_NAME

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


class Finite(click.FloatRange):
    """A finite number within limits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; ``nan``, ``inf`` and what lies outside the limits are refused."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is no finite number.", param, ctx)
        return number


POSITIVE = Finite(min=0, min_open=True)  #: by definition
LATITUDE_DEG = Finite(min=-90, max=90)  #: by definition
HEIGHT_M = Finite(min=-500, max=9000)  #: of places on land
