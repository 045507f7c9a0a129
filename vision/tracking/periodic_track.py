"""The angle of a plate whose view no rim and no spindle tells, by the return of the picture.

The clip is read once more, small. How long the picture takes to be itself again comes first; then
every pixel is its own periodic function of one phase (``vision.plate.periodic``).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from vision.drawing import annotated
from vision.errors import NothingRepeats, RateRefused
from vision.geometry import FloatArray, PlateView
from vision.image_return import ImageReturn, image_return, much_varies
from vision.numbers import RPM
from vision.phase_track import LUMA, PhaseTrack, PlateLayout
from vision.plate.background import repeated
from vision.plate.periodic import REACH, PeriodicPixels, informative, periodic_pixels
from vision.plate.pixel_motion import Turning, turning
from vision.tracking.frame_measurement import THUMBNAIL
from vision.video.reader import ClipReader, Frame, Luma
from vision.video.reduction import reduced

SMALL, SMALLER = 320, 128  # pixels of the longer side: of what is measured, of what returns
HELD = 600  #: frames held whole; a limit of memory and time
GLIMPSES = 100  # frames, for whether anything varies
PIXELS = 6000  #: pixels that are measured; a limit of time
MOST_VALUES = 12_000_000  #: values of pixels in all frames; a limit of memory
FEWEST_PIXELS = 500  # in however long a clip
#: |mean exp(i(φ - ωt))| of angles that go at a rate. Derived: no second rate reaches it too.
TOGETHER = 0.5**0.5
CHOSEN_FROM = 300  # frames, from which the pixels are chosen


@dataclass(eq=False)
class _SmallClip:
    """Small frames of a clip: whole ones at first, then only the pixels that tell the angle."""

    factor: int = 1
    frames: list[Luma] = field(default_factory=list)
    time_s: list[float] = field(default_factory=list)
    coding: list[int] = field(default_factory=list)
    motion: list[FloatArray] = field(default_factory=list)
    values: list[NDArray[np.uint8]] = field(default_factory=list)
    shown: Frame | None = None
    returns: ImageReturn | None = None
    varies: bool = False
    mask: NDArray[np.bool_] | None = None

    def add(self, frame: Frame, stated: int | None) -> bool:
        """Take the next frame; false where the clip need not be read further."""
        if self.shown is None:
            self.factor = -(-max(frame.luma.shape) // SMALL)
        if len(self.time_s) <= HELD // 4:
            self.shown = frame
        small = reduced(frame.luma, self.factor)
        self.time_s.append(frame.time_s)
        self.coding.append(frame.coding)
        self.motion.append(frame.motion)
        if self.mask is None:
            self.frames.append(small)
            if len(self.frames) == HELD:
                self.choose(stated)
                return self.returns is not None
        else:
            self.values.append(small[self.mask])
        return True

    def choose(self, stated: int | None = None) -> None:
        """Find the return of the picture, and the pixels that tell the angle best."""
        time = np.array(self.time_s)
        if len(time) < 2:
            return
        frame_s = max(float(np.median(np.diff(time))), 1e-4)
        even = np.arange(time[0], time[-1] + frame_s / 2, frame_s)[: 2 * len(time)]
        at = np.clip(np.searchsorted(time, even - frame_s / 2), 0, len(time) - 1)
        smaller = -(-max(self.frames[0].shape) // SMALLER)
        tiny = np.stack([reduced(small, smaller) for small in self.frames])
        self.returns = image_return(tiny[at], frame_s)
        if self.returns is None:
            self.varies = much_varies(tiny[:: max(1, len(tiny) // GLIMPSES)])
            self.frames = []
            return
        most = min(PIXELS, max(FEWEST_PIXELS, MOST_VALUES // max(stated or 0, len(time))))
        first = np.stack(self.frames[:CHOSEN_FROM])
        chosen = informative(first.reshape(len(first), -1), time[: len(first)],
                             self.returns.period_s, most)
        mask = np.zeros(first[0].size, bool)
        mask[chosen] = True
        self.mask = mask.reshape(first[0].shape)
        self.values = [small[self.mask] for small in self.frames]
        self.frames = []


@dataclass(frozen=True, eq=False)
class PictureReturn:
    """The angle of a picture that returns, in every frame, and what is known of the clip."""

    clip: ClipReader
    small: _SmallClip
    returns: ImageReturn
    values: NDArray[np.uint8]
    pixels: PeriodicPixels
    seen: Turning | None
    notes: tuple[str, ...]

    def track(self, roughly: PhaseTrack | None) -> PhaseTrack:
        """The angle of the plate in every frame.

        Parameters
        ----------
        roughly : PhaseTrack or None
            Of the plate, where it was followed badly: its view and sense, where the pixels show
            none.

        Raises
        ------
        RateRefused
            What returns is no plate that turns once per return; with ``returns``.
        """
        returns = self.returns
        turns = self.seen or _as_followed(roughly, returns, self.small.factor)
        if turns is None:
            raise RateRefused(_only_returns(returns), returns=returns)
        return _track(self.clip, self.small, self.values, self.pixels, turns, self.notes)


def picture_return(
    clip: ClipReader, batches: Iterator[list[Frame]], notes: tuple[str, ...]
) -> PictureReturn:
    """The return of the picture, and its angle in every frame.

    Parameters
    ----------
    clip : ClipReader
        The clip, for its name and size.
    batches : iterator of lists of Frame
        All its frames, brought back onto one of them where the camera moves.
    notes : tuple of str
        On how they were read.

    Raises
    ------
    RateRefused
        The picture does not return.
    """
    small = _SmallClip()
    for frame in (frame for batch in batches for frame in batch):
        if not small.add(frame, clip.frames_stated):
            break
    if small.mask is None and small.frames:
        small.choose()
    returns, mask = small.returns, small.mask
    if returns is None or mask is None:
        lasts = small.time_s[-1] - small.time_s[0] if small.time_s else 0.0
        why = f"Nothing in the picture repeats within its {lasts:.1f} s."
        raise (NothingRepeats if small.varies else RateRefused)(why)
    values, time = np.stack(small.values), np.array(small.time_s)
    pixels = periodic_pixels(values, time, returns.period_s, returns.sd_s)
    return PictureReturn(clip, small, returns, values, pixels, turning(pixels, mask), notes)


def _as_followed(
    roughly: PhaseTrack | None, returns: ImageReturn, factor: int
) -> Turning | None:
    """The view and the sense of a plate that turns once per return.

    It may have been lost in some frames: the angles of the others go together at its rate.
    """
    if roughly is None or roughly.plate.symmetry > 1:
        return None
    shown = np.isfinite(roughly.phase_rad)
    time, phase = roughly.time_s[shown], roughly.phase_rad[shown]
    relative = returns.sd_s / returns.period_s
    finest = 1 / (8 * max(1.0, float(np.ptp(time)) / returns.period_s))
    near = np.arange(-REACH * relative, REACH * relative + finest, finest)
    for way in (1, -1):
        rates = way * returns.rate_rad_s * (1 + near)
        together = np.abs(np.exp(1j * (phase - np.outer(rates, time))).mean(axis=1)).max()
        if together > TOGETHER:
            return Turning(_scaled(PlateView(roughly.plate.view), 1 / factor), way)
    return None


def _only_returns(returns: ImageReturn) -> str:
    relative = returns.sd_s / returns.period_s
    return (
        f"the picture repeats every {returns.period_s:.3g} s ({returns.rate_rad_s / RPM:.1f} rpm "
        f"± {relative:.1%}, {returns.turns} times in a row); no plate is seen well enough for more"
    )


def _track(
    clip: ClipReader, small: _SmallClip, values: NDArray[np.uint8], pixels: PeriodicPixels,
    turns: Turning, notes: tuple[str, ...],
) -> PhaseTrack:
    change = np.abs(np.diff(values.astype(np.int16), axis=0)).mean(axis=1)
    angle = turns.way * pixels.angle_rad
    view = _scaled(turns.view, small.factor)
    shown = small.shown
    assert shown is not None
    h, w = shown.luma.shape
    layout = PlateLayout(
        view=view.matrix,
        reduction=clip.reduction,
        size_px=(w * clip.reduction, h * clip.reduction),
        channel=LUMA,
        symmetry=1,
        explained=float(np.median(pixels.match)) ** 2,
        mark_azimuth_rad=np.nan,
        mark_radius=np.nan,
    )
    return PhaseTrack(
        source=clip.path.name,
        plate=layout,
        time_s=np.array(small.time_s),
        phase_rad=np.asarray(np.angle(np.exp(1j * angle))),
        quality=pixels.match,
        duplicate=repeated(np.concatenate([[np.inf], change])),
        coding=np.array(small.coding).astype(np.uint8),
        thumbnail=values[:, :: max(1, values.shape[1] // THUMBNAIL**2)],
        smear_rad2=pixels.smear_rad2,
        brightness=values.mean(axis=1),
        motion=np.stack(small.motion),
        annotated=annotated(shown.bgr, layout, np.nan),
        notes=(*notes, _how(clip.path.name)),
    )


def _scaled(view: PlateView, factor: float) -> PlateView:
    """The view in pixels of frames that are larger by a factor."""
    middle = (factor - 1) / 2
    return PlateView(np.array([[factor, 0, middle], [0, factor, middle], [0, 0, 1.0]])
                     @ view.matrix)


def _how(source: str) -> str:
    return (
        f"{source}: the plate is seen from the side, or in part, and its angle was measured by the "
        f"return of the picture after every turn, without rim and spindle. Where within a turn it "
        f"is faster or slower this cannot show; film it whole and from above for that."
    )
