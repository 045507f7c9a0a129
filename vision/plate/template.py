"""The plate as it would look standing still.

In polar plate coordinates frame i is what stands still plus what turns,

    D_i(r, φ) = S(r, φ) + T(r, φ - θ_i).

S, T, the angles θ_i and the view (``vision.plate.view_refinement``) are estimated in turn.

Where frames come at a nearly whole number per turn (27 at 15 fps and 33 1/3 rpm), waves of that
many periods per turn stand nearly still: they fit S as well as T. Left to the way the iteration
begins, some of the plate's own texture would be taken off as standing still, and the slow drift of
the plate through its places would look larger than it is. So such orders are solved for with what S
and T take from each other in mind, or belong to S alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import VIEW_PARAMETERS, FloatArray
from vision.plate.polar import Grid, Spectra, Strips, ring_spectra
from vision.plate.view_refinement import turns, view_change
from vision.video import Luma

OUTLIER = 3.0  # times the median misfit: a hand, a flash
NEIGHBOURHOOD = 3  # rings and azimuths
MARGIN = (3, 5)  # rings and azimuths left out about a covered place, whose edges tell too little
TELLING = 0.08  # standard deviation of the share seen, above which nothing can be said
PASSING = 0.1  # of the ring's mean expected energy: a place that less passes says nothing
HIDDEN = 1.5  # times the turning energy: the misfit of a frame whose mark is covered is less
SHOWN = 0.5  # of the expected change, below which a place counts as covered
TOLD_APART = 0.1  # of the misfit's energy, that still moves from what turns to what stands
STANDING = 0.9  # |mean exp(ikθ)|² above which order k does not show whether it turns or stands
NEAR_ENOUGH = 0.8  # of the highest peak: then the peak next to the expected angle is taken
LARGEST_STEP = 0.05  # of the radius, per iteration of the view


@dataclass(frozen=True, eq=False)
class Template:
    """What stands still and what turns, on a grid.

    Attributes
    ----------
    grid : Grid
    still : array, shape (r, n)
        S, in luma steps.
    turning : array, shape (r, n)
        T, azimuth counted from plate angle zero; no mean along a ring.
    explained : float
        Share of the variation in time that the turning explains, 0 to 1.
    """

    grid: Grid
    still: Strips
    turning: Strips
    explained: float


@dataclass(frozen=True, eq=False)
class Alignment:
    """A template together with the angles of the frames it was made from."""

    template: Template
    angle_rad: FloatArray
    used: NDArray[np.bool_]


def align(
    images: Sequence[Luma],
    still: Luma,
    angle_rad: FloatArray,
    grid: Grid,
    *,
    first: NDArray[np.bool_],
    iterations: int,
    smallest_step: float,
    find_covered: bool,
    find_readout: bool,
    on_step: Callable[[], None],
) -> Alignment:
    """Estimate S, T, the angles and the view in turn, starting from rough angles.

    The ``first`` frames make the first template, to which the others are turned: rough angles
    hold among neighbours only, and where frames are missing between them two images of the plate
    would lie over each other for good. Where they are all the frames, their angles hold until
    what stands still has been told from what turns.

    Ends after the iterations, or where the view would change by less than ``smallest_step`` of
    the radius. The lag of the read-out looks much like an axis that is off, so it is to be found
    only once the axis is nearly right. ``on_step`` is called before each iteration.
    """
    angle = angle_rad.copy()
    still_strip = grid.strip(still).astype(np.float32)
    used, known = first, bool(first.all())
    difference = grid.beyond(still_strip, images)
    beyond_median = np.zeros_like(still_strip)
    standing = np.zeros(grid.azimuths // 2 + 1, np.float32)
    best, best_view, view, settled = np.inf, grid.view, grid.view, False
    for iteration in range(iterations):
        on_step()
        spectra = _spectra(difference)
        turning = _mean_turning(spectra, angle, used, grid, standing)
        if iteration > 0 or not known:
            angle = _correlate(spectra, turning, grid, angle, surely=known)
        if iteration == 0:
            used = np.ones(len(images), bool)
            standing = _standing(angle, len(standing))
        turning = _mean_turning(spectra, angle, used, grid, standing)
        moved = _turned(turning, angle, grid)
        misfit = difference - moved
        # What the model leaves, averaged over all angles, stood still after all.
        stood = misfit[used].mean(axis=0)
        misfit -= stood
        correction = _still_change(stood, standing, grid.seen)
        still_strip = still_strip + correction
        beyond_median = beyond_median + correction
        difference -= correction
        energy = _energy(misfit, grid)
        used = energy <= OUTLIER * np.median(energy) * _more_to_see(moved, grid)
        if iteration == iterations - 1 or not turning.any():
            break
        typical = float(np.median(energy))
        if typical > best:
            # What does not turn with the plate (a hand) pulls the view away; go back and stay.
            view, settled = best_view, True
        elif not settled:
            best, best_view = typical, grid.view
            free = VIEW_PARAMETERS if find_readout else VIEW_PARAMETERS - 1
            change = view_change(misfit[used], angle[used], turning, grid, free)
            told_apart = float(_energy(stood[None], grid)[0]) < TOLD_APART * typical
            if told_apart and float(np.abs(change).max()) < smallest_step:
                break
            limit = min(1.0, LARGEST_STEP / max(float(np.abs(change[:4]).max()), 1e-12))
            view = grid.view.adjusted(limit * change)
        if view is not grid.view:
            grid = grid.moved(view, images[0].shape)
            still_strip = grid.strip(still).astype(np.float32) + beyond_median
            difference = grid.beyond(still_strip, images)
    if find_covered:
        # A mark that is hidden is missing once; a hand adds more than that.
        fair = energy <= HIDDEN * _energy(moved, grid)
        if fair.any():
            grid = _without_covered(grid, difference[fair], moved[fair])
    varying = (difference[used] - difference[used].mean(axis=0)) * grid.seen
    total = float(_energy(varying, grid).sum())
    left = float(_energy(misfit[used] * grid.seen, grid).sum())
    template = Template(
        grid,
        still_strip,
        np.fft.irfft(turning, grid.azimuths, axis=-1).astype(np.float32),
        1 - left / max(total, 1e-9),
    )
    return Alignment(template, angle, used)


def _standing(angle_rad: FloatArray, orders: int) -> NDArray[np.float32]:
    """How far a turning wave of each order looks like a standing one, |mean exp(ikθ)|², 0 to 1."""
    return np.asarray(np.abs(turns(angle_rad, orders).mean(axis=(0, 1))) ** 2)


def _still_change(misfit: Strips, standing: NDArray[np.float32], seen: Strips) -> Strips:
    """Change of S from the mean misfit, for which T has made room.

    Where S is wrong by δ, T has taken its turning share mean exp(ikθ) of it, and the mean misfit
    shows (1 - |mean exp(ikθ)|²) δ only. Where part of the plate is not seen it shows δ more or
    less, up to the whole, and a step that is twice too long would go to and fro for good.
    """
    told = np.where(standing > STANDING, 1, 1 - standing)
    if not seen.all():
        told = np.maximum(told, 0.5)
    spectrum = ring_spectra(misfit) / told
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
    telling = passed * TELLING**2 > noise
    # Of a plate that keeps step with the frames hardly anything passes between its places.
    telling &= passed > PASSING * passed.mean(axis=1, keepdims=True)
    covered = (telling & (shown < SHOWN * passed)).astype(np.uint8)
    # A single sample is noise. The strip closes on itself in azimuth.
    ends = MARGIN[1]
    covered = np.pad(covered, ((0, 0), (ends, ends)), mode="wrap")
    covered = cv2.morphologyEx(covered, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
    covered = cv2.dilate(covered, np.ones(MARGIN, np.uint8))[:, ends:-ends]
    return replace(grid, uncovered=(1 - covered).astype(np.float32))


def _spectra(strips: Strips) -> Spectra:
    spectra = ring_spectra(strips)
    spectra[..., 0] = 0  # the mean of a ring has no angle
    return spectra


def _energy(strips: Strips, grid: Grid) -> NDArray[np.float32]:
    """Weighted sum of squares of each strip, shape (f,)."""
    return np.asarray(np.einsum("frn,frn->fr", strips, strips) @ grid.weight())


def _more_to_see(moved: Strips, grid: Grid) -> NDArray[np.float32]:
    """How much more of what turns is in each frame than in most of them, at least 1.

    A mark that is seen on part of its way misfits there as much as any, and nowhere else.
    """
    turning = _energy(moved, grid)
    return np.asarray(np.maximum(turning / max(float(np.median(turning)), 1e-9), 1.0))


def _mean_turning(
    spectra: Spectra,
    angle_rad: FloatArray,
    used: NDArray[np.bool_],
    grid: Grid,
    standing: NDArray[np.float32],
) -> Spectra:
    """Spectrum of T, shape (r, k): the mean of the frames turned back, where they were seen."""
    back_by = turns(angle_rad, spectra.shape[-1])
    if grid.seen.all():
        turned_back = np.einsum("frk,fk->rk", spectra, back_by[:, 0] * used[:, None])
        turning = np.asarray(turned_back / used.sum(), np.complex64)
    else:
        back = np.fft.irfft(spectra[used] * back_by[used], grid.azimuths, axis=-1)
        seen = ring_spectra(grid.seen)[None] * back_by[used]
        share = np.fft.irfft(seen, grid.azimuths, axis=-1).sum(axis=0)
        mean = back.sum(axis=0) / np.maximum(share, 1.0)
        turning = _spectra(mean.astype(np.float32))
    turning[:, standing > STANDING] = 0
    return turning


def _turned(turning: Spectra, angle_rad: FloatArray, grid: Grid) -> Strips:
    """T(φ - θ_i) for every frame, where it can be seen."""
    forth_by = np.conj(turns(angle_rad, turning.shape[-1]))
    turned = np.fft.irfft(turning[None] * forth_by, grid.azimuths, axis=-1)
    turned *= grid.seen
    return np.asarray(turned, np.float32)


def _correlate(
    spectra: Spectra, turning: Spectra, grid: Grid, expected_rad: FloatArray, *, surely: bool
) -> FloatArray:
    """Angle of each frame against T, the peak near the expected angle preferred, or taken."""
    cross = np.einsum("frk,rk->fk", spectra, np.conj(turning) * grid.weight()[:, None])
    n = 4 * grid.azimuths
    correlation = np.fft.irfft(cross, n, axis=-1)
    rows = np.arange(len(correlation))
    highest = correlation.argmax(axis=1)
    middle = np.round(expected_rad * n / (2 * np.pi)).astype(np.intp)
    near = (middle[:, None] + np.arange(-(n // 12), n // 12 + 1)) % n  # within π/6
    nearest = near[rows, correlation[rows[:, None], near].argmax(axis=1)]
    enough = correlation[rows, nearest] > NEAR_ENOUGH * correlation[rows, highest]
    peak = np.where(enough | surely, nearest, highest)
    before, at, after = (correlation[rows, (peak + s) % n] for s in (-1, 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = np.nan_to_num(0.5 * (before - after) / (before - 2 * at + after))
    angle = (peak + np.clip(offset, -0.5, 0.5)) * 2 * np.pi / n
    # Keep the whole turns of the expected angle.
    return np.asarray(expected_rad + np.angle(np.exp(1j * (angle - expected_rad))))
