"""A live camera that films a plate: frames with the time at which each was taken.

A camera's own count of frames is a poor clock: webcams drop frames and change their rate
with the light. Every frame is stamped on arrival, with the driver's own stamp if that keeps pace
with the computer's clock. The clip is Matroska with Motion JPEG: the container holds the stamps, to
the millisecond, and frames written before a crash can be read.
"""

import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError

SUFFIX = ".mkv"
TICKS_PER_S = 1000  #: ticks of the container's stamps
JPEG_QUALITY = 90  #: quality of frames that are stored as images; not seen by the tracker
PROBED = 12  #: frames from which the driver's stamps are judged
PACE = 0.2  #: largest difference of the driver's clock from the computer's over the probe
START_S = 10.0  #: wait for the first frame; some cameras take seconds to wake up


Watch = Callable[[NDArray[np.uint8], float], None]  #: takes a frame (h, w, 3) and its time, s


class CameraFailed(VisionError):
    """The camera cannot be opened, or delivers no frames."""


@dataclass(frozen=True)
class Clip:
    """A filmed clip.

    Attributes
    ----------
    path : Path
    frames : int
    seconds : float
        Time from the first frame to the last.
    """

    path: Path
    frames: int
    seconds: float


class Camera:
    """A camera that runs continuously, and writes clips of chosen stretches.

    Parameters
    ----------
    source : int or Path
        Number of the camera; or a clip that is played in real time, over and over, for trials.
    clock : callable
        The clock of the sensor's log, in seconds.
    watch : callable (image, time_s), optional
        Receives every frame on arrival.

    Raises
    ------
    CameraFailed
        There is no such camera, or it delivers no frame.
    """

    def __init__(
        self, source: int | Path, clock: Callable[[], float] = time.monotonic,
        watch: Watch | None = None,
    ) -> None:
        self._source, self._clock, self._watch = source, clock, watch
        self._name = f"camera {source}" if isinstance(source, int) else str(source)
        if not hasattr(cv2, "VIDEOWRITER_PROP_PTS"):
            raise CameraFailed("this version of OpenCV writes no time stamps; filming needs 4.13 "
                               "or newer (pip install --upgrade opencv-python-headless).")
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
        self._capture = self._open()
        self._lock = threading.Lock()
        self._writer: ClipWriter | None = None
        self._error = ""
        self._stop = threading.Event()
        self._seen = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        if not self._seen.wait(START_S) or self._error:
            self.close()
            raise CameraFailed(self._error or f"{self._name} gives no frame within "
                                              f"{START_S:g} s. Close other programs that use it.")

    def start(self, path: Path) -> None:
        """Begin a clip; it receives its name when it is stopped and kept.

        Parameters
        ----------
        path : Path
            With the suffix ``.mkv``.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        with self._lock:
            if self._writer is not None:
                self._writer.end(keep=False)
            self._writer = ClipWriter(path)

    def stop(self, keep: bool) -> Clip | None:
        """End the clip; ``None`` if there is none, or it is not kept.

        Raises
        ------
        CameraFailed
            The camera failed during the clip.
        """
        with self._lock:
            writer, self._writer = self._writer, None
            if writer is None:
                return None
            clip = writer.end(keep and not self._error)
        if keep and self._error:
            raise CameraFailed(self._error)
        return clip

    def close(self) -> None:
        """Release the camera."""
        self._stop.set()
        self._thread.join()
        self.stop(keep=False)
        self._capture.release()

    def _open(self) -> cv2.VideoCapture:
        source = self._source if isinstance(self._source, int) else str(self._source)
        capture = cv2.VideoCapture(source)
        if not capture.isOpened():
            raise CameraFailed(f"{self._name} cannot be opened. Check its number (0 is the first), "
                               "that it is plugged in, and that no other program uses it.")
        return capture

    def _run(self) -> None:
        stamp = _Stamp(self._clock) if isinstance(self._source, int) else _Playback(self._clock)
        while not self._stop.is_set():
            ok, image = self._capture.read()
            if not ok and isinstance(stamp, _Playback) and self._seen.is_set():
                self._capture = self._open()
                stamp = _Playback(self._clock)
                continue
            if not ok:
                self._error = f"{self._name} gives no more frames. Plug it in again."
                self._seen.set()
                return
            time_s = stamp(self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3)
            with self._lock:
                if self._writer is not None:
                    self._write(self._writer, np.asarray(image), time_s)
            if self._watch is not None:
                self._watch(np.asarray(image), time_s)
            self._seen.set()

    def _write(self, writer: "ClipWriter", image: NDArray[np.uint8], time_s: float) -> None:
        try:
            writer.write(image, time_s)
        except (CameraFailed, cv2.error) as error:
            self._error = str(error)


class _Stamp:
    """Time of each frame: the driver's, shifted to our clock, once it proves to keep pace."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._probe: list[tuple[float, float]] = []
        self._offset: float | None = None
        self._trusted: bool | None = None
        self._last = -np.inf

    def __call__(self, driver_s: float) -> float:
        now = self._clock()
        if self._trusted is None:
            self._probe.append((driver_s, now))
            if len(self._probe) == PROBED:
                self._judge()
        time_s = now
        if self._trusted and self._offset is not None:
            # A frame never arrives before it was taken: the least delay is the offset.
            self._offset = min(self._offset, now - driver_s)
            time_s = driver_s + self._offset
        time_s = max(time_s, self._last + 1 / TICKS_PER_S)
        self._last = time_s
        return time_s

    def _judge(self) -> None:
        driver, heard = np.array(self._probe).T
        steps = np.diff(driver)
        span = heard[-1] - heard[0]
        self._trusted = bool(
            (steps > 0).all() and abs((driver[-1] - driver[0]) / span - 1) < PACE)
        self._offset = float((heard - driver).min())


