"""A small copy of an annotated frame, for pages that show one for every pose."""

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH = 240  #: px; layout
QUALITY = 60  #: per cent, of JPEG: about 6 kB for each picture; layout


def thumbnail(png: NDArray[np.uint8]) -> bytes:
    """The picture in a PNG (b,) as a small JPEG."""
    image = cv2.imdecode(png, cv2.IMREAD_COLOR)
    assert image is not None  # it was written by this program
    height = round(image.shape[0] * WIDTH / image.shape[1])
    small = cv2.resize(image, (WIDTH, height), interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", small, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))[1])
