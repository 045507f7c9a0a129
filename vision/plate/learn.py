"""Choice of the plate among the proposals and its template, from the first frames."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vision.errors import NothingMoves, OnlyLight, RateRefused, more_telling
from vision.geometry import PlateView
from vision.numbers import RPM, median, quantile
from vision.plate.background import OFTEN, change_over_noise, halved, median_image, spread_choice
from vision.plate.channel import Brightness, Channel
from vision.plate.choice import Outline, chosen_plate, or_of_parts, seek_spindle
from vision.plate.detect import proposals
from vision.plate.lamp import changing_light, in_even_light
from vision.plate.learning_frames import LearningFrames
from vision.plate.mark import symmetry
from vision.plate.refusal import why_it_jumps, why_nothing_moves, why_nothing_turns
from vision.plate.second_rate import turns_itself
from vision.plate.template import Alignment, Template
from vision.video.reader import Frame

CHANGE_OF = 60  # frames that are tested for any change


@dataclass(frozen=True, eq=False)
class PlateModel:
    """The learned plate.

    Attributes
    ----------
    channel : Channel
        Measured quantity of the frames.
    template : Template
        On the rings that carry the angle.
    rate_rad_s : float
        Rough rate, counter-clockwise as filmed.
    symmetry : int
        Number of times per turn that the plate looks the same.
    notes : tuple of str
        Notes for the user.
    """

    channel: Channel
    template: Template
    rate_rad_s: float
    symmetry: int
    notes: tuple[str, ...]


def learn(
    name: str,
    frames: list[Frame],
    seen: Sequence[Channel],
    rim: PlateView | None,
    on_step: Callable[[], None],
) -> PlateModel:
    """Find and learn the plate.

    Parameters
    ----------
    name : str
        Name of the clip, for messages.
    frames : list of Frame
        Frames of about two turns.
    seen : sequence of Channel
        Channels that are tried in turn.
    rim : PlateView, optional
        Rim measured by the user; None proposes rims from the frames.
    on_step : callable
        Called often; an exception that it raises ends the work.

    Raises
    ------
    RateRefused
        No proposal turns about a fixed axis, in any of the channels.
    """
    refusal: RateRefused | None = None
    for channel in seen:
        try:
            return _learn(name, frames, channel, rim, on_step)
        except RateRefused as error:
            refusal = more_telling(refusal, error)
    raise refusal or NothingMoves(f"{name}: {why_nothing_moves([frames[0].luma], 0, None)}")


def _learn(
    name: str,
    frames: list[Frame],
    channel: Channel,
    rim: PlateView | None,
    on_step: Callable[[], None],
) -> PlateModel:
    some = [frames[i] for i in spread_choice(len(frames), CHANGE_OF)]
    small = [halved(channel(frame)) for frame in some]
    change = change_over_noise(small)
    lumas = small if isinstance(channel, Brightness) else [halved(frame.luma) for frame in some]
    lines = changing_light(lumas)
    if quantile(change, OFTEN) < 1:
        raise NothingMoves(f"{name}: {why_nothing_moves(small, int((change > 1).sum()), lines)}")
    images = in_even_light([channel(frame) for frame in frames], lines)
    background = median_image(images)
    on_step()
    views = proposals(background, images) if rim is None else [rim]
    in_brightness = background
    if not isinstance(channel, Brightness):  # the rim may have no colour of its own
        lumas = [frame.luma for frame in frames]
        in_brightness = median_image(lumas)
        views += proposals(in_brightness, lumas) if rim is None else []
    learning = LearningFrames(
        images, np.array([frame.time_s for frame in frames]), background, on_step
    )
    views.sort(key=lambda view: -view.radius_px)
    outlines = [seek_spindle(view, learning) for view in views]
    plate, learning, jumping = chosen_plate(outlines, learning)
    plate = or_of_parts(plate, outlines, learning)
    fine = None if plate is None else learning.fine(plate.coarse, plate.parts)
    if plate is not None and fine is not None and fine.template.turning.any():
        lasts = np.maximum(np.diff(learning.time_s[learning.chosen]), 1e-6)
        rate = float(median(np.diff(plate.coarse.angle_rad) / lasts))
        alike = plate.parts if plate.parts > 1 else symmetry(fine.template, plate.coarse)
        notes = _others_turning(
            name, plate.coarse, fine.template.grid.view, outlines, learning, whole=alike == 1)
        return PlateModel(channel, fine.template, rate, alike, notes)
    if lines is not None:
        raise OnlyLight(f"{name}: {why_nothing_moves(small, 0, lines)}")
    if jumping is not None:
        raise RateRefused(f"{name}: {why_it_jumps(jumping, learning.time_s[learning.chosen])}")
    why = why_nothing_turns([rotation for _, rotation in outlines], in_brightness)
    raise RateRefused(f"{name}: {why}")


def _others_turning(
    name: str, plate: Alignment, view: PlateView, outlines: list[Outline],
    learning: LearningFrames, *, whole: bool,
) -> tuple[str, ...]:
    """A note on another rotation: beside the plate, or of a ``whole`` plate about its spindle."""
    lasts_s = float(np.ptp(learning.time_s))
    where, second = "beside it", max(
        (rotation for rim, rotation in outlines
         if not rim.encloses(*view.centre_px) and turns_itself(rotation, lasts_s)),
        key=lambda rotation: rotation.coherence, default=None)
    if second is None and whole:
        remainder, angle_rad = learning.remainder(view, plate)
        if turns_itself(remainder, lasts_s, angle_rad):
            where, second = "about its spindle", remainder
    if second is None:
        return ()
    x, y = view.centre_px
    of_frames_s = float(np.ptp(learning.time_s[learning.chosen]))
    first_rpm, second_rpm = (
        abs(angle_rad[-1] - angle_rad[0]) / in_s / RPM for angle_rad, in_s in (
            (plate.angle_rad, of_frames_s), (second.angle_rad, lasts_s)))
    return (
        f"{name}: two things turn in the frame, at about {first_rpm:.3g} rpm and, "
        f"{where}, {second_rpm:.3g} rpm. The rate is that of the first, around "
        f"({x:.0f}, {y:.0f}) px. If the sensor turns with the second, cover the first or state the "
        f"rim of the second (--rim, or plate: centre_px, radii_px).",
    )
