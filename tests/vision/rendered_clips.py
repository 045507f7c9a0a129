"""The type of the fixture ``render``, and a scene for what does not depend on many pixels."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.world.scene import Scene

if TYPE_CHECKING:
    from tests.world.film import FilmTruth

#: (motion, scene, seconds=20, ...) -> the clip and what is true of it.
Render = Callable[..., "tuple[Path, FilmTruth]"]


def small_scene(**what: Any) -> Scene:
    """Two thirds as wide and as high as other scenes: it is rendered and followed in half the time.

    For what turns on how frames are stored or shown, not on how well an edge is seen.
    """
    return Scene(**{"width_px": 320, "height_px": 240, "centre_px": (154.0, 122.0),
                    "radius_px": 95.3, **what})
