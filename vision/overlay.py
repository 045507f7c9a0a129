"""The clip with the measurement drawn on it, so that the user can see whether the rate is right.

Every frame shows the rim, the spindle, a hand at the measured angle (through the mark if there is
one), the angle of this hand, counter-clockwise from the right as seen on the plate, and the rate.
If the rate does not use a frame, the hand is grey, the frame has a border, and the text says so;
frames in which the plate was not tracked have the border alone. In a refused clip everything that
was tracked is drawn in grey.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.drawing import UNUSED, draw_plate, jpeg_of
from vision.errors import VisionError
from vision.geometry import FloatArray
from vision.numbers import RPM
from vision.phase_track import PhaseTrack
from vision.rate.measure import RateMeasurement
from vision.rate.unwrap import frame_time
from vision.video.reader import ClipReader, Frame

Image = NDArray[np.uint8]

TEXT = (255, 255, 255)  # blue, green, red
LINE_PX = 22  #: height of text, in a frame of the width below
TEXT_WIDTH = 640  #: px; layout: the text grows with wider frames
FONT = cv2.FONT_HERSHEY_SIMPLEX
SAME_S = 1e-4  #: seconds within which two stamps belong to one frame
BORDER_PX = 6  #: border of a frame that the rate does not use; layout
EVEN = 2  # pixels: encoders of 4:2:0 take even sizes only


class UnwritableOverlay(VisionError):
    """The clip cannot be encoded."""


def write_overlay(
    clip: Path,
    track: PhaseTrack,
    rate: RateMeasurement | None,
    target: Path,
    on_frame: Callable[[int, int | None], None],
) -> None:
    """Write the clip with the measurement drawn on it, as MPEG-4 at its stated frame rate.

    Parameters
    ----------
    clip : Path
    track : PhaseTrack
        Track of the whole clip.
    rate : RateMeasurement or None
        From this track; None if it was refused.
    target : Path
        An .mp4; an existing file is overwritten.
    on_frame : callable (frames done, frames in all)

    Raises
    ------
    UnwritableOverlay
        No encoder, no space, or no such folder.
    """
    count = len(track.time_s)
    writer = cv2.VideoWriter()
    try:
        with ClipReader(clip, colours=True, full_size=True) as reader:
            fps = reader.fps_stated or 1 / frame_time(track, track.time_s)
            for done, (_, image) in enumerate(_drawn(reader, track, rate), start=1):
                h, w = image.shape[:2]
                if not writer.isOpened() and not writer.open(
                        str(target), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"mp4v"), fps, (w, h)):
                    raise UnwritableOverlay(
                        f"{target}: the clip cannot be written. Check the folder, and that the "
                        f"disk is not full.")
                writer.write(image)
                on_frame(min(done, count), count)
    finally:
        writer.release()


@dataclass(frozen=True)
class StillFrame:
    """One frame with the measurement drawn on it: its time in the clip, s, and its JPEG."""

    time_s: float
    jpeg: bytes


def still_frames(
    clip: Path, track: PhaseTrack, rate: RateMeasurement | None, width_px: int, most: int
) -> list[StillFrame]:
    """The clip as pictures that any browser shows one after another.

    Parameters
    ----------
    clip, track, rate
        As for :func:`write_overlay`.
    width_px : int
        Wider frames are reduced to it.
    most : int
        Largest number of pictures: of a longer clip every second frame is drawn, or every third,
        and so on.

    Raises
    ------
    UnreadableVideo
        The clip cannot be read.
    """
    every = -(-len(track.time_s) // most)
    with ClipReader(clip, colours=True, full_size=True) as reader:
        return [StillFrame(time_s, jpeg_of(image, width_px))
                for time_s, image in _drawn(reader, track, rate, every)]


def _drawn(
    reader: ClipReader, track: PhaseTrack, rate: RateMeasurement | None, every: int = 1
) -> Iterator[tuple[float, Image]]:
    """Time and picture of every frame, or of some of them."""
    drawing = _Drawing(track, rate, track.plate.reduction / reader.reduction)
    for number, frame in enumerate(frame for batch in reader for frame in batch):
        if number % every == 0:
            i = int(np.searchsorted(track.time_s, frame.time_s - SAME_S))
            followed = i < len(track.time_s) and abs(track.time_s[i] - frame.time_s) <= SAME_S
            yield frame.time_s, drawing.on(frame, i if followed else None)


class _Drawing:
    """Drawing on the frames of a track, ``scale`` times as large as the tracked ones."""

    def __init__(self, track: PhaseTrack, rate: RateMeasurement | None, scale: float) -> None:
        self._track, self._scale = track, scale
        self._used, self._rate = np.zeros(len(track.time_s), bool), "no rate: the clip was refused"
        self._angle = track.phase_rad
        self._so_far = np.full(len(track.time_s), np.nan)
        if rate is not None:
            self._used = np.isin(track.time_s, rate.history.angle.time_s[rate.fit.used])
            self._angle = _turning(track, rate.aliases.chosen_rad_s)
            ppm = 1e6 * rate.sd_rad_s / rate.rate_rad_s
            sd = f"{ppm:.0f} ppm" if ppm < 1000 else f"{1e-4 * ppm:.1f} %"
            self._rate = f"{rate.rate_rad_s / RPM:.4f} rpm +- {sd}, {rate.direction}"
            self._so_far[rate.history.angle.index] = rate.history.rate_so_far_rad_s

    def on(self, frame: Frame, i: int | None) -> Image:
        """The i-th frame of the track with everything drawn, shape (h, w, 3), sides even.

        If ``i`` is None, the plate was not tracked in the frame.
        """
        image = frame.bgr
        h, w = (side // EVEN * EVEN for side in image.shape[:2])
        canvas = np.ascontiguousarray(image[:h, :w])
        where = "not followed, left out"
        if i is not None:
            where = "plate not seen, left out"
            angle = float(self._angle[i])
            draw_plate(canvas, self._track.plate, angle, self._scale, self._track.motion[i],
                       bool(self._used[i]))
            if np.isfinite(angle):
                where = f"{np.degrees(self._track.plate.mark[1] + angle) % 360:5.1f} deg"
                if not self._used[i]:
                    where += ", left out"
                elif np.isfinite(self._so_far[i]):
                    where += f"   {self._so_far[i] / RPM:.4f} rpm so far"
        larger = max(1.0, w / TEXT_WIDTH)
        if i is None or not self._used[i]:
            cv2.rectangle(canvas, (0, 0), (w - 1, h - 1), UNUSED, round(BORDER_PX * larger))
        strong = round(larger)
        cv2.rectangle(canvas, (0, 0), (w, round((2 * LINE_PX + 4) * larger)), (0, 0, 0), -1)
        for line, text in enumerate((self._rate, f"{frame.time_s:7.2f} s   {where}"), start=1):
            at = (round(8 * larger), round((LINE_PX * line - 4) * larger))
            cv2.putText(canvas, text, at, FONT, 0.55 * larger, TEXT, strong, cv2.LINE_AA)
        return canvas


def _turning(track: PhaseTrack, rate_rad_s: float) -> FloatArray:
    """The angles, (f,), of a plate that looks the same several times per turn, at the chosen rate.

    No frame identifies its parts; the hand stays on one of them.
    """
    part = 2 * np.pi / track.plate.symmetry
    seen = np.flatnonzero(np.isfinite(track.phase_rad))
    first = seen[0]
    expected = track.phase_rad[first] + rate_rad_s * (track.time_s - track.time_s[first])
    return np.asarray(track.phase_rad + part * np.round((expected - track.phase_rad) / part))
