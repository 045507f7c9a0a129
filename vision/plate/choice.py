"""Which of the outlines is the plate: what turns in it, how coherently, and how well a template
explains it.
"""

from dataclasses import dataclass

from vision.geometry import PlateView
from vision.plate.inertia import smooth
from vision.plate.learning_frames import LearningFrames
from vision.plate.rotation import CoarseRotation, same_spindle
from vision.plate.template import Alignment

Outline = tuple[PlateView, CoarseRotation]


@dataclass(frozen=True)
class SearchThresholds:
    """Which of the proposals is the plate. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    coherent : float
        Share of the energy that turns together about the proposed and about the refined axis, for
        a proposal to be a plate.
    beyond_noise : float
        Times what a template of noise explains, 1/f of f frames, that a plate's does: the noise of
        a dark film is most of what varies in it. Derived: ten.
    certain : float
        The same, for no other proposal to be looked into.
    whole : float
        Times as much must turn in an outline as in one inside it that turns more coherently, for
        the inner one to be its label only. Tuned on the coasting disc of
        tests.vision.test_real_clips, whose stand lies within the larger outline.
    same_rim : float
        Radii about one spindle, of the larger: two outlines of one rim, of which the template that
        explains more has the better axis. Derived: a label is at most half of its record.
    """

    coherent: float = 0.3
    beyond_noise: float = 10.0
    certain: float = 0.8
    whole: float = 1.2
    same_rim: float = 0.8


THRESHOLDS = SearchThresholds()


@dataclass(frozen=True, eq=False)
class PlateCandidate:
    """An outline that is a plate: its coarse template, how coherently and how much of it turns."""

    coarse: Alignment
    coherence: float
    turning: float
    parts: int = 1

    def rather_than(self, larger: "PlateCandidate") -> bool:
        """Whether this is the plate and not one whose outline is at least as large."""
        view, other = (plate.coarse.template.grid.view for plate in (self, larger))
        if not same_spindle(view, other):
            return self.coherence > larger.coherence
        if view.radius_px > THRESHOLDS.same_rim * other.radius_px:
            return self.coarse.template.explained > larger.coarse.template.explained
        # An inner part that turns more coherently is the plate, unless it is the label only.
        label = THRESHOLDS.whole * self.turning < larger.turning
        return self.coherence > larger.coherence and not label


def chosen_plate(
    outlines: list[Outline], learning: LearningFrames
) -> tuple[PlateCandidate | None, Alignment | None, float]:
    """The plate among the outlines; one that goes by jumps; the highest coherence of all."""
    turning_outlines = [each for each in outlines if each[1].coherence > THRESHOLDS.coherent]
    # Of outlines around the same turning plate the largest is the rim. How much turns together
    # is no measure yet: about an axis that is off, a large outline loses more of it than a small.
    turning_outlines.sort(key=lambda outline: -outline[0].radius_px)
    highest = max((rotation.coherence for _, rotation in outlines), default=0.0)
    plate: PlateCandidate | None = None
    jumping: Alignment | None = None
    for view, rotation in turning_outlines:
        coarse = learning.coarse(view, rotation)
        refined = coarse.template.grid.view
        # Again about the refined axis: a steep view can hide most of it at first.
        certain = rotation.coherence > THRESHOLDS.certain
        again = rotation if certain else learning.rotation(refined)
        highest = max(highest, again.coherence)
        turning = _turning(refined, again)
        candidate = PlateCandidate(coarse, again.coherence, turning)
        if again.coherence < THRESHOLDS.coherent or not _beyond_noise(coarse):
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


def _beyond_noise(coarse: Alignment) -> bool:
    """Whether the template explains more than one of noise: that explains one part in f."""
    frames = int(coarse.used.sum())
    return frames * coarse.template.explained > THRESHOLDS.beyond_noise


def _turning(view: PlateView, rotation: CoarseRotation) -> float:
    """How much turns inside an outline."""
    return rotation.coherence * rotation.varying * view.radius_px**2


def or_of_parts(
    plate: PlateCandidate | None, views: list[PlateView], learning: LearningFrames
) -> PlateCandidate | None:
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
    if not _beyond_noise(coarse):
        return plate
    return PlateCandidate(coarse, equal.rotation.coherence, turning, equal.count)
