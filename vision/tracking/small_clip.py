"""Small frames of a clip, taken as it is read, and the period of the picture in them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vision.errors import NoPlate, RateRefused
from vision.geometry import FloatArray
from vision.numbers import median
from vision.video.reader import NO_CHROMA, ClipReader, Frame
from vision.video.reduction import reduced

if TYPE_CHECKING:
    from vision.image_return import ImageReturn
    from vision.plate.lamp import Lamp
    from vision.tracking.registration import Registration

SMALL, SMALLER = 320, 128  # pixels of the longer side: for the angle, for the period
HELD = 600  #: frames held whole; a limit of memory and time
PIXELS = 6000  #: number of measured pixels; a limit of time
MOST_VALUES = 12_000_000  #: values of pixels in all frames; a limit of memory
FEWEST_PIXELS = 500  # in a clip of any length
LIGHT_OF = 60  # frames that are tested for a light that changes
CHOSEN_FROM = 300  # frames from which the pixels are chosen


@dataclass(eq=False)
class SmallClip:
    """Small frames of a clip: whole ones at first, then only the pixels that carry the angle.

    They are taken during the search for a plate, so that the clip need not be read again. If the
    camera moves, they are registered to one of them.

    Attributes
    ----------
    clip : ClipReader
        The clip, for its name and size.
    factor : int
        Factor by which its frames are reduced.
    time_s, coding, motion : list
        Data of every frame, as in ``Frame``; the motion in pixels of the small frames.
    values : list of arrays of uint8, shape (p,)
        Values of the chosen pixels in every frame.
    mask : array of bool, shape (h, w), or None
        The chosen pixels; None before they are chosen, and if nothing returns.
    shown : Frame or None
        A frame for display, as read.
    camera : Registration or None
        Registration of a moving camera.
    returns : ImageReturn or None
        The return of the picture.
    refusal : RateRefused or None
        The changes, if nothing returns.
    lamp : Lamp or None
        The light, if it changes in bands or as a whole.
    ended : bool
        No more frames are taken.
    """

    clip: ClipReader
    factor: int = 1
    time_s: list[float] = field(default_factory=list)
    coding: list[int] = field(default_factory=list)
    motion: list[FloatArray] = field(default_factory=list)
    values: list[NDArray[np.uint8]] = field(default_factory=list)
    mask: NDArray[np.bool_] | None = None
    shown: Frame | None = None
    camera: "Registration | None" = None
    returns: "ImageReturn | None" = None
    refusal: RateRefused | None = None
    lamp: "Lamp | None" = None
    ended: bool = False
    _whole: list[Frame] = field(default_factory=list)

    def followed(self, batches: Iterable[list[Frame]]) -> Iterator[list[Frame]]:
        """The batches unchanged, each after its frames were taken."""
        for batch in batches:
            for frame in batch:
                if not self.ended:
                    self._take(frame)
            yield batch

    def end(self) -> None:
        """Take no more frames, and release the whole ones."""
        self.ended, self._whole = True, []

    def _take(self, frame: Frame) -> None:
        if self.shown is None:
            self.factor = -(-max(frame.luma.shape) // SMALL)
        if len(self.time_s) <= HELD // 4:
            self.shown = frame
        small = replace(frame, luma=reduced(frame.luma, self.factor), chroma=NO_CHROMA)
        self.time_s.append(frame.time_s)
        self.coding.append(frame.coding)
        if self.lamp is not None:
            small = replace(small, luma=self.lamp.evened(small.luma))
        if self.mask is None:
            self._whole.append(small)
            if len(self._whole) == HELD:
                self.choose()
        else:
            self._keep_chosen(small if self.camera is None else self.camera.back(small))

    def _keep_chosen(self, small: Frame) -> None:
        self.motion.append(small.motion)
        self.values.append(small.luma[self.mask])

    def choose(self) -> None:
        """Find the return of the picture, and the pixels with most information on the angle."""
        from vision.image_return import image_return
        from vision.plate.background import spread_choice
        from vision.plate.lamp import Lamp, changing_light
        from vision.plate.periodic import informative
        from vision.tracking.registration import registration
        from vision.tracking.what_changes import what_changes

        time, whole = np.array(self.time_s), self._whole
        if self.ended or self.mask is not None or len(whole) < 2:
            return
        lumas = [small.luma for small in whole]
        lines = changing_light([lumas[i] for i in spread_choice(len(lumas), LIGHT_OF)])
        if lines is not None:
            self.lamp = Lamp(np.mean(lumas, axis=0, dtype=np.float32), lines)
            whole = [replace(small, luma=self.lamp.evened(small.luma)) for small in whole]
        self._whole, seen = [], whole
        camera = registration(whole)
        if camera is not None and camera.moves:
            back = [camera.back(small) for small in whole]
            if camera.largest_px < min(whole[0].luma.shape) / 2:  # otherwise another view
                self.camera, whole = camera, back
        frame_s = max(float(median(np.diff(time))), 1e-4)
        even = np.arange(time[0], time[-1] + frame_s / 2, frame_s)[: 2 * len(time)]
        at = np.clip(np.searchsorted(time, even - frame_s / 2), 0, len(time) - 1)
        smaller = -(-max(whole[0].luma.shape) // SMALLER)
        tiny = np.stack([reduced(small.luma, smaller) for small in whole])
        self.returns = image_return(tiny[at], frame_s)
        if self.returns is None:
            self.refusal = what_changes(
                [small.luma for small in seen], time, self.factor * self.clip.reduction
            ) if lines is None else NoPlate(
                f"the light changes, in bands of a lamp or as a whole, and nothing beside it "
                f"repeats within its {np.ptp(time):.1f} s")
            self.end()
            return
        most = max(self.clip.frames_stated or 0, len(time))
        first = np.stack([small.luma.ravel() for small in whole[:CHOSEN_FROM]])
        chosen = informative(first, time[: len(first)], self.returns.period_s,
                             min(PIXELS, max(FEWEST_PIXELS, MOST_VALUES // most)))
        self.mask = np.zeros(whole[0].luma.shape, bool)
        self.mask.flat[chosen] = True
        for small in whole:
            self._keep_chosen(small)
