"""The bench as text of an SVG: what the camera sees, and how a sensor lies on an edge."""

from pipeline.drawings.svg import filled_box, picture_head, words_at

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
