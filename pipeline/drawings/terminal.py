"""The box in dots of Braille signs, four rows and two columns of dots in each."""

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.drawings.box import Line, box_lines

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
