"""A box with its axes in an attitude: in SVG, and in dots on a terminal.

The box is longest along x and flat along z, as a sensor's board is. It stands as it does on the
plate: the wanted side up, seen obliquely from above.
"""

from dataclasses import dataclass
from html import escape
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from calib.poses.attitudes import direction_name
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


def level_circle(radius: float, below: float, ahead: float = 0.0) -> FloatArray:
    """A circle on the plate ``below`` the box's middle, its own ``ahead`` of it, (72, 2), no unit.
    """
    turn = np.linspace(0, 2 * np.pi, 72)
    return _seen(np.column_stack([radius * np.cos(turn), ahead + radius * np.sin(turn),
                                  np.full(72, -below)]))[0]


def _seen(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places (n, 2) on paper, and depths behind it (n,)."""
    azimuth, elevation = np.radians(SEEN_FROM_DEG)
    away = -np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                      np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    upward = np.cross(right, away)
    return np.column_stack([points @ right, points @ upward]), np.asarray(points @ away)


CELL, SCALE = 170, 42  #: px: of a drawing, and of half the box's length
PLATE = 1.75  #: radius, in units of half the box's length; of a picture
COLOURS = {"x": "#1f5fa8", "y": "#b3541e", "z": "#2b7a44"}  #: colours of the axes in all charts


def pose_svg(up: FloatArray) -> str:
    """One pose, the side ``up`` (3,) of the sensor upwards, as the text of an SVG."""
    name = escape(direction_name(up))
    x0 = y0 = CELL / 2
    below = float(np.abs(up) @ HALF_SIZES)  # of the box, below its middle
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {CELL} {CELL + 24}" '
             f'font-family="sans-serif" font-size="12" role="img" aria-label="{name}">',
             '<rect width="100%" height="100%" fill="white"/>',
             f'<polyline points="{_points(level_circle(PLATE, below), x0, y0)}" fill="#f2f2f2" '
             'stroke="#999"/>',
             f'<polygon points="{_points(level_circle(MARK, below, 1.1 * MARK - PLATE), x0, y0)}" '
             'fill="#f4d03f" stroke="#999"/>']
    parts += [f'<polygon points="{_points(face, x0, y0)}" fill="#b9770e" fill-opacity="0.2" '
              'stroke="#b9770e"/>' for face in wedge_faces(up)]
    for line in box_lines(up):
        colour = COLOURS.get(line.axis, "#333")
        dash = ' stroke-dasharray="3 3"' if line.hidden else ""
        wide = ' stroke-width="2"' if line.axis else ""
        parts.append(f'<polyline points="{_points(line.ends, x0, y0)}" fill="none" '
                     f'stroke="{colour}"{wide}{dash}/>')
        if line.axis:
            x, y = line.ends[1] * 1.15
            parts.append(f'<text x="{x0 + SCALE * x:.1f}" y="{y0 - SCALE * y + 4:.1f}" '
                         f'fill="{colour}" stroke="white" stroke-width="3" paint-order="stroke" '
                         f'font-weight="bold" text-anchor="middle">{line.axis}</text>')
    parts.append(f'<text x="{x0:.1f}" y="{y0 + CELL / 2 + 14:.1f}" text-anchor="middle">'
                 f"{name}</text>\n</svg>")
    return "\n".join(parts)


def _points(places: FloatArray, x0: float, y0: float) -> str:
    return " ".join(f"{x0 + SCALE * x:.1f},{y0 - SCALE * y:.1f}" for x, y in places)


COLUMNS, ROWS = 26, 11  #: columns and rows of signs
SPAN = 1.75  #: half the width of the drawing, in half lengths of the box
#: Bit of a dot by its row and column in a sign.
BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
BLANK = 0x2800  #: the sign without dots


def box_text(up: FloatArray) -> list[str]:
    """The box with the side ``up`` (3,) upwards, as lines of text."""
    dots = np.zeros((4 * ROWS, 2 * COLUMNS), bool)
    labels: dict[tuple[int, int], str] = {}
    for line in box_lines(up):
        _draw(dots, line)
        if line.axis:
            column, row = _dot(line.ends[1] * 1.1)
            place = np.clip([row // 4, column // 2], 0, [ROWS - 1, COLUMNS - 1])
            labels[int(place[0]), int(place[1])] = line.axis
    signs = (dots.reshape(ROWS, 4, COLUMNS, 2) * BITS[None, :, None, :]).sum(axis=(1, 3))
    return ["".join(labels.get((row, column), chr(BLANK + int(signs[row, column])))
                    for column in range(COLUMNS)) for row in range(ROWS)]


def _dot(place: FloatArray) -> tuple[int, int]:
    """Column and row of the dot at a place on paper."""
    return (round((place[0] / SPAN + 1) * COLUMNS), round((1 - place[1] / SPAN) * 2 * ROWS))


def _draw(dots: np.ndarray, line: Line) -> None:
    (x0, y0), (x1, y1) = _dot(line.ends[0]), _dot(line.ends[1])
    count = max(abs(x1 - x0), abs(y1 - y0), 1) + 1
    columns = np.rint(np.linspace(x0, x1, count)).astype(int)
    rows = np.rint(np.linspace(y0, y1, count)).astype(int)
    step = 3 if line.hidden else 2 if line.axis else 1
    inside = (columns >= 0) & (columns < dots.shape[1]) & (rows >= 0) & (rows < dots.shape[0])
    inside &= np.arange(count) % step == 0
    dots[rows[inside], columns[inside]] = True
