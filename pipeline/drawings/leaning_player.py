"""A record player with a book under one side, from the side, as text of an SVG."""

import math

from calib.poses.runs.ideal_ring import ADVISED_TILT_RAD
from pipeline.drawings.svg import filled_box, picture_head, words_at

PX_PER_CM = 11.0  #: px; of a picture
DEPTH_CM, HEIGHT_CM = 32.0, 7.0  #: cm, of the player; of a picture
PLATE_CM, SENSOR_CM = 28.0, 4.0  #: cm across; of a picture
WIDTH, BASE = 480.0, 250.0  #: px of the drawing, and where the table is; of a picture


def leaning_svg() -> str:
    """The player as it is to stand for the tilt that is advised."""
    degrees = math.degrees(ADVISED_TILT_RAD)
    depth, height, plate, sensor = (
        PX_PER_CM * each for each in (DEPTH_CM, HEIGHT_CM, PLATE_CM, SENSOR_CM))
    edge = (WIDTH + depth) / 2
    foot_x, top, middle = edge - depth, BASE - height, edge - depth / 2
    book = depth * math.sin(ADVISED_TILT_RAD)
    deck, side = top - 10, sensor * 0.6
    tilted = "\n".join([
        filled_box(foot_x, top, depth, height, "#d9d9d9"),
        filled_box(middle - plate / 2, deck, plate, 10, "#8a8a8a"),
        filled_box(middle - sensor / 2, deck - side, sensor, side, "#2471a3"),
        f'<line x1="{middle:.1f}" y1="{deck - side:.1f}" x2="{middle:.1f}" y2="{deck - 130:.1f}" '
        'stroke="#333" stroke-dasharray="6 4"/>',
        f'<path d="M{middle - 34:.1f} {deck - 92:.1f}a34 9 0 1 0 60 -5" fill="none" stroke="#333" '
        'marker-end="url(#tip)"/>',
    ])
    tip_x = f"{middle + 14:.1f}"
    return "\n".join([
        *picture_head(WIDTH, BASE + 30, "A record player with 5 cm under one side"),
        f'<line x1="10" y1="{BASE:g}" x2="{WIDTH - 10:g}" y2="{BASE:g}" stroke="#333"/>',
        filled_box(foot_x, BASE - book, 60, book, "#b9770e"),
        f'<g transform="rotate({degrees:g} {edge:g} {BASE:g})">\n{tilted}\n</g>',
        f'<line x1="{tip_x}" y1="{deck - 150:.1f}" x2="{tip_x}" y2="{deck - 62:.1f}" '
        'stroke="#c0392b" stroke-width="2" marker-end="url(#tip)"/>',
        words_at(middle - 42, deck - 128, "gravity", "#c0392b"),
        words_at(middle + 62, deck - 104, f"axis, {degrees:g}° off"),
        words_at(foot_x + 4, BASE + 18, "5 cm"),
        words_at(edge - 56, BASE + 18, "the table"),
        "</svg>\n",
    ])
