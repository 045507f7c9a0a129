"""A clip decoded by PyAV where OpenCV cannot: from 4.13 on it hands back interlaced frames black.

Only what ``vision.video.reader`` asks of ``cv2.VideoCapture`` is here, under the same names.
"""

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


class AvCapture:
    """The frames of a file, one after the other.

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
        """Decode one more frame; whether there is one."""
        self._frame = frame = next(self._frames, None)
        if frame is None:
            return False
        if self._first_s is None:
            self._first_s = frame.time or 0.0
        self._time_s = (frame.time or 0.0) - self._first_s
        self._coding = ord("?IPB"[int(frame.pict_type)]) if int(frame.pict_type) < 4 else 0
        return True

    def retrieve(self) -> tuple[bool, NDArray[Any]]:
        """The frame that was grabbed: luma (h, w), or colours (h, w, 3)."""
        frame = self._frame
        if not self._luma:
            return True, np.asarray(frame.to_ndarray(format="bgr24"))
        plane = frame.planes[0]
        rows = np.frombuffer(bytes(plane), np.uint8).reshape(plane.height, plane.line_size)
        return True, rows[: frame.height, : frame.width]

    def get(self, what: int) -> float:
        """The time of the latest frame in ms, or how it is coded."""
        return 1e3 * self._time_s if what == cv2.CAP_PROP_POS_MSEC else float(self._coding)

    def release(self) -> None:
        """Close the file."""
        self._container.close()
