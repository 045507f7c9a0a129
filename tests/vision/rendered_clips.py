"""The fixture ``render``: its type, a scene of few pixels, and how far a rate is from the truth."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.world.scene import Scene

if TYPE_CHECKING:
    from tests.world.film import FilmTruth
    from tests.world.plate import PlateMotion
    from vision.rate.measure import RateMeasurement

#: (motion, scene, seconds=20, ...) -> the clip and what is true of it.
Render = Callable[..., "tuple[Path, FilmTruth]"]


def small_scene(**what: Any) -> Scene:
    """Two thirds as wide and as high as other scenes: it is rendered and followed in half the time.

    For what turns on how frames are stored or shown, not on how well an edge is seen.
    """
    return Scene(**{"width_px": 320, "height_px": 240, "centre_px": (154.0, 122.0),
                    "radius_px": 95.3, **what})


def error_ppm(rate: "RateMeasurement", motion: "PlateMotion") -> float:
    """Error of the signed rate, relative to that of the plate."""
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    return (signed / motion.rate_rad_s - 1) * 1e6
