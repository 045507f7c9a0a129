"""Possible positions of a plate: ellipses in the background, and ellipses that a mark follows.

A plate that is small, as dark as its surroundings, or partly hidden may have no outline in the
background.

These are proposals. The motion itself decides which of them turns, and where exactly its axis is
(``vision.plate.template``).
"""

from collections.abc import Sequence
from random import Random
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import PlateView, view_of_ellipse
from vision.numbers import quantile
from vision.plate.background import spread_choice
from vision.video.reader import Luma
from vision.video.reduction import reduced

LARGEST_SIDE = 400  # pixels; a proposal needs no more
MOST = 8  #: outlines that are tried; a limit of time
LEVELS = 9  # brightness thresholds tried
FEWEST_POINTS = 20  # of a contour, to determine an ellipse
BORDER = 2  # pixels of the reduced frame; a contour this near is that of the frame
SPOT_REACH = 8  # pixels around the most changed one
MOVING_FRAMES = 120  #: frames in which motion is searched; a limit of time
FEWEST_SPOTS = 12  # two per parameter of an ellipse and spindle
SAMPLE = 6  # spots; five make an ellipse
TRACK_TRIALS = 300  #: random samples; a limit of time
MISSED = 1e-3  #: probability that no sample lies entirely on the best track; numerical

Ellipse = tuple[tuple[float, float], tuple[float, float], float]  # centre, full axes, degrees


# Limits for the proposed ellipses. All tuned on tests.bench.vision_scenes.
SMALLEST_AREA = 0.004
"""Least area of an ellipse over that of the frame: a plate of 50 pixels in a frame of 640. Tuned on
tests.bench.clip_study small."""
OPENING = 0.02
"""Size of the opening over the shorter side of the frame: cuts off tonearm and rod at the rim."""
MISFIT = 0.02  #: largest rms distance of a contour from its ellipse, over the mean axis
SAME = 0.06  #: difference in centre and axes, over the axes, below which two ellipses are the same
TRACK_MISFIT = 0.03  #: largest distance of a spot from its track, over the mean axis
RIM_OVER_TRACK = 1.15  #: axes of the rim over those of the track: a mark is placed near the rim


