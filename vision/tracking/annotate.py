"""One picture of the film with what was found drawn in."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import View

WIDEST = 640
PLATE, CENTRE, MARK, DECK = (80, 220, 80), (60, 60, 255), (255, 200, 0), (0, 200, 255)  # BGR


def annotate(
    picture: NDArray[np.uint8],
    view: View,
    rings: tuple[float, float],
    mark: tuple[float, float] | None,
    deck_mark: tuple[float, float] | None,
) -> NDArray[np.uint8]:
    """Plate, spindle, used radii and marks in colour over a picture, shape (h, w, 3).

    Parameters
    ----------
    picture : array of uint8, shape (h, w, 3)
        Blue-green-red.
    view : View
    rings : (inner, outer)
        Radii between which the angle was measured.
    mark, deck_mark : (radius, azimuth in rad), optional
        As they stand in this picture.
    """
    scale = min(1.0, WIDEST / picture.shape[1])
    if scale < 1:
        size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    canvas = picture.copy()

    def point(radius: float, azimuth: float) -> tuple[int, int]:
        x, y = view.pixels(np.array(radius), np.array(azimuth))
        return round(float(x) * scale), round(float(y) * scale)

    for radius, thickness in ((1.0, 2), (rings[0], 1), (rings[1], 1)):
        outline = [point(radius, a) for a in np.linspace(0, 2 * np.pi, 181)]
        cv2.polylines(canvas, [np.array(outline, np.int32)], True, PLATE, thickness, cv2.LINE_AA)
    centre = point(0.0, 0.0)
    cv2.drawMarker(canvas, centre, CENTRE, cv2.MARKER_CROSS, 15, 2, cv2.LINE_AA)
    for spot, colour in ((mark, MARK), (deck_mark, DECK)):
        if spot is not None:
            at = point(*spot)
            cv2.line(canvas, centre, at, colour, 1, cv2.LINE_AA)
            cv2.circle(canvas, at, 9, colour, 2, cv2.LINE_AA)
    return np.asarray(canvas, np.uint8)
