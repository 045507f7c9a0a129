"""A clip decoded by PyAV if OpenCV cannot: from 4.13 on it returns interlaced frames black.

It has only the methods of ``cv2.VideoCapture`` that ``vision.video.reader`` uses.
"""

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


class AvCapture:
    """The frames of a file in order.

    Raises
    ------
    ModuleNotFoundError
        PyAV is not installed.
    """

    def __init__(self, path: Path | str, *, luma: bool) -> None:
        import av

        self._container = av.open(os.path.abspath(path))
        self._stream = self._container.streams.video[0]
        self._stream.thread_type = "AUTO"
        self._frames = self._container.decode(self._stream)
        self._luma = luma
        self._first_s: float | None = None
        self._time_s, self._coding = 0.0, 0
        self._frame: Any = None

    def grab(self) -> bool:
        """Decode the next frame; return whether there is one."""
        self._frame = frame = next(self._frames, None)
        if frame is None:
            return False
        if self._first_s is None:
            self._first_s = frame.time or 0.0
        self._time_s = (frame.time or 0.0) - self._first_s
        self._coding = ord("?IPB"[int(frame.pict_type)]) if int(frame.pict_type) < 4 else 0
        return True

    def retrieve(self) -> tuple[bool, NDArray[Any]]:
        """The grabbed frame: luma (h, w), or colours (h, w, 3)."""
        frame = self._frame
        if not self._luma:
            return True, np.asarray(frame.to_ndarray(format="bgr24"))
        plane = frame.planes[0]
        rows = np.frombuffer(bytes(plane), np.uint8).reshape(plane.height, plane.line_size)
        return True, rows[: frame.height, : frame.width]

    def get(self, what: int) -> float:
        """The time of the latest frame in ms, or its coding."""
        return 1e3 * self._time_s if what == cv2.CAP_PROP_POS_MSEC else float(self._coding)

    def release(self) -> None:
        """Close the file."""
        self._container.close()
