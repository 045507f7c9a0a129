"""The 18 poses on a plate as a sheet in SVG, to be printed and laid beside the record player."""

from html import escape

import numpy as np

from calib.poses.attitudes import direction_name, natural_directions
from calib.poses.imu_log import FloatArray
from pipeline.drawings.box import HALF_SIZES, box_lines, plate_outline, rim_mark, wedge_faces

CELL, SCALE = 170, 42  #: px: of a drawing, and of half the box's length
PLATE = 1.75  #: radius, in units of half the box's length; of a picture
PER_ROW = 6  #: drawings beside each other
COLOURS = {"x": "#c0392b", "y": "#1e8449", "z": "#2471a3"}  #: colours of the axes, as elsewhere


def poses_svg(corners: bool = False) -> str:
    """The faces and edges (and ``corners``), each with its name, as the text of an SVG."""
    directions = natural_directions(corners)
    rows = -(-len(directions) // PER_ROW)
    width, height = PER_ROW * CELL, rows * (CELL + 24)
    cells = "\n".join(_cell(direction, i) for i, direction in enumerate(directions))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" font-family="sans-serif" font-size="12">\n'
            f"<title>The {len(directions)} poses of a sensor on the plate</title>\n"
            f'<rect width="100%" height="100%" fill="white"/>\n{cells}\n</svg>\n')


def pose_svg(up: FloatArray) -> str:
    """One pose, the side ``up`` (3,) of the sensor upwards, as the text of an SVG."""
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {CELL} {CELL + 24}" '
            f'font-family="sans-serif" font-size="12" role="img" '
            f'aria-label="{escape(direction_name(up))}">\n'
            f'<rect width="100%" height="100%" fill="white"/>\n{_cell(up)}\n</svg>')


def _cell(up: FloatArray, number: int | None = None) -> str:
    """The drawing of one pose, with its number where it is one of many."""
    name = escape(direction_name(up))
    words = name if number is None else f"{number + 1}  {name}"
    number = number or 0
    x0 = number % PER_ROW * CELL + CELL / 2
    y0 = number // PER_ROW * (CELL + 24) + CELL / 2
    below = _lowest(up)
    parts = [f'<polyline points="{_points(plate_outline(PLATE, below), x0, y0)}" fill="#f2f2f2" '
             'stroke="#999"/>',
             f'<polygon points="{_points(rim_mark(PLATE, below), x0, y0)}" fill="#f4d03f" '
             'stroke="#999"/>']
    parts += [f'<polygon points="{_points(face, x0, y0)}" fill="#b9770e" fill-opacity="0.35" '
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
                         f'fill="{colour}" text-anchor="middle">{line.axis}</text>')
    parts.append(f'<text x="{x0:.1f}" y="{y0 + CELL / 2 + 14:.1f}" text-anchor="middle">'
                 f"{words}</text>")
    return "\n".join(parts)


def _lowest(up: FloatArray) -> float:
    """How far the box reaches below its middle, with the side ``up`` upwards."""
    return float(np.abs(up) @ HALF_SIZES)


def _points(places: FloatArray, x0: float, y0: float) -> str:
    return " ".join(f"{x0 + SCALE * x:.1f},{y0 - SCALE * y:.1f}" for x, y in places)
