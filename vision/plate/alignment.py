"""Template, angles and view from some frames, estimated in turn.

The model is D_i = S + T(φ - θ_i) (``vision.plate.template``), the view that of
``vision.plate.view_refinement``. Each iteration takes the mean of the frames turned back as T,
their correlation with it as θ_i, the mean residual as a change of S, and moves the view to where
the residual has no part that turns backwards.

If the number of frames per turn is nearly whole (27 at 15 fps and 33 1/3 rpm), waves of that many
periods per turn are nearly stationary: they fit S as well as T. Depending on the start of the
iteration, S would then absorb some of the plate's own texture, and the slow drift of the plate
through its places would look larger than it is; or T would absorb some of the background, and the
drift would look smaller. Such orders are therefore solved with the coupling of S and T, or belong
to S alone.
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
from vision.plate.template import (
    STANDING,
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
"""Share of the largest energy of a frame; derived: midway between a mark inside the frame and one
outside it."""
MARGIN = (3, 5)  # rings and azimuths left out around a covered place, whose edges are mixed


# Limits for the template. Tuned on tests.bench.vision_scenes unless stated otherwise.
OUTLIER = 3.0  #: misfit of an outlier (a hand, a flash) over the median misfit
SHARE_SD = 0.08
"""Sd of the visible share above which a place is not judged covered. Derived: a share of one half
is six such sds below the whole."""
PASSING = 0.1  #: share of the ring's mean expected energy; a place with less is not judged
SHOWN = 0.5  #: share of the expected change below which a place counts as covered
HIDDEN = 1.5
"""Largest misfit of a frame with a covered mark over the turning energy. Tuned on the grazing clip
of tests.vision.test_real_clips."""
SEPARATED = 0.1
"""Share of the misfit's energy that still moves from the turning part to the background."""
LARGEST_STEP = 0.05  #: largest change of the view per iteration, as a share of the radius
LEAST_CHANGE = 0.5
"""Least share of a background error in the misfit, if part of the plate is not visible."""


@dataclass(frozen=True)
class Effort:
    """Extent of the iteration.

    Attributes
    ----------
    iterations : int
        Largest number of iterations.
    smallest_step : float
        Share of the radius; the iteration ends when the view would change by less.
    find_covered : bool
        Leave out, at the end, the places that something in front of the plate covers.
    find_readout : bool
        Estimate the lag of the read-out too. Its effect resembles that of a wrong axis, so this
        needs an axis that is nearly right.
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
        In the initial view.
    effort : Effort
    on_step : callable
        An exception that it raises ends the work.
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
        self._beyond_median = np.zeros_like(self._background)  # background over the median image
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
        """Estimate T, the angles and S, and compute their residual."""
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
        # The residual averaged over all angles belongs to the background.
        self._stood = self._misfit[self._used].mean(axis=0)
        self._misfit -= self._stood
        change = _background_change(self._stood, self._standing, grid.seen)
        self._background = self._background + change
        self._beyond_median = self._beyond_median + change
        self._difference -= change

    def _mark_leaves(self, turning: Spectra) -> bool:
        """Whether most of the turning part is invisible at some of the angles."""
        if self._grid.seen.all():
            return False
        shown = energy(turned(turning, self._angle, self._grid), self._grid)
        return bool(shown.min() < HALF * shown.max())

    def _carry_on(self, angle_rad: FloatArray) -> None:
        """Take the angles that the frames show; in other frames continue the plate's rotation."""
        rough = self._frames.angle_rad
        self._shows = self._frames.shows if self._angles_hold else turns_on(angle_rad, rough)
        if not self._shows.any():  # none to carry on from
            self._shows = np.ones(len(rough), bool)
        self._angle = carried_on(angle_rad, rough, self._shows)

    def reject_outliers(self) -> None:
        """Leave out frames with something in the way.

        The misfit is noise and a share of the visible turning part: for a mark that is in the frame
        for a part of each turn it is large there, and nowhere else.
        """
        self._misfit_energy = energy(self._misfit, self._grid)
        turning = energy(self._turned, self._grid)
        plain = turning >= HALF * turning.max()
        share = float(median(self._misfit_energy[plain] / np.maximum(turning[plain], 1e-9)))
        usual = np.maximum(share * turning, median(self._misfit_energy))
        self._used = self._misfit_energy <= OUTLIER * usual

    def refine_view(self, effort: Effort) -> bool:
        """Move the view to the least misfit; True if it stays within the last step."""
        usual = float(median(self._misfit_energy))
        if usual > self._best_misfit:
            # An object that does not turn with the plate (a hand) pulls the view away; go back.
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
            separated = still_moving < SEPARATED * usual
            if separated and float(np.abs(change).max()) < effort.smallest_step:
                return True
            largest = max(float(np.abs(change[:4]).max()), 1e-12)
            limit = min(1.0, LARGEST_STEP / largest)
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
        """Mark the places in the grid that something in front of the plate covers."""
        # A hidden mark adds its energy to the misfit once; a hand adds more.
        fair = self._misfit_energy <= HIDDEN * energy(self._turned, self._grid)
        if fair.any():
            self._grid = _without_covered(self._grid, self._difference[fair], self._turned[fair])

    def alignment(self) -> Alignment:
        """The present template."""
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
    """Change of S from the mean misfit, corrected for the share absorbed by T.

    If S is wrong by δ, T has absorbed its turning share mean exp(ikθ) of it, and the mean misfit
    shows only (1 - |mean exp(ikθ)|²) δ. If part of the plate is not visible, it shows more of δ, up
    to the whole, and a step that is twice too long would oscillate forever.
    """
    shown = np.where(standing > STANDING, 1, 1 - standing)
    if not seen.all():
        shown = np.maximum(shown, LEAST_CHANGE)
    spectrum = ring_spectra(misfit) / shown
    return np.fft.irfft(spectrum, misfit.shape[-1], axis=-1).astype(np.float32) * seen


def _without_covered(grid: Grid, seen: Strips, expected: Strips) -> Grid:
    """Leave out covered places of the plate, where the expected change is not visible.

    The visible share of the expected frame, Σ seen·expected / Σ expected², over a
    neighbourhood: 1 in the open, 0 under a tonearm, with the variance σ² / Σ expected² from the
    frame noise σ.
    """
    around = (NEIGHBOURHOOD, NEIGHBOURHOOD)
    passed = cv2.boxFilter((expected**2).sum(axis=0), -1, around, normalize=False)
    shown = cv2.boxFilter((seen * expected).sum(axis=0), -1, around, normalize=False)
    noise = float(((seen - expected) ** 2).mean())
    clear = passed * SHARE_SD**2 > noise
    # If a plate keeps step with the frames, hardly anything passes between its places.
    clear &= passed > PASSING * passed.mean(axis=1, keepdims=True)
    covered = (clear & (shown < SHOWN * passed)).astype(np.uint8)
    # A single sample is noise. The strip is periodic in azimuth.
    ends = MARGIN[1]
    covered = np.pad(covered, ((0, 0), (ends, ends)), mode="wrap")
    covered = cv2.morphologyEx(covered, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
    covered = cv2.dilate(covered, np.ones(MARGIN, np.uint8))[:, ends:-ends]
    return replace(grid, uncovered=(1 - covered).astype(np.float32))
