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
MARK = 0.18  #: radius of the mark on the rim; of a picture
NO_PART = 1e-6  #: part of a direction that counts as none
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


def wedge_faces(up: FloatArray) -> list[FloatArray]:
    """The wedge under a box that stands on an edge: its back, sides and slope, (k, 2) each.

    Empty where a face is up, and where a corner is: a corner stands in a folded card.
    """
    tilted = np.flatnonzero(np.abs(up) > NO_PART)
    if len(tilted) != 2:
        return []
    along = int(np.flatnonzero(np.abs(up) <= NO_PART)[0])
    to_room = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0]
    # The box lies on the larger of the two faces that look down.
    flat = int(min(tilted, key=lambda i: HALF_SIZES[i]))
    other = int(next(i for i in tilted if i != flat))
    foot = np.where(np.abs(up) > NO_PART, -np.sign(up) * HALF_SIZES, 0.0)
    top = foot.copy()
    top[other] += 2 * np.sign(up[other]) * HALF_SIZES[other]
    ends = []
    for side in (-1.0, 1.0):
        shift = np.eye(3)[along] * side * HALF_SIZES[along]
        low, high = to_room.apply([foot + shift, top + shift])
        ends.append(np.array([low, high, [high[0], high[1], low[2]]]))
    slope = np.array([ends[0][0], ends[0][1], ends[1][1], ends[1][0]])
    back = np.array([ends[0][2], ends[0][1], ends[1][1], ends[1][2]])
    return [_seen(face)[0] for face in (back, *ends, slope)]


def rim_mark(radius: float, below: float, points: int = 24) -> FloatArray:
    """The mark near the rim of the plate under the box, (points, 2), in the same units."""
    turn = np.linspace(0, 2 * np.pi, points)
    mark = np.column_stack([MARK * np.cos(turn), 1.1 * MARK - radius + MARK * np.sin(turn),
                            np.full(points, -below)])
    return _seen(mark)[0]


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