class _Playback:
    """Playback of a clip in real time: waits for the stamp of each frame."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock, self._begun_s = clock, clock()

    def __call__(self, clip_s: float) -> float:
        wait = self._begun_s + clip_s - self._clock()
        if wait > 0:
            time.sleep(wait)
        return self._begun_s + clip_s


class ClipWriter:
    """Writer of one clip, under a hidden name until it is kept; its stamps in a text file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._hidden = path.with_name(f".filming-{path.stem}{SUFFIX}")
        self._writer: cv2.VideoWriter | None = None
        self._times_s: list[float] = []
        self._ticks = -1

    def write(self, image: NDArray[np.uint8], time_s: float) -> None:
        """Append a frame; the first one sets the size."""
        if self._writer is None:
            self._writer = self._open(image)
        ok, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        first_s = self._times_s[0] if self._times_s else time_s
        ticks = round((time_s - first_s) * TICKS_PER_S)
        if ok and ticks > self._ticks:
            self._writer.set(cv2.VIDEOWRITER_PROP_PTS, ticks)
            self._writer.set(cv2.VIDEOWRITER_PROP_KEY_FLAG, 1)
            self._writer.write(jpeg)
            self._times_s.append(time_s)
            self._ticks = ticks

    def _open(self, image: NDArray[np.uint8]) -> cv2.VideoWriter:
        height, width = image.shape[:2]
        writer = cv2.VideoWriter()
        encoded = [cv2.VIDEOWRITER_PROP_RAW_VIDEO, 1]
        fourcc = cv2.VideoWriter.fourcc(*"MJPG")
        if not writer.open(str(self._hidden), cv2.CAP_FFMPEG, fourcc, TICKS_PER_S,
                           (width, height), encoded):
            raise CameraFailed(f"{self._path}: the clip cannot be written. Check the folder, and "
                               "that the disk is not full.")
        return writer

    def end(self, keep: bool) -> Clip | None:
        """Close the clip; rename it to its final name, or remove it."""
        if self._writer is not None:
            self._writer.release()
        if not keep or len(self._times_s) < 2:
            self._hidden.unlink(missing_ok=True)
            return None
        text = "frame,time_s,session_s\n" + "".join(
            f"{i},{t - self._times_s[0]:.6f},{t:.6f}\n" for i, t in enumerate(self._times_s))
        self._path.with_suffix(".times.csv").write_text(text, encoding="utf-8")
        os.replace(self._hidden, self._path)
        return Clip(self._path, len(self._times_s), self._times_s[-1] - self._times_s[0])
