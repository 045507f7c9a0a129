"""The angle of a plate without a visible rim or spindle, by the return of the picture.

The period of the picture is determined first (``vision.tracking.small_clip``); then every pixel is
a periodic function of one phase (``vision.plate.periodic``).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vision.drawing import annotated
from vision.errors import EqualReturns, NoPlate, OnlyShifts, RateRefused
from vision.geometry import FloatArray, PlateView
from vision.image_return import ImageReturn
from vision.numbers import RPM
from vision.phase_track import LUMA, PhaseTrack, PlateLayout
from vision.plate.background import repeated
from vision.plate.periodic import REACH, PeriodicFit, PeriodicPixels
from vision.plate.pixel_motion import Turning, turning
from vision.tracking.frame_measurement import THUMBNAIL
from vision.tracking.registration import brought_back
from vision.tracking.small_clip import SmallClip

#: |mean exp(i(φ - ωt))| of angles at one rate. Derived: no second rate can reach it as well.
TOGETHER = 0.5**0.5
METHOD = (
    "the angle was measured by the return of the picture after every turn, without rim and "
    "spindle, as these fit no better. This method cannot show changes of the rate within a turn; "
    "to see those, film the whole plate evenly, from above.")


@dataclass(frozen=True, eq=False)
class PictureReturn:
    """The angle of a periodic picture in every frame, and the known data of the clip."""

    small: SmallClip
    returns: ImageReturn
    values: NDArray[np.uint8]
    fit: PeriodicFit
    seen: Turning | None

    @cached_property
    def pixels(self) -> PeriodicPixels:
        """The angle in every frame."""
        return self.fit.pixels()

    def track(self, roughly: PhaseTrack | None, notes: tuple[str, ...]) -> PhaseTrack:
        """The angle of the plate in every frame.

        Parameters
        ----------
        roughly : PhaseTrack or None
            Poor track of the plate, if there is one: its view and sense, if the pixels show none.
        notes : tuple of str
            Notes on the reading of the frames.

        Raises
        ------
        RateRefused
            The periodic picture is not a plate that turns once per return; with ``returns``.
        """
        returns = self.returns
        turns = self.seen or _as_followed(roughly, returns, self.small.factor)
        if turns is None:
            raise RateRefused(_only_returns(returns), returns=returns)
        return _track(self, turns, notes)


def picture_return(small: SmallClip) -> PictureReturn:
    """The return of the picture, and its angle in every frame.

    Parameters
    ----------
    small : SmallClip
        Small frames of the whole clip.

    Raises
    ------
    RateRefused
        The picture does not return, or not like that of a plate.
    """
    small.choose()
    returns, mask = small.returns, small.mask
    if returns is None or mask is None:
        raise small.refusal or RateRefused("the clip has one frame")
    values, time = np.stack(small.values), np.array(small.time_s)
    fit = PeriodicFit(values, time, returns.period_s, returns.sd_s)
    try:
        seen = turning(fit.coefficients, mask)
    except NoPlate as error:
        # Of what passes by the next features need not be as far apart.
        no_turn = isinstance(error, OnlyShifts | EqualReturns)
        what = "each return is a part of a turn" if isinstance(error, EqualReturns) else (
            "what returns is no plate")
        raise type(error)(
            f"the picture repeats every {returns.period_s:.3g} s or so, {returns.turns} times in a "
            f"row, and {what}: {error}", returns=None if no_turn else returns) from error
    return PictureReturn(small, returns, values, fit, seen)


def _as_followed(
    roughly: PhaseTrack | None, returns: ImageReturn, factor: int
) -> Turning | None:
    """The view and the sense of a plate that turns once per return.

    It may have been lost in some frames: the angles of the others agree on its rate.
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
            return Turning(PlateView(_scaling(1 / factor) @ roughly.plate.view), way)
    return None


def _only_returns(returns: ImageReturn) -> str:
    relative = returns.sd_s / returns.period_s
    return (
        f"the picture repeats every {returns.period_s:.3g} s ({returns.rate_rad_s / RPM:.1f} rpm "
        f"± {relative:.1%}, {returns.turns} times in a row); no plate is seen well enough for more"
    )


def _track(picture: PictureReturn, turns: Turning, notes: tuple[str, ...]) -> PhaseTrack:
    small, values, pixels = picture.small, picture.values, picture.pixels
    clip, shown = small.clip, small.shown
    assert shown is not None
    change = np.abs(np.diff(values.astype(np.int16), axis=0)).mean(axis=1)
    angle = turns.way * pixels.angle_rad
    scaling = _scaling(small.factor)
    motion = scaling @ np.stack(small.motion) @ np.linalg.inv(scaling)
    if small.camera is not None:
        here = motion[np.searchsorted(small.time_s, shown.time_s)]
        shown = replace(shown, luma=brought_back(shown.luma, here))
        notes += (small.camera.note(clip.path.name, small.factor * clip.reduction),)
    h, w = shown.luma.shape
    layout = PlateLayout(
        view=scaling @ turns.view.matrix,
        reduction=clip.reduction,
        size_px=(w * clip.reduction, h * clip.reduction),
        channel=LUMA,
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
        motion=motion,
        roll_rad=np.full(len(motion), np.nan),
        annotated=annotated(shown.bgr, layout, np.nan),
        notes=(*notes, f"{clip.path.name}: {METHOD}"),
        leaning_frames=pixels.leaning_frames,
    )


def _scaling(factor: float) -> FloatArray:
    """Pixels of frames to those of frames that are larger by a factor, (3, 3)."""
    middle = (factor - 1) / 2
    return np.array([[factor, 0, middle], [0, factor, middle], [0, 0, 1.0]])
