"""A box with its axes in an attitude, as lines on paper.

The box is longest along x and flat along z, as a sensor's board is. It stands as it does on the
plate: the wanted side up, seen obliquely from above.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from calib.poses.imu_log import AXES, FloatArray

HALF_SIZES = np.array([1.0, 0.7, 0.3])  #: half sizes of the box along x, y, z
ARROW = 1.55  #: length of an axis' arrow
SEEN_FROM_DEG = (-60.0, 25.0)  #: azimuth and elevation of the eye


@dataclass(frozen=True, eq=False)
class Line:
    """A straight line on paper, ``ends`` (2, 2), y upwards; ``axis`` of an arrow, else empty."""

    ends: FloatArray
    axis: str = ""
    hidden: bool = False


def box_lines(up: FloatArray) -> list[Line]:
    """The edges of the box and its axes, with the side ``up`` (3,) of the sensor upwards.

    Returns
    -------
    list of Line
        In units of half the box's length; the middle of the box is the origin.
    """
    to_room = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0]
    corners = np.array(list(product((-1, 1), repeat=3))) * HALF_SIZES
    room = to_room.apply(corners)
    paper, depth = _seen(room)
    farthest = int(np.argmax(depth))
    edges = [(i, j) for i in range(8) for j in range(i + 1, 8)
             if np.count_nonzero(corners[i] != corners[j]) == 1]
    lines = [Line(paper[[i, j]], hidden=farthest in (i, j)) for i, j in edges]
    for name, direction in zip(AXES, np.eye(3), strict=True):
        reach = np.vstack([np.zeros(3), direction * ARROW])
        lines.append(Line(_seen(to_room.apply(reach))[0], name))
    return lines


def plate_outline(radius: float, below: float, points: int = 72) -> FloatArray:
    """The rim of a level plate under the box, (points, 2), in units of half its length; no unit."""
    turn = np.linspace(0, 2 * np.pi, points)
    rim = np.column_stack([radius * np.cos(turn), radius * np.sin(turn),
                           np.full(points, -below)])
    return _seen(rim)[0]


def _seen(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places (n, 2) on paper, and how far behind it (n,)."""
    azimuth, elevation = np.radians(SEEN_FROM_DEG)
    away = -np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                      np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    upward = np.cross(right, away)
    return np.column_stack([points @ right, points @ upward]), np.asarray(points @ away)
