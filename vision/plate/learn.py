"""Finds the plate among the proposals and learns what it looks like, from the first frames."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vision.errors import RateRefused
from vision.geometry import FloatArray, PlateView
from vision.plate.background import every_nth, median_image, repeated, spread_choice
from vision.plate.channel import Brightness, Channel, channels
from vision.plate.detect import proposals
from vision.plate.mark import symmetry
from vision.plate.polar import polar_grid, ring_spectra
from vision.plate.refusal import why_it_jumps, why_nothing_turns
from vision.plate.rotation import CoarseRotation, coarse_rotation, same_spindle, seek_spindle
from vision.plate.template import Alignment, Template, align
from vision.plate.view_refinement import motion_basis
from vision.video import Frame, Luma

COMPARED_EVERY = (8, 4)  # rows and columns apart, to see whether a frame is the one before again
COARSE_AZIMUTHS = 256
COARSE_RADII = np.linspace(0.1, 0.97, 20)
COARSE_FRAMES = 100
COARSE_ITERATIONS = 8
COARSE_STEP = 1e-3  # of the radius: what is left of the view's error is for the fine template
PROMISING = 0.15  # share of the energy that turns together, for a proposal to be looked into
COHERENT = 0.3  # the same about the refined axis, and by the template, for it to be a plate
CERTAIN = 0.8  # the same, for no other proposal to be looked into
AS_GOOD = 0.8  # of the highest varying energy
MORE = 1.2  # times as much energy turns in a plate as in its label, for the plate to be taken
GROWN = 1.4  # times the outline's radius, or less by as much: the view has run away
SMOOTH_RAD = 0.06  # median second difference from the rough angle: a plate has inertia,
SMOOTH_STEP = 0.5  # or this share of the usual step, where stamps and frames go by jerks
JERKY_RAD = 0.25  # but no more than this
SLIPPING = 0.5  # of the usual step: what stands or goes slowly took the place of the plate
FINE_FRAMES = 28
FINE_ITERATIONS = 3
RING_SPACING_PX = 1.0
MOST_RINGS = 32
KEPT_INFORMATION = 0.97


@dataclass(frozen=True, eq=False)
class PlateModel:
    """The plate: what of the frames was followed, what stands still in brightness, template on
    the rings worth looking at, rough rate, symmetry, notes.
    """

    channel: Channel
    background: Luma
    template: Template
    rate_rad_s: float
    symmetry: int
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _LearningFrames:
    """The frames that are learned from."""

    images: list[Luma]
    time_s: FloatArray
    still: Luma
    on_step: Callable[[], None]

    @property
    def some(self) -> NDArray[np.intp]:
        """Indices of the frames that templates are made from."""
        return every_nth(len(self.images), -(-len(self.images) // COARSE_FRAMES))

    def rotation(self, view: PlateView) -> CoarseRotation:
        """Rough motion about an axis."""
        self.on_step()
        grid = polar_grid(view, COARSE_RADII, COARSE_AZIMUTHS // 2, self.still.shape)
        strips = grid.beyond(grid.strip(self.still).astype(np.float32), self.images)
        return coarse_rotation(ring_spectra(strips), grid.weight(), self.time_s)

    def coarse(self, view: PlateView, rotation: CoarseRotation) -> Alignment:
        """The template on a coarse grid, the view found on the way."""
        some = self.some
        return align(
            [self.images[i] for i in some],
            self.still,
            rotation.angle_rad[some],
            polar_grid(view, COARSE_RADII, COARSE_AZIMUTHS, self.still.shape),
            first=(some >= rotation.clearest.start) & (some < rotation.clearest.stop),
            iterations=COARSE_ITERATIONS,
            smallest_step=COARSE_STEP,
            find_covered=True,
            find_readout=False,
            on_step=self.on_step,
        )

    def fine(self, coarse: Alignment) -> Alignment:
        """The template again at the clip's own resolution, on the rings that carry the angle."""
        view = coarse.template.grid.view
        azimuths = 1024 if view.radius_px > 60 else 512
        radius = _worthwhile_rings(coarse.template, view)
        usable = np.flatnonzero(coarse.used)
        chosen = usable[spread_choice(len(usable), FINE_FRAMES)]
        return align(
            [self.images[i] for i in self.some[chosen]],
            self.still,
            coarse.angle_rad[chosen],
            coarse.template.grid.refined(radius, azimuths, self.still.shape),
            first=np.ones(len(chosen), bool),
            iterations=FINE_ITERATIONS,
            smallest_step=0.0,
            find_covered=False,
            find_readout=True,
            on_step=self.on_step,
        )


def learn(
    name: str, frames: list[Frame], given: PlateView | None, on_step: Callable[[], None]
) -> PlateModel:
    """Find and learn the plate; ``on_step`` is called often, and ends it by raising.

    Raises
    ------
    RateRefused
        No proposal turns about a fixed axis, in any channel of the frames.
    """
    refusal = RateRefused(f"{name}: the clip has no colour that changes.")
    for channel in channels(frames):
        try:
            return _learn(name, frames, channel, given, on_step)
        except RateRefused as error:
            refusal = error
    raise refusal


