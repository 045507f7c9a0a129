"""Films made from films."""

from fractions import Fraction

import av
import cv2
import numpy as np


def again(source, target, *, size=None, pixel_format="yuv420p", codec="libx264", change=None):
    """Decode a film and encode it otherwise."""
    with av.open(str(source)) as old, av.open(str(target), "w") as new:
        stream = new.add_stream(codec, rate=15)
        for i, frame in enumerate(old.decode(video=0)):
            picture = frame.to_ndarray(format="bgr24")
            if change is not None:
                picture = change(i, picture)
            if size is not None:
                picture = cv2.resize(picture, size)
            if i == 0:
                stream.height, stream.width = picture.shape[:2]
                stream.pix_fmt = pixel_format
                stream.options = {"preset": "ultrafast"} if codec == "libx264" else {}
                stream.codec_context.thread_count = 1  # the same film on any number of cores
            made = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="bgr24")
            made.pts, made.time_base = i, Fraction(1, 15)
            new.mux(stream.encode(made))
        new.mux(stream.encode())
    return target