def proposals(background: Luma, images: Sequence[Luma]) -> list[PlateView]:
    """Views of possible plates, the unit circle approximately on the rim, largest first.

    Parameters
    ----------
    background : array of uint8, shape (h, w)
    images : sequence of arrays of uint8, shape (h, w)
    """
    factor = -(-max(background.shape) // LARGEST_SIDE)
    small = reduced(background, factor)
    chosen = [reduced(images[i], factor) for i in spread_choice(len(images), MOVING_FRAMES)]
    return _views([*_edges(small), *_mark_tracks(small, chosen)], factor)


def _views(ellipses: Sequence[Ellipse], factor: int) -> list[PlateView]:
    """Views of the distinct ellipses, the first of similar ones, the largest first."""
    distinct: list[Ellipse] = []
    for ellipse in ellipses:
        if not any(_same(ellipse, other) for other in distinct):
            distinct.append(ellipse)
    distinct.sort(key=lambda e: -e[1][0] * e[1][1])
    return [_view(ellipse, factor) for ellipse in distinct[:MOST]]


def _view(ellipse: Ellipse, factor: int) -> PlateView:
    """View of an ellipse in a frame that was reduced by a factor."""
    (x, y), (a, b), degrees = ellipse
    middle = (factor - 1) / 2
    return view_of_ellipse(
        (factor * x + middle, factor * y + middle),
        (factor * a / 2, factor * b / 2),
        np.radians(degrees),
    )


def _same(one: Ellipse, other: Ellipse) -> bool:
    size = sum(one[1]) / 2
    centre = np.hypot(one[0][0] - other[0][0], one[0][1] - other[0][1])
    axes = np.abs(np.sort(one[1]) - np.sort(other[1])).max()
    return bool(centre < SAME * size / 2 and axes < SAME * size)


def _edges(background: Luma) -> list[Ellipse]:
    """Ellipses around connected areas brighter or darker than one of several levels."""
    smooth = cv2.GaussianBlur(background, (5, 5), 0)
    # The darkest and the brightest part of the picture may be a plate of the smallest area.
    low, high = (quantile(smooth, share) for share in (SMALLEST_AREA / 2, 1 - SMALLEST_AREA / 2))
    size = 2 * round(OPENING * min(background.shape) / 2) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    fits = []
    for level in np.linspace(low, high, LEVELS + 2)[1:-1]:
        bright = np.where(smooth > level, 255, 0).astype(np.uint8)
        for area in (bright, cv2.bitwise_not(bright)):
            opened = cv2.morphologyEx(area, cv2.MORPH_OPEN, kernel)
            contours, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            fits += [
                fit
                for contour in contours
                if (fit := _ellipse_around(np.asarray(contour), background.shape)) is not None
            ]
    fits.sort(key=lambda item: item[0])
    return [ellipse for _, ellipse in fits]


def _ellipse_around(contour: NDArray[Any], shape: tuple[int, int]) -> tuple[float, Ellipse] | None:
    """Relative misfit and ellipse of the part of a contour that is not the frame's border."""
    h, w = shape
    if cv2.contourArea(contour) < SMALLEST_AREA * h * w:
        return None
    points = _resampled(cv2.convexHull(contour)[:, 0].astype(np.float64))
    inside = (points > BORDER) & (points < np.array([w, h]) - 1 - BORDER)
    points = points[inside.all(axis=1)]
    if len(points) < FEWEST_POINTS:
        return None
    ellipse = _fitted(points)
    misfit = float(np.sqrt(np.mean(_distance(ellipse, points) ** 2)))
    if misfit > MISFIT or not _sound(ellipse, shape):
        return None
    return misfit, ellipse


def _fitted(points: NDArray[np.float64]) -> Ellipse:
    (x, y), (a, b), degrees = cv2.fitEllipseDirect(points.astype(np.float32))
    return (float(x), float(y)), (float(a), float(b)), float(degrees)


def _sound(ellipse: Ellipse, shape: tuple[int, ...]) -> bool:
    (x, y), axes, _ = ellipse
    h, w = shape[:2]
    return bool(
        np.isfinite([x, y, *axes]).all()
        and np.pi / 4 * axes[0] * axes[1] > SMALLEST_AREA * w * h
        and 0 < x < w
        and 0 < y < h
    )


def _resampled(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points a pixel apart: the hull keeps only the ends of straight runs, which bias a fit."""
    closed = np.vstack([polygon, polygon[:1]])
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.arange(0, along[-1])
    return np.stack([np.interp(at, along, closed[:, i]) for i in (0, 1)], axis=1)


def _distance(ellipse: Ellipse, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of points from an ellipse along the ray from its centre, in mean axes."""
    (x, y), (a, b), degrees = ellipse
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    dx, dy = points[:, 0] - x, points[:, 1] - y
    ratio = np.hypot((dx * c + dy * s) * 2 / a, (-dx * s + dy * c) * 2 / b)
    reach = np.hypot(dx, dy)
    return np.asarray(reach * np.abs(1 - 1 / np.maximum(ratio, 1e-6)) * 2 / np.sqrt(a * b))


def _mark_tracks(background: Luma, images: Sequence[Luma]) -> list[Ellipse]:
    """The ellipse that the most conspicuous moving spot follows, enlarged to the rim."""
    spots = []
    for image in images:
        change = cv2.GaussianBlur(cv2.absdiff(image, background), (5, 5), 0)
        _, peak, _, (x, y) = cv2.minMaxLoc(change)
        x0, y0 = max(x - SPOT_REACH, 0), max(y - SPOT_REACH, 0)
        box = change[y0 : y + SPOT_REACH + 1, x0 : x + SPOT_REACH + 1].astype(float)
        box[box < peak / 2] = 0
        rows, columns = np.indices(box.shape)
        total = max(box.sum(), 1)
        spots.append([x0 + (box * columns).sum() / total, y0 + (box * rows).sum() / total])
    points = np.array(spots)
    if len(points) < FEWEST_SPOTS:
        return []
    rng = Random(0)  # the same clip gives the same proposals
    best: NDArray[np.bool_] = np.zeros(len(points), bool)
    for trial in range(TRACK_TRIALS):
        if (1 - best.mean() ** SAMPLE) ** trial < MISSED:
            break
        ellipse = _fitted(points[rng.sample(range(len(points)), SAMPLE)])
        if not _sound(ellipse, background.shape):
            continue
        near = _distance(ellipse, points) < TRACK_MISFIT
        while near.sum() >= max(best.sum() + 1, FEWEST_SPOTS):
            # The ellipse through all spots on a track includes more spots than that of a sample.
            best = near
            near = _distance(_fitted(points[best]), points) < TRACK_MISFIT
    if not best.any():
        return []
    centre, (a, b), degrees = _fitted(points[best])
    return [(centre, (a * RIM_OVER_TRACK, b * RIM_OVER_TRACK), degrees)]