def _learn(
    name: str,
    frames: list[Frame],
    channel: Channel,
    given: PlateView | None,
    on_step: Callable[[], None],
) -> PlateModel:
    frames = _without_repeated(frames, channel)
    images = [channel(frame) for frame in frames]
    still = median_image(images)
    on_step()
    views = [given] if given is not None else proposals(still, images)
    outlined = still
    if not isinstance(channel, Brightness):  # the rim may have no colour of its own
        bright = [frame.luma for frame in frames]
        outlined = median_image(bright)
        views += proposals(outlined, bright) if given is None else []
    seen = _LearningFrames(images, np.array([frame.time_s for frame in frames]), still, on_step)
    tried = [seek_spindle(view, seen.rotation, CERTAIN) for view in views]
    found, jumping, best = _chosen(tried, seen)
    fine = None if found is None else seen.fine(found)
    if found is not None and fine is not None and fine.template.turning.any():
        lasts = np.maximum(np.diff(seen.time_s[seen.some]), 1e-6)
        rate = float(np.median(np.diff(found.angle_rad) / lasts))
        notes = _others_turning(name, fine.template.grid.view, tried)
        return PlateModel(channel, outlined, fine.template, rate, symmetry(fine.template), notes)
    if jumping is not None:
        raise RateRefused(f"{name}: {why_it_jumps(jumping.template, still.shape)}")
    raise RateRefused(f"{name}: {why_nothing_turns(tried, best, still.shape)}")


def _chosen(
    tried: list[tuple[PlateView, CoarseRotation]], seen: _LearningFrames
) -> tuple[Alignment | None, Alignment | None, float]:
    """The plate among the outlines; one that goes by jumps; the highest coherence of all."""
    promising = [(v, s.varying * v.radius_px**2, s) for v, s in tried if s.coherence > PROMISING]
    most = max((energy for _, energy, _ in promising), default=0.0)
    # Of outlines around the same turning frame the largest is the rim. How much turns together
    # is no measure yet: about an axis that is off, a large outline loses more of it than a small.
    promising.sort(key=lambda item: (item[1] < AS_GOOD * most, -item[0].radius_px))
    best = max((rotation.coherence for _, rotation in tried), default=0.0)
    found: Alignment | None = None
    jumping: Alignment | None = None
    coherence = turning_found = 0.0
    for view, _, rotation in promising:
        coarse = seen.coarse(view, rotation)
        refined = coarse.template.grid.view
        if not 1 / GROWN < refined.radius_px / view.radius_px < GROWN:
            continue
        # Asked again about the refined axis: a steep view can hide most of it at first.
        again = rotation if rotation.coherence > CERTAIN else seen.rotation(refined)
        best = max(best, again.coherence)
        if again.coherence <= max(COHERENT, coherence) or coarse.template.explained < COHERENT:
            continue
        turning = again.coherence * again.varying * refined.radius_px**2
        part_of_it = found is not None and same_spindle(refined, found.template.grid.view)
        if part_of_it and MORE * turning < turning_found:
            continue
        if not _smooth(coarse, rotation.angle_rad[seen.some]):
            jumping = jumping or coarse
            continue
        found, coherence, turning_found = coarse, again.coherence, turning
        if coherence > CERTAIN and coarse.template.explained > CERTAIN:
            break
    return found, jumping, best


def _smooth(found: Alignment, rough_rad: FloatArray) -> bool:
    """The refined angle goes with the rough one, without jumps."""
    beyond = found.angle_rad - rough_rad
    step = float(np.median(np.abs(np.diff(rough_rad))))
    slip = abs(float(np.median(np.diff(beyond))))
    # Stamps may come early and late in turn; then the plate goes on evenly over two frames.
    each, over_two = (float(np.median(np.abs(np.diff(beyond[::n], 2)))) for n in (1, 2))
    even = min(each, over_two) < max(SMOOTH_STEP * step, SMOOTH_RAD)
    return even and each < JERKY_RAD and slip < SLIPPING * step


def _without_repeated(frames: list[Frame], channel: Channel) -> list[Frame]:
    """The frames that are not the one before again: a camera slower than its clip repeats some.

    With them the plate would seem to go by jerks.
    """
    rows, columns = COMPARED_EVERY
    small = [channel(frame)[::rows, ::columns].astype(np.int16) for frame in frames]
    change = np.array([float(np.abs(b - a).mean()) for a, b in pairwise(small)])
    fresh = np.concatenate([[True], ~repeated(change)])
    return [frame for frame, new in zip(frames, fresh, strict=True) if new]


def _others_turning(
    name: str, plate: PlateView, tried: list[tuple[PlateView, CoarseRotation]]
) -> tuple[str, ...]:
    """A word on turning things beside the plate."""
    beside = [
        view
        for view, rotation in tried
        if rotation.coherence > COHERENT
        and float(plate.at_rest.plate(*(np.array(c) for c in view.centre_px))[0]) > 1
    ]
    if not beside:
        return ()
    return (
        f"{name}: more than one thing turns in the frame; the one around "
        f"({plate.centre_px[0]:.0f}, {plate.centre_px[1]:.0f}) px was measured, as the annotated "
        f"frame shows. For another give its rim (plate: centre_px, radius_px).",
    )


def _worthwhile_rings(template: Template, view: PlateView) -> FloatArray:
    """Radii, about a pixel apart, that carry nearly all information on the angle."""
    spectrum = ring_spectra(template.turning)
    slope = motion_basis(spectrum, template.grid.radius, template.grid.azimuths)[-1]
    information = (slope**2).sum(axis=1) * template.grid.weight()
    spacing = RING_SPACING_PX / view.radius_px
    radius = np.arange(template.grid.radius[0], template.grid.radius[-1], spacing)
    at = np.interp(radius, template.grid.radius, information)
    order = np.argsort(-at)
    enough = int(np.searchsorted(np.cumsum(at[order]), KEPT_INFORMATION * at.sum())) + 1
    kept = np.sort(order[: max(enough, 4)])
    if len(kept) > MOST_RINGS:
        kept = kept[np.linspace(0, len(kept) - 1, MOST_RINGS).astype(int)]
    return np.asarray(radius[kept])
