"""The type of the fixture ``render``."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.world.film import FilmTruth

#: (motion, scene, seconds=20, ...) -> the clip and what is true of it.
Render = Callable[..., "tuple[Path, FilmTruth]"]
