"""Frames from which a plate is learned: rough motion about an axis, coarse and fine template."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.plate.alignment import Effort, align
from vision.plate.background import every_nth, spread_choice
from vision.plate.low_orders import PixelSeries
from vision.plate.parts import EqualParts, equal_parts
from vision.plate.polar import Grid, Strips, polar_grid
from vision.plate.rotation import CoarseRotation, RotationSearch
from vision.plate.second_rate import left_by
from vision.plate.template import Alignment, RoughlyAligned, informative_rings
from vision.video.reader import Luma

COARSE_AZIMUTHS = 256  #: azimuths of the first template
COARSE_RADII = np.linspace(0.1, 0.97, 20)  # plate radii
COARSE_WEIGHT = COARSE_RADII.astype(np.float32)  # pixels of the clip per sample, no unit
AROUND_RADII = np.linspace(0.1, 2.6, 52)  # plate radii: a label may be taken for the plate
COARSE_FRAMES = 100  #: at most; a limit of time
FINE_FRAMES = 28  #: frames of the fine template; a limit of time
#: The number of azimuths of the fine template, by the radius in pixels above which it holds.
FINE_AZIMUTHS = {60: 1024, 0: 512}
#: The fine template corrects the remaining error of the view.
COARSE = Effort(iterations=8, smallest_step=1e-3, find_covered=True, find_readout=False)
#: The fine template refines the coarse one, and adds the read-out of the rows.
FINE = Effort(iterations=3, smallest_step=0.0, find_covered=False, find_readout=True)


@dataclass(frozen=True, eq=False)
class LearningFrames:
    """The frames from which the plate is learned."""

    images: list[Luma]
    time_s: FloatArray
    background: Luma
    on_step: Callable[[], None]

    @cached_property
    def _series(self) -> PixelSeries:
        return PixelSeries(self.images)

    @cached_property
    def _search(self) -> RotationSearch:
        return RotationSearch(self.time_s)

    @property
    def chosen(self) -> NDArray[np.intp]:
        """Indices (≤ COARSE_FRAMES,) of the frames for the templates."""
        return every_nth(len(self.images), -(-len(self.images) // COARSE_FRAMES))

    def without(self, view: PlateView) -> "LearningFrames":
        """The frames with all that is inside an outline at rest."""
        inside = view.encloses(*np.indices(self.background.shape, float)[::-1])
        rest = [np.where(inside, self.background, image) for image in self.images]
        return replace(self, images=rest)

    def rotation(self, view: PlateView) -> CoarseRotation:
        """Rough motion about the spindle of a view."""
        self.on_step()
        return self._search.about(self._series.low_orders(view, COARSE_RADII), COARSE_WEIGHT)

    def remainder(self, view: PlateView, coarse: Alignment) -> tuple[CoarseRotation, FloatArray]:
        """Rough motion about a plate's spindle of all that slips on it; plate angles, (f,)."""
        angle = np.interp(self.time_s, self.time_s[self.chosen], coarse.angle_rad)
        spectra = self._series.low_orders(view, AROUND_RADII)
        weight = AROUND_RADII.astype(np.float32)
        rest, share = left_by(spectra, angle)
        seen = self._search.about(rest, weight)
        return replace(seen, coherence=share * seen.coherence), angle

    def parts(self, view: PlateView) -> EqualParts | None:
        """Equal parts that pass around an axis; None without any."""

        def sample(about: PlateView, azimuths: int, frames: slice) -> tuple[Grid, Strips]:
            self.on_step()
            grid = polar_grid(about, COARSE_RADII, azimuths, self.background.shape)
            background = grid.strip(self.background).astype(np.float32)
            return grid, grid.differences(background, self.images[frames])

        return equal_parts(view, sample, fine_azimuths(view), self.time_s)

    def coarse(self, view: PlateView, rotation: CoarseRotation, parts: int = 1) -> Alignment:
        """The template on a coarse grid, with a refined view.

        For equal parts, ``rotation`` has the angle of every frame, and the grid resolves each part.
        """
        chosen = self.chosen
        clearest = (chosen >= rotation.clearest.start) & (chosen < rotation.clearest.stop)
        frames = RoughlyAligned(
            [self.images[i] for i in chosen], self.background, rotation.angle_rad[chosen],
            first=clearest, shows=np.ones(len(chosen), bool), parts=parts)
        azimuths = COARSE_AZIMUTHS if parts == 1 else fine_azimuths(view)
        grid = polar_grid(view, COARSE_RADII, azimuths, self.background.shape)
        return align(frames, grid, COARSE, self.on_step)

    def fine(self, coarse: Alignment, parts: int = 1) -> Alignment:
        """The template again at the clip's own resolution, on the rings that carry the angle."""
        template = coarse.template
        usable = np.flatnonzero(coarse.used)
        part = usable[spread_choice(len(usable), FINE_FRAMES)]
        frames = RoughlyAligned(
            [self.images[i] for i in self.chosen[part]], self.background, coarse.angle_rad[part],
            first=np.ones(len(part), bool), shows=coarse.shows[part], parts=parts)
        azimuths = fine_azimuths(template.grid.view)
        radius = informative_rings(template)
        grid = template.grid.refined(radius, azimuths, self.background.shape)
        return align(frames, grid, FINE, self.on_step)


def fine_azimuths(view: PlateView) -> int:
    """Samples around the rings of the fine template."""
    size_px = view.radius_px
    return next(n for radius_px, n in FINE_AZIMUTHS.items() if size_px > radius_px)
