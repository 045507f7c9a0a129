"""The bench as text of an SVG: what the camera sees, how a sensor lies, a leaning record player."""

import math
from html import escape

from calib.poses.runs.ideal_ring import ADVISED_TILT_RAD


def picture_head(width: float, height: float, title: str) -> list[str]:
    """The start of a white picture of ``width`` by ``height`` px, with tips for arrows."""
    tips = "".join(
        f'<marker id="{name}" markerWidth="8" markerHeight="8" refX="6" refY="4" orient="auto">'
        f'<path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>'
        for name, colour in (("tip", "#333"), ("pale-tip", "white")))
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'width="{width:g}" height="{height:g}" font-family="sans-serif" font-size="13">',
        f"<title>{escape(title)}</title>", f"<defs>{tips}</defs>",
        '<rect width="100%" height="100%" fill="white"/>',
    ]


def filled_box(x: float, y: float, width: float, height: float, colour: str) -> str:
    """A filled rectangle with its upper left corner at ``x``, ``y``."""
    return (f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
            f'fill="{colour}" stroke="#333"/>')


def words_at(x: float, y: float, words: str, colour: str = "#333") -> str:
    """Words that begin at ``x``, ``y``."""
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}">{escape(words)}</text>'


WIDTH, HEIGHT = 760.0, 330.0  #: px; of a picture
PLATE = 112.0  #: px, radius of the plate seen from above; of a picture
CARD = "#b9770e"  #: colour of wedges
TAPE = "#f4d03f"  #: colour of the marks


def bench_svg() -> str:
    """Plate, marks, sensor and camera from above, and a wedge from the side."""
    return "\n".join([
        *picture_head(WIDTH, HEIGHT, "A record player with its two marks, and a sensor on a wedge"),
        *_from_above(160.0, 165.0), *_from_the_side(380.0, 270.0), "</svg>\n"])


def _from_above(x: float, y: float) -> list[str]:
    """The camera's picture: the whole plate, a mark near its rim, a fixed mark on the deck."""
    return [
        words_at(x - 150, 20, "what the camera sees"),
        filled_box(x - 150, y - 130, 300, 270, "#e8e8e8"),
        f'<circle cx="{x:g}" cy="{y:g}" r="{PLATE:g}" fill="#5d6570" stroke="#333"/>',
        f'<circle cx="{x:g}" cy="{y:g}" r="3" fill="white"/>',
        f'<g transform="rotate(-38 {x:g} {y:g})">'
        f'{filled_box(x + PLATE - 34, y - 11, 28, 22, TAPE)}</g>',
        filled_box(x - 18, y - 12, 36, 24, "#2471a3"),
        filled_box(x + 122, y + 108, 20, 20, TAPE),
        f'<path d="M{x - 80:g} {y - 32:g}A86 86 0 0 1 {x - 32:g} {y - 80:g}" fill="none" '
        'stroke="white" stroke-width="2" marker-end="url(#pale-tip)"/>',
        words_at(x - 46, y - 58, "mark on the rim", "white"),
        words_at(x - 58, y + 32, "sensor, at the spindle", "white"),
        words_at(x + 32, y + 158, "fixed mark on the deck"),
        words_at(x - 150, y + 158, "deck"),
    ]


def _from_the_side(x: float, y: float) -> list[str]:
    """The camera on its own stand, and the sensor's box flat and on an edge."""
    slope = 70.0
    return [
        words_at(x - 10, 20, "from the side"),
        f'<line x1="{x - 10:g}" y1="{y:g}" x2="{WIDTH - 10:g}" y2="{y:g}" stroke="#333"/>',
        filled_box(x + 30, y - 46, 190, 46, "#d9d9d9"),
        filled_box(x + 40, y - 56, 170, 10, "#5d6570"),
        filled_box(x + 107, y - 80, 36, 24, "#2471a3"),
        f'<path d="M{x + 4:g} {y:g}V60H{x + 125:g}" fill="none" stroke="#333" stroke-width="4"/>',
        filled_box(x + 109, 56, 32, 22, "#333"),
        f'<path d="M{x + 115:g} 82L{x + 38:g} {y - 60:g}M{x + 135:g} 82L{x + 212:g} {y - 60:g}" '
        'stroke="#999" stroke-dasharray="5 4"/>',
        words_at(x + 152, 60, "camera, on its own"), words_at(x + 152, 76, "stand, off the player"),
        words_at(x + 30, y + 18, "level to two degrees"),
        # A wedge of 45 degrees with the box on it; the box slides down to the card that stops it.
        f'<path d="M{x + 250:g} {y:g}h{slope:g}v{-slope:g}z" fill="{CARD}" stroke="#333"/>',
        f'<g transform="translate({x + 250:g} {y:g}) rotate(-45)">'
        f'{filled_box(18, -30, 58, 30, "#2471a3")}{filled_box(12, -22, 6, 22, CARD)}</g>',
        words_at(x + 240, y - 128, "on an edge: a wedge"),
        words_at(x + 240, y - 112, "of wood or card, 45°"),
    ]


PX_PER_CM = 11.0  #: px; of a picture
DEPTH_CM, HEIGHT_CM = 32.0, 7.0  #: cm, of the player; of a picture
PLATE_CM, SENSOR_CM = 28.0, 4.0  #: cm across; of a picture
LEANING_WIDTH, BASE = 480.0, 250.0  #: px of the drawing, and where the table is; of a picture


def leaning_svg() -> str:
    """The player as it is to stand for the tilt that is advised."""
    degrees = math.degrees(ADVISED_TILT_RAD)
    depth, height, plate, sensor = (
        PX_PER_CM * each for each in (DEPTH_CM, HEIGHT_CM, PLATE_CM, SENSOR_CM))
    edge = (LEANING_WIDTH + depth) / 2
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
        *picture_head(LEANING_WIDTH, BASE + 30, "A record player with 5 cm under one side"),
        f'<line x1="10" y1="{BASE:g}" x2="{LEANING_WIDTH - 10:g}" y2="{BASE:g}" stroke="#333"/>',
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
