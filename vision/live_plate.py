"""The present picture of a camera, with rim and mark found in its last seconds.

The last seconds are kept as a film; a separate thread measures it repeatedly, like any clip. In
between, the drawn hand turns at the measured rate: if it stays on the mark, the rate is right.
"""

import tempfile
import threading
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera import SUFFIX, ClipWriter
from vision.drawing import draw_plate, jpeg_of
from vision.errors import VisionError
from vision.numbers import RPM
from vision.phase_track import PlateLayout
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

FILM_S = 10.0  #: length of the film: almost three turns of the slowest plates. Derived
PAUSE_S = 3.0  #: pause between measurements, which leaves most of the time to the sensor. Chosen
FEWEST = 30  #: least number of frames of a measured film; chosen
WIDTH_PX = 640  #: width of a picture; layout
END_S = 5.0  #: wait for the thread to end; chosen

Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class SeenPlate:
    """The plate in the film.

    Attributes
    ----------
    plate : PlateLayout
    time_s, angle_rad : float
        A time, by the camera's clock, and the angle at that time.
    rate_rad_s : float
        Signed; NaN if the film shows none yet.
    """

    plate: PlateLayout
    time_s: float
    angle_rad: float
    rate_rad_s: float


class LivePlate:
    """Observer of a camera: :meth:`watch` takes its frames, :meth:`picture` shows the latest."""

    def __init__(self) -> None:
        self._film: deque[tuple[float, Image]] = deque()
        self._latest: tuple[float, Image] | None = None
        self._seen: SeenPlate | None = None
        self._lock = threading.Lock()
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop measuring."""
        self._end.set()
        self._thread.join(END_S)

    def watch(self, image: Image, time_s: float) -> None:
        """Take a frame; see :data:`vision.camera.Watch`."""
        jpeg = np.frombuffer(jpeg_of(image, WIDTH_PX), np.uint8)
        with self._lock:
            self._latest = time_s, jpeg
            self._film.append((time_s, jpeg))
            while time_s - self._film[0][0] > FILM_S:
                self._film.popleft()

    @property
    def words(self) -> str:
        """State of the plate, in a sentence; empty before the first frame."""
        with self._lock:
            seen, latest = self._seen, self._latest
        if latest is None:
            return ""
        if seen is None:
            return "No turning plate is seen yet."
        if np.isnan(seen.rate_rad_s):
            return "The rim of the plate is seen; no rate yet."
        return f"The plate turns at {abs(seen.rate_rad_s) / RPM:.2f} rpm in the last seconds."

    def picture(self) -> bytes | None:
        """The latest frame with rim and mark, as JPEG; None before the first."""
        with self._lock:
            seen, latest = self._seen, self._latest
        if latest is None:
            return None
        time_s, jpeg = latest
        if seen is None:
            return jpeg.tobytes()
        image = np.asarray(cv2.imdecode(jpeg, cv2.IMREAD_COLOR), np.uint8)
        scale = image.shape[1] * seen.plate.reduction / seen.plate.size_px[0]
        angle = seen.angle_rad + seen.rate_rad_s * (time_s - seen.time_s)
        draw_plate(image, seen.plate, angle, scale)
        return jpeg_of(image, WIDTH_PX)

    def _run(self) -> None:
        while not self._end.wait(PAUSE_S):
            with self._lock:
                film = list(self._film)
            if len(film) >= FEWEST and film[-1][0] - film[0][0] > FILM_S / 2:
                seen = _plate_in(film)
                with self._lock:
                    self._seen = seen


def _plate_in(film: list[tuple[float, Image]]) -> SeenPlate | None:
    """The plate in a film of JPEGs; None if none turns."""
    with tempfile.TemporaryDirectory(prefix="pipeline-") as folder:
        writer = ClipWriter(Path(folder) / f"film{SUFFIX}")
        for time_s, jpeg in film:
            writer.write(np.asarray(cv2.imdecode(jpeg, cv2.IMREAD_COLOR), np.uint8), time_s)
        clip = writer.end(keep=True)
        if clip is None:
            return None
        try:
            track = track_phase(clip.path)
        except VisionError:
            return None
    known = np.flatnonzero(np.isfinite(track.phase_rad))
    if not len(known):
        return None
    last = known[-1]
    try:
        rate = measure_rate(track, timebase=Timebase()).aliases.chosen_rad_s
    except VisionError:
        rate = np.nan
    return SeenPlate(track.plate, film[0][0] + float(track.time_s[last]),
                     float(track.phase_rad[last]), float(rate))
