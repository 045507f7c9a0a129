"""Clips made from clips."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]


def again(
    source: Path,
    target: Path,
    *,
    size: tuple[int, int] | None = None,
    pixel_format: str = "yuv420p",
    codec: str = "libx264",
    change: Callable[[int, Image], Image] | None = None,
) -> Path:
    """Decode a clip and encode it otherwise, at 15 frames per second."""
    with av.open(str(source)) as old, av.open(str(target), "w") as new:
        stream = new.add_stream(codec, rate=15)
        assert isinstance(stream, av.VideoStream)
        for i, frame in enumerate(old.decode(video=0)):
            image = np.asarray(frame.to_ndarray(format="bgr24"), np.uint8)
            if change is not None:
                image = change(i, image)
            if size is not None:
                image = np.asarray(cv2.resize(image, size), np.uint8)
            if i == 0:
                stream.height, stream.width = image.shape[:2]
                stream.pix_fmt = pixel_format
                stream.options = {"preset": "ultrafast"} if codec == "libx264" else {}
                stream.codec_context.thread_count = 1  # the same clip on any number of cores
            whole = np.ascontiguousarray(image, np.uint8)
            encoded = av.VideoFrame.from_ndarray(whole, format="bgr24")
            encoded.pts, encoded.time_base = i, Fraction(1, 15)
            new.mux(stream.encode(encoded))
        new.mux(stream.encode())
    return target
