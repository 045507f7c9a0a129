"""Which attitudes the poses cover, and which the design of 18 wedge poses expects."""

from dataclasses import dataclass

import numpy as np

from calib.poses.attitudes import (
    NEAR_COSINE,
    WEDGE_DIRECTIONS,
    list_directions,
    natural_directions,
)
from calib.poses.imu_log import FloatArray
from pipeline.text.formatting import count

LAID_WITHIN = float(np.cos(np.radians(10.0)))
"""The recording guide asks for the wedge poses to 10°; directions at random lie 17° off."""
MOST_REPEATS = 2.0
"""Times the median number of poses in a direction: a design lays all of them equally often."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """The expected directions, each with whether a pose is near, and a sentence.

    ``expected`` is empty where the poses do not follow the design: then no direction is missing.
    """

    expected: tuple[tuple[FloatArray, bool], ...]
    caption: str


def coverage_of(directions: FloatArray) -> Coverage:
    """The coverage of unit vectors (n, 3), NaN for poses without a direction."""
    known = directions[np.isfinite(directions).all(axis=1)]
    if not len(known):
        return Coverage((), "These poses have no known direction: the plate was stopped and no "
                            "accelerometer was logged.")
    natural = natural_directions()
    near = natural @ known.T  # (26, n)
    covered = near.max(axis=1) >= NEAR_COSINE
    faces, corners = int(covered[:WEDGE_DIRECTIONS].sum()), int(covered[WEDGE_DIRECTIONS:].sum())
    if not _follows_design(near, faces):
        return Coverage((), f"{count(len(known), 'pose')}. They do not follow the design of 6 "
                            f"faces and 12 edges, so no direction is marked as missing.")
    caption = (f"{count(len(known), 'pose')} cover {faces} of the 18 faces and edges and "
               f"{corners} of the 8 corners.")
    if faces < WEDGE_DIRECTIONS:
        missing = list_directions(natural[:WEDGE_DIRECTIONS][~covered[:WEDGE_DIRECTIONS]])
        caption += f" These directions are missing: {missing}."
    return Coverage(tuple(zip(natural, map(bool, covered), strict=True)), caption)


def _follows_design(near: FloatArray, faces: int) -> bool:
    """Whether poses were laid on the 26 directions; ``near`` (26, n) are the cosines to them.

    Poses laid by hand come near many of them too, some again and again: they are no design with
    missing directions.
    """
    repeats = np.bincount(near.argmax(axis=0))
    repeats = repeats[repeats > 0]
    return bool(
        faces > WEDGE_DIRECTIONS / 2
        and np.median(near.max(axis=0)) >= LAID_WITHIN
        and repeats.max() <= MOST_REPEATS * np.median(repeats)
    )
