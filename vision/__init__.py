"""From a clip of a turning plate to its angular rate.

Conventions, everywhere in this package
---------------------------------------
Pixels
    ``(x, y)``, x to the right, y down; the centre of the top left pixel is (0, 0). Sizes and
    positions are in pixels of the analysed frame (a large clip is reduced by a whole factor).
Plate coordinates
    ``(u, v)`` in the plane of the plate, spindle at (0, 0), v upwards in an untilted frame.
Angles
    Radians; positive is counter-clockwise as filmed.
Time
    Seconds, from the first frame of the clip, as the container states it.

The way of the data
-------------------
::

    clip ─ video ─ plate ─ tracking ─ phase_track ─ rate ─ RateMeasurement
                   geometry                         camera ─ clip (live)

``video``         a clip as luma frames with their time stamps, in display orientation
``geometry``      the view: plate coordinates to pixels and back
``plate``         where the plate is and what it looks like (``PlateModel``)
``tracking``      the plate's angle in every frame (``track_phase``: clip to ``PhaseTrack``)
``phase_track``   the result of the tracking: arrays only
``image_return``  the period after which the picture repeats, without a plate
``rate``          the rate and its standard deviation (``measure_rate``), with NumPy alone
``overlay``       the clip with the measurement drawn on it
``live_plate``    the present picture of a camera, with rim and mark
``camera``        films a clip with a live camera
``errors``        the failures, by what the user can do about them
``numbers``       facts: of units and of the normal distribution
``clip_rate``     all of this in one call, for a notebook (``vision.measure_rate``)
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vision.clip_rate import measure_rate

__all__ = ["measure_rate"]


def __dir__() -> list[str]:
    """Names that a notebook completes."""
    return list(__all__)


def __getattr__(name: str) -> Any:
    """Load a name on its first use: the command line imports this package too."""
    if name != "measure_rate":
        raise AttributeError(f"module 'vision' has no attribute {name!r}")
    from vision.clip_rate import measure_rate

    return measure_rate
