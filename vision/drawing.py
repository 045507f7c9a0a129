"""The plate drawn on a frame: rim, spindle and a hand through the mark."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.phase_track import PlateLayout

Image = NDArray[np.uint8]

RIM, CENTRE, HAND, UNUSED = (  # blue, green, red
    (80, 220, 80), (60, 60, 255), (255, 200, 0), (150, 150, 150))
STANDING = np.eye(3)  #: motion of a camera that stands still; definition
JPEG_QUALITY = 80  #: quality of pictures for display; chosen
THUMBNAIL = 240  #: px; layout
WIDEST = 640  #: pixels of the annotated frame; layout
KEPT_BITS = 5  #: bits of its channels that are kept; layout
#: Level of its PNG: a third of the time of the library's own choice, for 4 per cent more space.
FAST_PNG = (cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE,
            cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP)


def draw_plate(
    canvas: Image, plate: PlateLayout, angle_rad: float, scale: float,
    motion: FloatArray = STANDING, used: bool = True,
) -> None:
    """Draw rim, spindle and a hand through the mark on a frame.

    Parameters
    ----------
    canvas : array of uint8, shape (h, w, 3)
        Blue-green-red; changed in place.
    plate : PlateLayout
    angle_rad : float
        Plate angle; NaN draws the rim alone.
    scale : float
        Size of the frame over the size of the frames in which the plate was found.
    motion : array, shape (3, 3)
        Pixels of the plate's view to pixels of this frame.
    used : bool
        Whether the rate uses the frame; otherwise the hand is grey.
    """
    view = PlateView(plate.view)

    def seen(radius: FloatArray, azimuth_rad: FloatArray) -> NDArray[np.int32]:
        x, y, n = motion @ np.stack([*view.pixels(radius, azimuth_rad), np.ones_like(radius)])
        places = np.stack([x / n, y / n], axis=1) * scale + (scale - 1) / 2
        return np.round(places).astype(np.int32)

    cv2.polylines(canvas, [seen(np.ones(181), np.linspace(0, 2 * np.pi, 181))], True, RIM, 2,
                  cv2.LINE_AA)
    if not np.isfinite(angle_rad):
        return
    radius, azimuth_rad = plate.mark
    centre, tip = (tuple(map(int, each)) for each in seen(
        np.array([0.0, radius]), np.full(2, azimuth_rad + angle_rad)))
    colour = HAND if used else UNUSED
    cv2.line(canvas, centre, tip, colour, 1, cv2.LINE_AA)
    cv2.circle(canvas, tip, 9, colour, 2, cv2.LINE_AA)
    cv2.drawMarker(canvas, centre, CENTRE, cv2.MARKER_CROSS, 15, 2, cv2.LINE_AA)


def annotated(image: Image, plate: PlateLayout, angle_rad: float) -> Image:
    """A measured frame with the plate drawn on it.

    Parameters
    ----------
    image : array of uint8, shape (h, w, 3)
        Blue-green-red.
    plate : PlateLayout
    angle_rad : float
        Plate angle; NaN draws the rim alone.

    Returns
    -------
    array of uint8, shape (b,)
        The bytes of a PNG, at most 640 pixels wide.
    """
    scale = min(1.0, WIDEST / image.shape[1])
    size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
    canvas = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    draw_plate(canvas, plate, angle_rad, scale)
    return png(canvas)


def jpeg_of(image: Image, width_px: int) -> bytes:
    """A picture, blue-green-red, as JPEG, no wider than ``width_px``."""
    h, w = image.shape[:2]
    if w > width_px:
        image = np.asarray(cv2.resize(image, (width_px, round(h * width_px / w)),
                                      interpolation=cv2.INTER_AREA), np.uint8)
    return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()


def thumbnail(png: Image) -> bytes:
    """The picture in a PNG (b,) of ``annotated`` as a small JPEG, for pages that show many."""
    image = cv2.imdecode(png, cv2.IMREAD_COLOR)
    assert image is not None  # it was written by this program
    return jpeg_of(np.asarray(image, np.uint8), THUMBNAIL)


def png(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Encode an image (h, w, 3), blue-green-red, as the bytes (b,) of a PNG.

    Every channel keeps its ``KEPT_BITS`` highest bits: noise is most of the content of a PNG, and
    without the lowest bits the file takes a third of the space.
    """
    step = 1 << (8 - KEPT_BITS)
    coarse = (image & (256 - step)) | (step // 2)
    _, data = cv2.imencode(".png", coarse, FAST_PNG)
    return np.asarray(data, np.uint8).ravel()
