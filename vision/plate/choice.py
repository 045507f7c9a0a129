"""Choice of the plate: the largest thing that turns, in the outline that shows it best.

Of the variation in an outline, E in luma steps squared times pixels and frames, its template
explains the share s. An outline around a label alone has less turning energy, s E, than one around
the record; one with a wrong axis explains less of it, and sets frames aside; one that includes the
surroundings of the plate has a smaller s. The outline with the largest s · s E is the clearest.
If a larger one has its centre elsewhere, all inside the clearest is put at rest, and the rest of
the frames is searched again: of the things that turn the plate is the largest, not the boldest.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import PlateView
from vision.plate.evidence import believed
from vision.plate.inertia import smooth
from vision.plate.learning_frames import LearningFrames
from vision.plate.rotation import WINDOW, CoarseRotation
from vision.plate.template import Alignment

#: Share of the variation that turns together, and that a template explains, from which no further
#: proposal is examined. Derived: one that explains everything determines the plate hardly better.
CERTAIN = 0.8
NEARNESS = (0.1, 0.2, 0.3)  # 1/D tried, D the distance of the camera in plate radii

Outline = tuple[PlateView, CoarseRotation]


@dataclass(frozen=True, eq=False)
class PlateCandidate:
    """An outline in which something turns.

    Its coarse template, the share of the variation that turns together, the number of equal parts.
    """

    coarse: Alignment
    coherence: float
    parts: int = 1

    @property
    def clarity(self) -> float:
        """The product s · s E of the module's text."""
        return self.coarse.template.explained**2 * self.coarse.template.varying

    @property
    def is_certain(self) -> bool:
        """Whether nearly all of the variation turns, and the template explains it."""
        return min(self.coherence, self.coarse.template.explained) > CERTAIN

    @property
    def is_believed(self) -> bool:
        """Whether it explains more than a template of noise."""
        return believed(self.coarse.template.explained, int(self.coarse.used.sum()))


def turns_together(rotation: CoarseRotation) -> bool:
    """Whether the variation in a window of frames turns together more than noise would."""
    return believed(rotation.coherence, min(WINDOW, len(rotation.angle_rad)))


def seek_spindle(view: PlateView, frames: LearningFrames) -> Outline:
    """The view with the spindle at the largest coherence, and its rotation.

    From D radii away, at a tilt α, the spindle appears off the centre of the rim's ellipse by
    sin α / D radii of the plate, on the minor axis. A label may turn about the centre, a rim seen
    steeply does not. If the coherence is already certain, or noise, nothing is searched.
    """
    best, rotation = view, frames.rotation(view)
    if rotation.coherence > CERTAIN or not turns_together(rotation):
        return best, rotation
    squeezed = np.linalg.svd(view.jacobian_at_centre())[2][1]  # direction on the plate
    for side in (1, -1):
        for nearness in NEARNESS:
            u, v = side * nearness * np.sin(view.tilt_rad) * squeezed
            x, y = view.pixels(np.hypot(u, v), np.arctan2(v, u))
            other = view.about(float(x), float(y))
            about_other = frames.rotation(other)
            if about_other.coherence <= rotation.coherence:
                break
            best, rotation = other, about_other
    return best, rotation


def chosen_plate(
    outlines: list[Outline], learning: LearningFrames
) -> tuple[PlateCandidate | None, LearningFrames, Alignment | None]:
    """The plate among the outlines, its frames, and an outline whose angle jumps."""
    plate, jumping = _clearest(outlines, learning)
    thing, rest, size_px = plate, learning, 0.0
    while thing is not None:
        here = thing.coarse.template.grid.view
        reach_px = max(view.radius_px for view, rotation in outlines
                       if here.encloses(*view.centre_px) and turns_together(rotation))
        if reach_px > size_px:
            plate, learning, size_px = thing, rest, reach_px
        apart = [view for view, _ in outlines if not here.encloses(*view.centre_px)]
        if not any(view.radius_px > size_px for view in apart):
            break
        rest = rest.without(here)
        outlines = [seek_spindle(view, rest) for view in apart]
        thing, _ = _clearest(outlines, rest)
    return plate, learning, jumping


def _clearest(
    outlines: list[Outline], learning: LearningFrames
) -> tuple[PlateCandidate | None, Alignment | None]:
    """The outline, of largest first, that shows a turning thing best, and one that jumps."""
    plate: PlateCandidate | None = None
    jumping: Alignment | None = None
    for view, rotation in outlines:
        if not turns_together(rotation):
            continue
        candidate = PlateCandidate(learning.coarse(view, rotation), rotation.coherence)
        if not candidate.is_believed or (plate and candidate.clarity <= plate.clarity):
            continue
        if not smooth(candidate.coarse.angle_rad, rotation.angle_rad[learning.chosen]):
            jumping = jumping or candidate.coarse
            continue
        plate = candidate
        if plate.is_certain:
            break
    return plate, jumping


def or_of_parts(
    plate: PlateCandidate | None, outlines: list[Outline], learning: LearningFrames
) -> PlateCandidate | None:
    """The plate, or one of equal parts around it or in its place, that turns more clearly.

    The low orders of such a plate may show no more than a stain near the spindle.
    """
    if plate is not None and plate.is_certain:
        return plate
    equal = next((parts for view, _ in outlines if (parts := learning.parts(view))), None)
    if equal is None:
        return plate
    coarse = learning.coarse(equal.view, equal.rotation, equal.count)
    candidate = PlateCandidate(coarse, equal.rotation.coherence, equal.count)
    better = plate is None or candidate.clarity > plate.clarity
    return candidate if better and candidate.is_believed else plate
