"""A clip as luma frames with their time stamps, decoded in a separate thread.

The stamp is ``CAP_PROP_POS_MSEC`` read after ``read()``, which is exact for every container tried;
read before, it is one frame late, and index over frame rate is wrong by up to 26 % on clips of
uneven frame rate. There is no seeking: a clip is read once, from its first frame to its last.
"""

import atexit
import os
import queue
import stat
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import UnreadableVideo
from vision.video.av_decoder import AvCapture
from vision.video.orientation import Orientation, stated_orientation
from vision.video.reduction import reduced

Luma = NDArray[np.uint8]

LARGEST_SIDE = 1000  # pixels; a larger frame is reduced by a whole factor
BLACK = 1.0  # mean luma of a frame that was not decoded; that of black is 16
JUDGED = 5  # first frames of a clip; fewer than a batch has
FIELDS = "turntable-imu-calibration[fields]"  # extra that decodes interlaced clips
BATCH = 16  # frames passed on at once
FFMPEG_QUIET = "-8"  #: AV_LOG_QUIET; read when the process opens its first clip
LUMA_FIRST = (b"I420", b"NV12", b"Y800")  # 8 bits of luma per pixel, before anything else
SMALL = 500_000  # pixels of a frame that one thread decodes
AS_FILMED = np.eye(3)  #: the motion of a stationary camera
NO_CHROMA = np.zeros((0, 0, 2), np.uint8)  #: colours of a frame whose colours are not read
#: Share of the frames that the decoder holds and those decoded ahead while the plate is learned.
AHEAD_BYTES = 150_000_000
HELD = 12  #: full frames in YUV that the decoder holds: references, its threads', the latest
FEWEST_AHEAD = 2  # batches


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a clip.

    Attributes
    ----------
    time_s : float
        Stamp, seconds from the first frame.
    luma : array of uint8, shape (h, w)
    chroma : array of uint8, shape (h, w, 2)
        Cr and Cb; ``NO_CHROMA`` if they are not read.
    coding : int
        ASCII code of I, P or B; any other if the decoder does not state it.
    motion : array, shape (3, 3)
        Pixels of these images to pixels of the frame as filmed; not the identity if the motion of
        the camera was removed.
    """

    time_s: float
    luma: Luma
    chroma: NDArray[np.uint8]
    coding: int = 0
    motion: NDArray[np.float64] = field(default_factory=lambda: AS_FILMED)

    @property
    def nbytes(self) -> int:
        """Memory of the frame."""
        return self.luma.nbytes + self.chroma.nbytes

    @property
    def bgr(self) -> NDArray[np.uint8]:
        """The frame for display, blue-green-red, grey without chroma; shape (h, w, 3)."""
        if self.chroma is NO_CHROMA:
            return np.asarray(cv2.cvtColor(self.luma, cv2.COLOR_GRAY2BGR), np.uint8)
        planes = cv2.merge([self.luma, self.chroma])
        return np.asarray(cv2.cvtColor(planes, cv2.COLOR_YCrCb2BGR), np.uint8)


class ClipReader:
    """The frames of a file in order; iterate once, as a context manager to end it before its end.

    Parameters
    ----------
    path : path
    colours : bool
        The frames carry chroma. It has half the luma's resolution in most clips, and frames are
        reduced to that, unless they are of ``full_size``, for display.

    Attributes
    ----------
    orientation : Orientation
        Orientation of the stored frames, if this class applies it and not the decoder.
    reduction : int
        Whole factor by which the frames are reduced.
    frames_stated : int or None
        Length by the container, often wrong, sufficient for a progress bar.
    fps_stated : float
    seconds_stated : float or None
        Length from these two.
    """

    def __init__(self, path: Path | str, *, colours: bool = False, full_size: bool = False) -> None:
        self.path = Path(path)
        _refuse_unreadable(self.path)
        # The decoder reports every oddity of a file; our own messages state what matters.
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", FFMPEG_QUIET)
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
        self._capture = _opened(path)
        if not self._capture.isOpened():
            raise UnreadableVideo(
                f"{path}: no video stream that can be decoded was found in the file. Expected a "
                f"clip such as .mp4, .mov, .mkv or .avi; if it plays elsewhere, convert it to "
                f"H.264, if it does not, it is damaged or was not closed by the recorder."
            )
        stated = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        self.frames_stated = stated if stated > 0 else None
        self.fps_stated = float(self._capture.get(cv2.CAP_PROP_FPS))
        self.seconds_stated = stated / self.fps_stated if stated > 0 < self.fps_stated else None
        side = max(
            self._capture.get(cv2.CAP_PROP_FRAME_WIDTH),
            self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT),
        )
        self.reduction = max(1, int(np.ceil(side / LARGEST_SIDE))) * (
            2 if colours and not full_size else 1)
        # Older versions of the decoder turn frames the wrong way or not at all; none mirrors them.
        orientation = stated_orientation(self.path)
        if orientation is not None:
            self._capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        self.orientation = orientation or Orientation()
        self._colours = colours
        self._decoder: cv2.VideoCapture | AvCapture = self._capture
        # Luma as decoded, without the conversion to colours. Other formats (10 bits, packed) would
        # come in their memory layout; read() converts those to colours.
        stored = int(self._capture.get(cv2.CAP_PROP_CODEC_PIXEL_FORMAT)) & 0xFFFFFFFF
        if not colours and stored.to_bytes(4, "little") in LUMA_FIRST:
            self._capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
        self._first: list[NDArray[Any]] | None = []
        self._queue: queue.Queue[list[Frame] | BaseException | None] = queue.Queue()
        self._room = threading.Semaphore(1)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._decode, daemon=True)

    def __enter__(self) -> "ClipReader":
        self._thread.start()
        atexit.register(self.__exit__)  # a thread that decodes then would crash the interpreter
        return self

    def __exit__(self, *_: object) -> None:
        atexit.unregister(self.__exit__)
        self._stop.set()
        self._room.release()
        self._thread.join()
        self._decoder.release()
        self._capture.release()

    def __iter__(self) -> Iterator[list[Frame]]:
        """Batches of frames, at least one frame each."""
        if self._thread.ident is None:
            self.__enter__()
        while (item := self._queue.get()) is not None:
            if isinstance(item, BaseException):
                raise item
            yield item
            self._room.release()

    def _decode(self) -> None:
        try:
            batch: list[Frame] = []
            sized = False
            while not self._stop.is_set() and self._decoder.grab():
                ok, image = self._decoder.retrieve()
                if not ok:
                    break
                if self._begins_anew(np.asarray(image)):
                    batch = []
                    continue
                time_s = self._decoder.get(cv2.CAP_PROP_POS_MSEC) / 1e3
                coding = int(self._decoder.get(cv2.CAP_PROP_FRAME_TYPE))
                batch.append(self._frame(time_s, coding, np.asarray(image)))
                if not sized:
                    stored = 1.5 * batch[0].luma.size * self.reduction**2
                    batches = int((AHEAD_BYTES - HELD * stored) / (BATCH * batch[0].nbytes))
                    for _ in range(max(FEWEST_AHEAD, batches) - 1):
                        self._room.release()
                    sized = True
                if len(batch) == BATCH:
                    self._room.acquire()
                    self._queue.put(batch)
                    batch = []
            if batch:
                self._queue.put(batch)
            self._queue.put(None)
        except UnreadableVideo as error:
            self._queue.put(error)
        except cv2.error as error:
            self._queue.put(
                UnreadableVideo(f"{self.path}: the decoder failed ({error}); convert the clip.")
            )

    def _begins_anew(self, image: NDArray[Any]) -> bool:
        """Whether the frames up to this one were not decoded, and another decoder takes over."""
        if self._first is None:
            return False
        self._first.append(image)
        if len(self._first) < JUDGED:
            return False
        first, self._first = self._first, None  # of a clip in 4K they take 40 MB
        return self._not_decoded(first)

    def _not_decoded(self, first: list[NDArray[Any]]) -> bool:
        """Whether the first frames were not decoded; then the other decoder starts again.

        For interlaced clips the usual one returns empty frames, or the same memory repeatedly.
        """
        if isinstance(self._decoder, AvCapture) or any((im != first[0]).any() for im in first):
            return False
        luma = not self._colours and self._capture.get(cv2.CAP_PROP_CONVERT_RGB) == 0
        try:
            self._decoder = AvCapture(self.path, luma=luma)
        except ModuleNotFoundError as error:
            if float(np.mean(first[0])) > BLACK:
                return False
            raise UnreadableVideo(
                f"{self.path}: the decoder hands back black frames, as it does of interlaced "
                f"clips. Type: pip install '{FIELDS}' (or deinterlace the clip: ffmpeg -i CLIP -vf "
                f"bwdif=mode=send_field OUT.mp4)."
            ) from error
        return True

    def _frame(self, time_s: float, coding: int, image: NDArray[Any]) -> Frame:
        if self._colours:
            image = np.asarray(cv2.cvtColor(self._displayed(image), cv2.COLOR_BGR2YCrCb), np.uint8)
            chroma = np.empty((*image.shape[:2], 2), np.uint8)
            cv2.mixChannels([image], [chroma], [1, 0, 2, 1])
            luma = np.asarray(cv2.extractChannel(image, 0), np.uint8)
            return Frame(time_s, luma, chroma, coding)
        if image.ndim == 3 and image.shape[2] == 3:
            image = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        elif image.ndim == 3:
            image = image[:, :, 0]
        return Frame(time_s, np.asarray(self._displayed(image), np.uint8), NO_CHROMA, coding)

    def _displayed(self, image: NDArray[Any]) -> NDArray[Any]:
        """The image in display orientation, and reduced."""
        return reduced(self.orientation.displayed(image), self.reduction)


def _opened(path: Path | str) -> cv2.VideoCapture:
    """The clip, small frames decoded by one thread: several would wait for each other.

    The number of threads can only be set while opening.
    """
    name = os.path.abspath(path)  # FFmpeg takes the text before a colon for a protocol
    one = cv2.VideoCapture(name, cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 1])
    pixels = one.get(cv2.CAP_PROP_FRAME_WIDTH) * one.get(cv2.CAP_PROP_FRAME_HEIGHT)
    return one if pixels <= SMALL else cv2.VideoCapture(name, cv2.CAP_FFMPEG)


def _refuse_unreadable(path: Path) -> None:
    """Refuse a file that cannot be opened; the decoder would only report that there is no clip."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe would block forever
            raise UnreadableVideo(f"{path}: is no file; a clip is expected.")
        with path.open("rb") as file:
            empty = not file.read(1)
    except FileNotFoundError as error:
        raise UnreadableVideo(
            f"{path}: there is no such file; check the path of the video."
        ) from error
    except OSError as error:
        raise UnreadableVideo(
            f"{path}: the video cannot be read ({error.strerror}). Check that it is a file, and "
            f"that you may read it."
        ) from error
    if empty:
        raise UnreadableVideo(
            f"{path}: the file is empty (0 bytes); copy it from the camera again."
        )
