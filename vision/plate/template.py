"""The appearance of the plate at rest.

In polar plate coordinates frame i is a stationary background plus a turning part,

    D_i(r, φ) = S(r, φ) + T(r, φ - θ_i).

This module has S and T and the operations on them; ``vision.plate.alignment`` estimates them
together with the angles θ_i and the view.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import quantile
from vision.phase_track import BoolArray
from vision.plate.polar import Grid, Spectra, Strips, ring_spectra, ring_strips, turns
from vision.video.reader import Luma

SMALL_STEP = 0.1  # quantile of the steps from frame to frame, because some frames are left out
RING_SPACING_PX = 1.0  #: between rings: no pixel is skipped
RINGS = (4, 32)  # at least and at most
INFORMATION = 0.97  # share of the information on the angle that the measured rings carry
OVERSAMPLED = 4  # correlations per sample of azimuth
NEAR = 1 / 12  # of a turn, around the expected angle

RESEMBLES = 0.5
"""Correlation of T with itself, turned by a ninth of a turn or more, from which its peaks are told
apart by the way of the plate. Derived: half."""
SLIPS = 0.25
"""Largest change of the rough angle's error over the advance of the plate. Derived: half of that
from which something else replaced the plate (``vision.plate.inertia``)."""

# Limits of |mean exp(ikθ)|² above which an order belongs to the background alone.
STANDING = 0.9  #: above it, order k does not show whether it turns or is stationary
STROBED = 0.15
"""The same for an order that turns by more than half a wave from frame to frame, if the mark does
not leave the frame. Tuned on ``tests.bench.clip_study --only edge_on``, seed 1001 (33.05 frames per
turn), which errs by 1.6 sds; at 0.3 by 3.9, at 0.9 by 5.2. At 0.075 chance removes one order in
eight from 28 frames."""


@dataclass(frozen=True, eq=False)
class Template:
    """The stationary and the turning part of the frames, on a grid.

    Attributes
    ----------
    grid : Grid
    background : array, shape (r, n)
        S, in luma steps.
    turning : array, shape (r, n)
        T, azimuth counted from plate angle zero; no mean along a ring.
    explained : float
        Share of the variation in time that the turning part explains, at most 1.
    varying : float
        That variation, luma steps squared times pixels, up to a factor common to all grids, without
        the frames set aside.
    """

    grid: Grid
    background: Strips
    turning: Strips
    explained: float
    varying: float


@dataclass(frozen=True, eq=False)
class RoughlyAligned:
    """Frames with rough angles.

    Attributes
    ----------
    images : sequence of arrays of uint8, shape (h, w)
    background : array of uint8, shape (h, w)
        Their median.
    angle_rad : array, shape (f,)
        Rough plate angles. They hold among neighbours only: across missing frames, two images of
        the plate would stay superposed.
    first : array of bool, shape (f,)
        Frames of the first template, to which the others are turned. If they are all the frames,
        their angles are kept until the background has been separated from the turning part.
    shows : array of bool, shape (f,)
        Frames that show their angle. Others keep the rough one; they show the background.
    parts : int
        Number of equal parts; turned by one of them the plate looks the same.
    """

    images: Sequence[Luma]
    background: Luma
    angle_rad: FloatArray
    first: BoolArray
    shows: BoolArray
    parts: int = 1


@dataclass(frozen=True, eq=False)
class Alignment:
    """A template together with its frames.

    Attributes
    ----------
    template : Template
    angle_rad : array, shape (f,)
        Plate angle in each frame.
    used : array of bool, shape (f,)
        Frames that are no outliers.
    shows : array of bool, shape (f,)
        Frames that show their angle; in the others it is extended from their neighbours.
    """

    template: Template
    angle_rad: FloatArray
    used: BoolArray
    shows: BoolArray


def standing_share(
    angle_rad: FloatArray, orders: int, parts: int = 1, *, leaves: bool = False
) -> NDArray[np.float32]:
    """Share of a turning wave of each order that looks stationary, |mean exp(ikθ)|², (orders,).

    One for orders that do not show whether they turn or are stationary. With equal parts, the
    frames show the rotation of orders that are multiples of their number; no other order turns. If
    the mark ``leaves`` the frame, only a part of the ring is visible, in which the orders are not
    orthogonal: a turning order that is taken for background biases the angle through all others.
    Then only orders that cannot be separated at all count as stationary.
    """
    share = np.abs(turns(angle_rad, orders).mean(axis=(0, 1))) ** 2
    step = quantile(np.abs(np.diff(angle_rad)), SMALL_STEP)
    order = np.arange(orders)
    strobed = (order * step > np.pi) & (parts == 1) & (not leaves)
    limit = np.where(strobed, STROBED, STANDING)
    return np.asarray(np.where((share > limit) | (order % parts != 0), 1, share))


def pattern_spectra(strips: Strips) -> Spectra:
    """Ring spectra without the mean of each ring, which carries no angle."""
    spectra = ring_spectra(strips)
    spectra[..., 0] = 0
    return spectra


def energy(strips: Strips, grid: Grid) -> NDArray[np.float32]:
    """Weighted sum of squares of each strip, shape (f,), in the square of their unit."""
    return np.asarray(np.vecdot(strips, strips) @ grid.weight())


def mean_turning(
    spectra: Spectra,
    angle_rad: FloatArray,
    used: NDArray[np.bool_],
    grid: Grid,
    standing: NDArray[np.float32],
) -> Spectra:
    """Spectrum of T, shape (r, k): the mean of the frames turned back, where they are visible.

    Parameters
    ----------
    spectra : array, shape (f, r, k)
        Spectra of the frames less the background.
    angle_rad : array, shape (f,)
    used : array of bool, shape (f,)
    grid : Grid
    standing : array, shape (k,)
        ``standing_share``: orders that look stationary belong to the background alone.
    """
    back_by = turns(angle_rad, spectra.shape[-1])
    if grid.seen.all():
        mean_by = back_by * (used / used.sum()).astype(np.float32)[:, None, None]
        turning = np.asarray((spectra * mean_by).sum(axis=0))
    else:
        back = ring_strips(spectra[used] * back_by[used], grid.azimuths)
        seen = ring_spectra(grid.seen)[None] * back_by[used]
        share = ring_strips(seen, grid.azimuths).sum(axis=0)
        mean = back.sum(axis=0) / np.maximum(share, 1.0)
        turning = pattern_spectra(mean.astype(np.float32))
    turning[:, standing > STANDING] = 0
    return turning


def turned(turning: Spectra, angle_rad: FloatArray, grid: Grid) -> Strips:
    """T(φ - θ_i) for every frame, where it is visible, shape (f, r, n)."""
    forth_by = np.conj(turns(angle_rad, turning.shape[-1]))
    strips = ring_strips(turning[None] * forth_by, grid.azimuths)
    return strips if grid.seen.all() else strips * grid.seen


def correlated_angle(
    spectra: Spectra,
    turning: Spectra,
    grid: Grid,
    expected_rad: FloatArray,
    parts: int,
    *,
    near: bool,
) -> FloatArray:
    """Angle of each frame against T, with the whole turns of the expected one, rad, (f,).

    The highest peak, or with ``near`` the one near the expected angle; for a plate of equal parts,
    the one within half a part. Of a T that resembles itself turned by a part of a turn the peak on
    the way that the plate can take from frame to frame.
    """
    cross = (spectra * (np.conj(turning) * grid.weight()[:, None])).sum(axis=1)
    n = OVERSAMPLED * grid.azimuths
    correlation = np.fft.irfft(cross, n, axis=-1)
    rows = np.arange(len(correlation))
    peak = correlation.argmax(axis=1)
    if near or parts > 1:
        middle = np.round(expected_rad * n / (2 * np.pi)).astype(np.intp)
        reach = int(n * min(NEAR, 0.5 / parts))
        around = (middle[:, None] + np.arange(-reach, reach + 1)) % n
        peak = around[rows, correlation[rows[:, None], around].argmax(axis=1)]
    elif _resembles_itself(turning, grid):
        peak = _on_the_way(correlation, np.round(expected_rad * n / (2 * np.pi)).astype(np.intp))
    before, at, after = (correlation[rows, (peak + s) % n] for s in (-1, 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = np.nan_to_num(0.5 * (before - after) / (before - 2 * at + after))
    angle = (peak + np.clip(offset, -0.5, 0.5)) * 2 * np.pi / n
    return np.asarray(expected_rad + np.angle(np.exp(1j * (angle - expected_rad))))


def _resembles_itself(turning: Spectra, grid: Grid) -> bool:
    """Whether T looks much the same when turned by a ninth of a turn or more."""
    power = (np.abs(turning) ** 2 * grid.weight()[:, None]).sum(axis=0)
    alike = np.fft.irfft(power, grid.azimuths)
    return bool(alike[grid.azimuths // 9 : grid.azimuths // 2 + 1].max() > RESEMBLES * alike[0])


def _on_the_way(correlation: FloatArray, rough: NDArray[np.intp]) -> NDArray[np.intp]:
    """The samples (f,) with the largest sum of correlations (f, n) that advance like rough ones.

    A dynamic programme over the difference from the rough samples (f,), which changes from frame to
    frame by a share of the advance at most (Viterbi, IEEE Trans. Inf. Theory 13, 1967).
    """
    f, n = correlation.shape
    slip = np.maximum(1, np.ceil(SLIPS * np.abs(np.diff(rough)))).astype(int).clip(max=n // 2 - 1)
    best = np.stack([np.roll(row, -at) for row, at in zip(correlation, rough, strict=True)])
    for i in range(1, f):
        around = np.pad(best[i - 1], slip[i - 1], mode="wrap")[None]
        best[i] += cv2.dilate(around, np.ones((1, 2 * slip[i - 1] + 1), np.uint8))[
            0, slip[i - 1] : slip[i - 1] + n]
    way = np.empty(f, np.intp)
    way[-1] = best[-1].argmax()
    for i in range(f - 1, 0, -1):
        near = (way[i] + np.arange(-slip[i - 1], slip[i - 1] + 1)) % n
        way[i - 1] = near[best[i - 1, near].argmax()]
    return np.asarray((way + rough) % n)


def informative_rings(template: Template) -> FloatArray:
    """Plate radii, about a pixel apart, that carry nearly all information on the angle, (r,)."""
    grid = template.grid
    spectrum = ring_spectra(template.turning)
    k = np.arange(spectrum.shape[-1])
    slope = np.fft.irfft(1j * k * spectrum, grid.azimuths, axis=-1).astype(np.float32)
    information = (slope**2).sum(axis=1) * grid.weight()
    spacing = RING_SPACING_PX / grid.view.radius_px
    radius = np.arange(grid.radius[0], grid.radius[-1], spacing)
    at = np.interp(radius, grid.radius, information)
    order = np.argsort(-at)
    fewest, most = RINGS
    enough = int(np.searchsorted(np.cumsum(at[order]), INFORMATION * at.sum())) + 1
    kept = np.sort(order[: max(enough, fewest)])
    if len(kept) > most:
        kept = kept[np.linspace(0, len(kept) - 1, most).astype(int)]
    return np.asarray(radius[kept])
