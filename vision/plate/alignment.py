"""Template, angles and view from some frames, estimated in turn.

The model is D_i = S + T(φ - θ_i) (``vision.plate.template``), the view that of
``vision.plate.view_refinement``. Each iteration takes the mean of the frames turned back as T,
their correlation with it as θ_i, what is left on average as a change of S, and moves the view to
where the residual has no part that turns backwards.

Where frames come at a nearly whole number per turn (27 at 15 fps and 33 1/3 rpm), waves of that
many periods per turn stand nearly still: they fit S as well as T. Left to the way the iteration
begins, some of the plate's own texture would be taken off as standing still, and the slow drift of
the plate through its places would look larger than it is; or what stands would count as texture,
and the drift look smaller. So such orders are solved for with what S and T take from each other in
mind, or belong to S alone.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import VIEW_PARAMETERS, FloatArray, PlateView
from vision.numbers import median
from vision.plate.inertia import carried_on, turns_on
from vision.plate.polar import Grid, Spectra, Strips, ring_spectra
from vision.plate.template import THRESHOLDS as STANDS
from vision.plate.template import (
    Alignment,
    RoughlyAligned,
    Template,
    correlated_angle,
    energy,
    mean_turning,
    pattern_spectra,
    standing_share,
    turned,
)
from vision.plate.view_refinement import view_change

NEIGHBOURHOOD = 3  # rings and azimuths
HALF = 0.5
"""Share of the energy of the frame that shows most; derived: midway between a mark that is in the
frame and one that is not."""
MARGIN = (3, 5)  # rings and azimuths left out about a covered place, whose edges are mixed


@dataclass(frozen=True)
class AlignmentThresholds:
    """What enters the template. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    outlier : float
        Times the median misfit: a hand, a flash.
    share_sd : float
        Sd of the share seen, above which a place is not judged covered. Derived: a share of one
        half is six of them away from the whole.
    passing : float
        Of the ring's mean expected energy: a place that less passes is not judged.
    shown : float
        Of the expected change, below which a place counts as covered.
    hidden : float
        Times the turning energy: a frame whose mark is covered misfits by less. Tuned on the
        grazing clip of tests.vision.test_real_clips.
    separated : float
        Of the misfit's energy, that still moves from what turns to the background.
    largest_step : float
        Of the radius, change of the view per iteration at most.
    least_change : float
        Share of a background error that the misfit shows at least, where part of the plate is not
        seen.
    """

    outlier: float = 3.0
    share_sd: float = 0.08
    passing: float = 0.1
    shown: float = 0.5
    hidden: float = 1.5
    separated: float = 0.1
    largest_step: float = 0.05
    least_change: float = 0.5


THRESHOLDS = AlignmentThresholds()


@dataclass(frozen=True)
class Effort:
    """How far the iteration goes.

    Attributes
    ----------
    iterations : int
        At most.
    smallest_step : float
        Of the radius: it ends where the view would change by less.
    find_covered : bool
        Leave out, at the end, where something stands in front of the plate.
    find_readout : bool
        Estimate the lag of the read-out too. It looks much like an axis that is off, so only once
        the axis is nearly right.
    """

    iterations: int
    smallest_step: float
    find_covered: bool
    find_readout: bool


def align(
    frames: RoughlyAligned, grid: Grid, effort: Effort, on_step: Callable[[], None]
) -> Alignment:
    """Estimate S, T, the angles and the view in turn; ``on_step`` is called before each iteration.

    Parameters
    ----------
    frames : RoughlyAligned
    grid : Grid
        In the view to begin with.
    effort : Effort
    on_step : callable
        What it raises ends the work.
    """
    fit = _Fit(frames, grid)
    for iteration in range(effort.iterations):
        on_step()
        fit.estimate_template(first=iteration == 0)
        fit.reject_outliers()
        last = iteration == effort.iterations - 1
        if last or not fit.turning.any() or fit.refine_view(effort):
            break
    if effort.find_covered:
        fit.leave_out_covered()
    return fit.alignment()


class _Fit:
    """The state of the iteration; arrays as in ``vision.plate.template``."""

    def __init__(self, frames: RoughlyAligned, grid: Grid) -> None:
        self._frames, self._grid = frames, grid
        self._angle = frames.angle_rad
        self._used = frames.first
        self._shows = frames.shows
        self._angles_hold = bool(frames.first.all())
        self._background = grid.strip(frames.background).astype(np.float32)
        self._beyond_median = np.zeros_like(self._background)  # of the background
        self._difference = grid.differences(self._background, frames.images)
        self._standing = np.zeros(grid.azimuths // 2 + 1, np.float32)
        self._standing[np.arange(len(self._standing)) % frames.parts != 0] = 1
        self._best_misfit, self._best_view, self._view_settled = np.inf, grid.view, False
        self.turning: Spectra
        self._turned: Strips
        self._misfit: Strips
        self._stood: Strips
        self._misfit_energy: NDArray[np.float32]

    def estimate_template(self, *, first: bool) -> None:
        """T, the angles, S and what they leave."""
        grid = self._grid
        spectra = pattern_spectra(self._difference)
        turning = mean_turning(spectra, self._angle, self._used, grid, self._standing)
        if not (first and self._angles_hold):
            self._carry_on(correlated_angle(
                spectra, turning, grid, self._angle, self._frames.parts, near=self._angles_hold))
        if first:
            self._used = np.ones(len(self._angle), bool)
            self._standing = standing_share(
                self._angle, len(self._standing), self._frames.parts,
                leaves=self._mark_leaves(turning))
        self.turning = mean_turning(spectra, self._angle, self._used, grid, self._standing)
        self._turned = turned(self.turning, self._angle, grid)
        self._misfit = self._difference - self._turned
        # What the model leaves, averaged over all angles, stood still after all.
        self._stood = self._misfit[self._used].mean(axis=0)
        self._misfit -= self._stood
        change = _background_change(self._stood, self._standing, grid.seen)
        self._background = self._background + change
        self._beyond_median = self._beyond_median + change
        self._difference -= change

    def _mark_leaves(self, turning: Spectra) -> bool:
        """Whether most of what turns is out of sight at some of the angles."""
        if self._grid.seen.all():
            return False
        shown = energy(turned(turning, self._angle, self._grid), self._grid)
        return bool(shown.min() < HALF * shown.max())

    def _carry_on(self, angle_rad: FloatArray) -> None:
        """Take the angles that the frames show; elsewhere those that a plate has meanwhile."""
        rough = self._frames.angle_rad
        self._shows = self._frames.shows if self._angles_hold else turns_on(angle_rad, rough)
        if not self._shows.any():  # none to carry on from
            self._shows = np.ones(len(rough), bool)
        self._angle = carried_on(angle_rad, rough, self._shows)

    def reject_outliers(self) -> None:
        """Leave out frames with something in the way.

        The misfit is noise, and a share of what turns and is seen: of a mark that is in the frame
        for a part of each turn it is large there, and nowhere else.
        """
        self._misfit_energy = energy(self._misfit, self._grid)
        turning = energy(self._turned, self._grid)
        plain = turning >= HALF * turning.max()
        share = float(median(self._misfit_energy[plain] / np.maximum(turning[plain], 1e-9)))
        usual = np.maximum(share * turning, median(self._misfit_energy))
        self._used = self._misfit_energy <= THRESHOLDS.outlier * usual

    def refine_view(self, effort: Effort) -> bool:
        """Move the view to where the misfit is least; True where it stays within the last step."""
        usual = float(median(self._misfit_energy))
        if usual > self._best_misfit:
            # What does not turn with the plate (a hand) pulls the view away; go back and stay.
            self._view_settled = True
            self._move(self._best_view)
        elif not self._view_settled:
            self._best_misfit, self._best_view = usual, self._grid.view
            change = view_change(
                self._misfit[self._used],
                self._angle[self._used],
                self.turning,
                self._grid,
                VIEW_PARAMETERS if effort.find_readout else VIEW_PARAMETERS - 1,
            )
            still_moving = float(energy(self._stood[None], self._grid)[0])
            separated = still_moving < THRESHOLDS.separated * usual
            if separated and float(np.abs(change).max()) < effort.smallest_step:
                return True
            largest = max(float(np.abs(change[:4]).max()), 1e-12)
            limit = min(1.0, THRESHOLDS.largest_step / largest)
            self._move(self._grid.view.adjusted(limit * change))
        return False

    def _move(self, view: PlateView) -> None:
        """Sample the frames in another view."""
        if view is self._grid.view:
            return
        background, images = self._frames.background, self._frames.images
        self._grid = self._grid.moved(view, background.shape)
        self._background = self._grid.strip(background).astype(np.float32) + self._beyond_median
        self._difference = self._grid.differences(self._background, images)

    def leave_out_covered(self) -> None:
        """Mark in the grid where something stands in front of the plate."""
        # A mark that is hidden is missing once; a hand adds more than that.
        fair = self._misfit_energy <= THRESHOLDS.hidden * energy(self._turned, self._grid)
        if fair.any():
            self._grid = _without_covered(self._grid, self._difference[fair], self._turned[fair])

    def alignment(self) -> Alignment:
        """The template as it stands."""
        grid, used = self._grid, self._used
        varying = (self._difference[used] - self._difference[used].mean(axis=0)) * grid.seen
        total = float(energy(varying, grid).sum()) / len(used)
        unexplained = float(energy(self._misfit[used] * grid.seen, grid).sum()) / len(used)
        turning = np.fft.irfft(self.turning, grid.azimuths, axis=-1).astype(np.float32)
        template = Template(
            grid, self._background, turning, explained=1 - unexplained / max(total, 1e-9),
            varying=total * grid.view.radius_px**2 / grid.azimuths)
        return Alignment(template, self._angle, used, self._shows)


def _background_change(misfit: Strips, standing: NDArray[np.float32], seen: Strips) -> Strips:
    """Change of S from the mean misfit, for which T has made room.

    Where S is wrong by δ, T has taken its turning share mean exp(ikθ) of it, and the mean misfit
    shows (1 - |mean exp(ikθ)|²) δ only. Where part of the plate is not seen it shows δ more or
    less, up to the whole, and a step that is twice too long would go to and fro for good.
    """
    shown = np.where(standing > STANDS.standing, 1, 1 - standing)
    if not seen.all():
        shown = np.maximum(shown, THRESHOLDS.least_change)
    spectrum = ring_spectra(misfit) / shown
    return np.fft.irfft(spectrum, misfit.shape[-1], axis=-1).astype(np.float32) * seen


def _without_covered(grid: Grid, seen: Strips, expected: Strips) -> Grid:
    """Leave out where the plate is covered: what should turn through there does not show.

    The share of the expected frame that is seen, Σ seen·expected / Σ expected², over a
    neighbourhood: 1 in the open, 0 under a tonearm, with the variance σ² / Σ expected² from the
    frame noise σ.
    """
    around = (NEIGHBOURHOOD, NEIGHBOURHOOD)
    passed = cv2.boxFilter((expected**2).sum(axis=0), -1, around, normalize=False)
    shown = cv2.boxFilter((seen * expected).sum(axis=0), -1, around, normalize=False)
    noise = float(((seen - expected) ** 2).mean())
    clear = passed * THRESHOLDS.share_sd**2 > noise
    # Of a plate that keeps step with the frames hardly anything passes between its places.
    clear &= passed > THRESHOLDS.passing * passed.mean(axis=1, keepdims=True)
    covered = (clear & (shown < THRESHOLDS.shown * passed)).astype(np.uint8)
    # A single sample is noise. The strip closes on itself in azimuth.
    ends = MARGIN[1]
    covered = np.pad(covered, ((0, 0), (ends, ends)), mode="wrap")
    covered = cv2.morphologyEx(covered, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
    covered = cv2.dilate(covered, np.ones(MARGIN, np.uint8))[:, ends:-ends]
    return replace(grid, uncovered=(1 - covered).astype(np.float32))
