"""Finds the plate among the proposals and learns what it looks like, from the first frames."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import cv2
import numpy as np

from vision.errors import NothingMoves, RateRefused, more_telling
from vision.geometry import PlateView
from vision.plate.background import median_image, repeated, spread_choice, stands_still
from vision.plate.channel import Brightness, Channel
from vision.plate.detect import moving_areas, proposals
from vision.plate.inertia import smooth
from vision.plate.learning_frames import LearningFrames
from vision.plate.mark import symmetry
from vision.plate.refusal import NOTHING_MOVES, why_it_jumps, why_nothing_turns
from vision.plate.rotation import CoarseRotation, same_spindle, seek_spindle
from vision.plate.template import Alignment, Template
from vision.video import Frame, Luma

CHANGE_OF = 60  # frames, for whether anything changes
LONGEST_REPEAT_S = 0.2  #: fact: a camera that gives fewer than five frames per second is none
COMPARED_EVERY = (8, 4)  # rows and columns apart, to see whether a frame is the one before again


@dataclass(frozen=True)
class SearchThresholds:
    """Which of the proposals is the plate. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    coherent : float
        Share of the energy that turns together about the proposed and about the refined axis, and
        by the template, for a proposal to be a plate.
    certain : float
        The same, for no other proposal to be looked into.
    whole : float
        Times as much must turn in an outline as in one inside it that turns more coherently, for
        the inner one to be its label only. Tuned on the coasting disc of
        tests.vision.test_real_clips, whose stand lies within the larger outline.
    same_rim : float
        Radii about one spindle, of the larger: two outlines of one rim, of which the template that
        explains more has the better axis.
    """

    coherent: float = 0.3
    certain: float = 0.8
    whole: float = 1.2
    same_rim: float = 0.8


THRESHOLDS = SearchThresholds()


@dataclass(frozen=True, eq=False)
class PlateModel:
    """The plate as it was learned.

    Attributes
    ----------
    channel : Channel
        What of the frames is measured.
    background : array of uint8, shape (h, w)
        What stands still, in brightness.
    template : Template
        On the rings that carry the angle.
    rate_rad_s : float
        Rough rate, counter-clockwise as filmed.
    symmetry : int
        How many times per turn the plate looks the same.
    notes : tuple of str
        For the user.
    """

    channel: Channel
    background: Luma
    template: Template
    rate_rad_s: float
    symmetry: int
    notes: tuple[str, ...]

    @property
    def by_brightness(self) -> bool:
        """It is the luma that is measured."""
        return isinstance(self.channel, Brightness)


Outline = tuple[PlateView, CoarseRotation]


def learn(
    name: str,
    frames: list[Frame],
    seen: Sequence[Channel],
    rim: PlateView | None,
    on_step: Callable[[], None],
    *,
    camera_stands: bool = False,
) -> PlateModel:
    """Find and learn the plate.

    Parameters
    ----------
    name : str
        Of the clip, for messages.
    frames : list of Frame
        Of two turns or so.
    seen : sequence of Channel
        What of the frames is looked at, one after the other.
    rim : PlateView, optional
        As the user measured it; proposed from the frames where None.
    on_step : callable
        Called often; what it raises ends the work.
    camera_stands : bool
        What surrounds the plate is seen, and does not move; for the words of a refusal.

    Raises
    ------
    RateRefused
        No proposal turns about a fixed axis, in any of the channels.
    """
    refusal: RateRefused | None = None
    brightness = _InBrightness([frame.luma for frame in frames])
    for channel in seen:
        try:
            return _learn(name, frames, channel, brightness, rim, on_step, camera_stands)
        except RateRefused as error:
            refusal = more_telling(refusal, error)
    raise refusal or NothingMoves(f"{name}: {NOTHING_MOVES}")


class _InBrightness:
    """What every axis of colour needs of the brightness, looked for once.

    Parameters
    ----------
    images : list of arrays of uint8, shape (h, w)
    """

    def __init__(self, images: list[Luma]) -> None:
        self._images = images

    @cached_property
    def background(self) -> Luma:
        """What stands still, shape (h, w)."""
        return median_image(self._images)

    @cached_property
    def outlines(self) -> list[PlateView]:
        """Views of possible plates."""
        return proposals(self.background, self._images)


def _learn(
    name: str,
    frames: list[Frame],
    channel: Channel,
    brightness: "_InBrightness",
    rim: PlateView | None,
    on_step: Callable[[], None],
    camera_stands: bool,
) -> PlateModel:
    if stands_still([channel(frames[i]) for i in spread_choice(len(frames), CHANGE_OF)]):
        raise NothingMoves(f"{name}: {NOTHING_MOVES}")
    frames = _without_repeated(frames, channel)
    images = [channel(frame) for frame in frames]
    background = median_image(images)
    on_step()
    views = proposals(background, images) if rim is None else [rim]
    in_brightness = background
    if not isinstance(channel, Brightness):  # the rim may have no colour of its own
        in_brightness = brightness.background
        views += brightness.outlines if rim is None else []
    learning = LearningFrames(
        images, np.array([frame.time_s for frame in frames]), background, on_step
    )
    outlines = [seek_spindle(view, learning, THRESHOLDS.certain) for view in views]
    if rim is None and not any(r.coherence > THRESHOLDS.coherent for _, r in outlines):
        outlines += [seek_spindle(view, learning, THRESHOLDS.certain)
                     for view in moving_areas(images)]
    plate, jumping, coherence = _chosen(outlines, learning)
    plate = _or_of_parts(plate, [view for view, _ in outlines], learning)
    fine = None if plate is None else learning.fine(plate.coarse, plate.parts)
    if plate is not None and fine is not None and fine.template.turning.any():
        lasts = np.maximum(np.diff(learning.time_s[learning.chosen]), 1e-6)
        rate = float(np.median(np.diff(plate.coarse.angle_rad) / lasts))
        alike = plate.parts if plate.parts > 1 else symmetry(fine.template)
        notes = _others_turning(name, fine.template.grid.view, outlines)
        return PlateModel(channel, in_brightness, fine.template, rate, alike, notes)
    if jumping is not None:
        raise RateRefused(f"{name}: {why_it_jumps(jumping.template, background.shape)}")
    why = why_nothing_turns(outlines, coherence, in_brightness, camera_stands=camera_stands)
    raise RateRefused(f"{name}: {why}")


@dataclass(frozen=True, eq=False)
class _Plate:
    """An outline that is a plate: its coarse template, how coherently and how much of it turns."""

    coarse: Alignment
    coherence: float
    turning: float
    parts: int = 1

    def rather_than(self, larger: "_Plate") -> bool:
        """Whether this is the plate and not one whose outline is at least as large."""
        view, other = (plate.coarse.template.grid.view for plate in (self, larger))
        if not same_spindle(view, other):
            return self.coherence > larger.coherence
        if view.radius_px > THRESHOLDS.same_rim * other.radius_px:
            return self.coarse.template.explained > larger.coarse.template.explained
        # An inner part that turns more coherently is the plate, unless it is the label only.
        label = THRESHOLDS.whole * self.turning < larger.turning
        return self.coherence > larger.coherence and not label


def _chosen(
    outlines: list[Outline], learning: LearningFrames
) -> tuple[_Plate | None, Alignment | None, float]:
    """The plate among the outlines; one that goes by jumps; the highest coherence of all."""
    turning_outlines = [each for each in outlines if each[1].coherence > THRESHOLDS.coherent]
    # Of outlines around the same turning plate the largest is the rim. How much turns together
    # is no measure yet: about an axis that is off, a large outline loses more of it than a small.
    turning_outlines.sort(key=lambda outline: -outline[0].radius_px)
    highest = max((rotation.coherence for _, rotation in outlines), default=0.0)
    plate: _Plate | None = None
    jumping: Alignment | None = None
    for view, rotation in turning_outlines:
        coarse = learning.coarse(view, rotation)
        refined = coarse.template.grid.view
        # Again about the refined axis: a steep view can hide most of it at first.
        certain = rotation.coherence > THRESHOLDS.certain
        again = rotation if certain else learning.rotation(refined)
        highest = max(highest, again.coherence)
        turning = _turning(refined, again)
        candidate = _Plate(coarse, again.coherence, turning)
        if min(again.coherence, coarse.template.explained) < THRESHOLDS.coherent:
            continue
        if plate is not None and not candidate.rather_than(plate):
            continue
        if not smooth(coarse.angle_rad, rotation.angle_rad[learning.chosen]):
            jumping = jumping or coarse
            continue
        plate = candidate
        if min(plate.coherence, coarse.template.explained) > THRESHOLDS.certain:
            break
    return plate, jumping, highest


def _turning(view: PlateView, rotation: CoarseRotation) -> float:
    """How much turns inside an outline."""
    return rotation.coherence * rotation.varying * view.radius_px**2


def _or_of_parts(
    plate: _Plate | None, views: list[PlateView], learning: LearningFrames
) -> _Plate | None:
    """The plate, or one of equal parts around it or in its place, where that turns by more.

    Of such a plate the low orders may show no more than a stain near the spindle.
    """
    if plate is not None and plate.coherence > THRESHOLDS.certain:
        return plate
    largest_first = sorted(views, key=lambda view: -view.radius_px)
    equal = next((parts for view in largest_first if (parts := learning.parts(view))), None)
    if equal is None:
        return plate
    turning = _turning(equal.view, equal.rotation)
    if plate is not None and turning < THRESHOLDS.whole * plate.turning:
        return plate
    coarse = learning.coarse(equal.view, equal.rotation, equal.count)
    if coarse.template.explained < THRESHOLDS.coherent:
        return plate
    return _Plate(coarse, equal.rotation.coherence, turning, equal.count)


def _without_repeated(frames: list[Frame], channel: Channel) -> list[Frame]:
    """The frames that are not the one before again: a camera slower than its clip repeats some.

    With them the plate would seem to go by jerks. Where nothing changes for longer, the mark is out
    of the frame, and what stands behind it is seen best.
    """
    rows, columns = COMPARED_EVERY
    small = [np.ascontiguousarray(channel(frame)[::rows, ::columns]) for frame in frames]
    change = np.array([cv2.norm(b, a, cv2.NORM_L1) for a, b in pairwise(small)])
    again = np.concatenate([[False], repeated(change)])
    time_s = np.array([frame.time_s for frame in frames])
    since_fresh = time_s - np.maximum.accumulate(np.where(again, -np.inf, time_s))
    fresh = ~again | (since_fresh > LONGEST_REPEAT_S)
    return [frame for frame, new in zip(frames, fresh, strict=True) if new]


def _others_turning(name: str, plate: PlateView, outlines: list[Outline]) -> tuple[str, ...]:
    """A note on turning things beside the plate."""
    beside = [
        view
        for view, rotation in outlines
        if rotation.coherence > THRESHOLDS.coherent
        and float(plate.at_rest.plate(*(np.array(c) for c in view.centre_px))[0]) > 1
    ]
    if not beside:
        return ()
    x, y = plate.centre_px
    return (
        f"{name}: more than one thing turns in the frame; the one around ({x:.0f}, {y:.0f}) px was "
        f"measured. To measure another, state its rim (--rim, or plate: centre_px, radii_px).",
    )
