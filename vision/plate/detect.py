"""Where a plate may be: ellipses in the still frame, and ellipses along which a mark moves.

These are proposals. Which of them turns, and where exactly its axis is, the motion itself decides
(``vision.plate.template``).
"""

from collections.abc import Sequence
from random import Random
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import PlateView, view_of_ellipse
from vision.plate.background import spread_choice
from vision.video import Luma

LARGEST_SIDE = 400  # pixels; a proposal needs no more
LEVELS = 9  # brightness thresholds tried
SMALLEST_AREA = 0.015  # of the frame
FLATTEST = 0.2  # minor over major axis; flatter is more than 78° of tilt
OPENINGS = (0.02, 0.07)  # of the shorter side: cuts what touches the rim (tonearm, rod, hand)
FIT_TOLERANCE = 0.02  # of the mean axis, rms of the contour about the ellipse
SAME = 0.06  # proposals closer than this in centre and axes (of the axes) are one
MOST = 8
TRACK_FRAMES = 120
TRACK_TRIALS = 300
TRACK_MISSED = 1e-4  # probability at which trials end that not one of them was free of strays
TRACK_INLIERS = 0.4
TRACK_TOLERANCE = 0.03  # of the ellipse's mean axis
RIM_OVER_TRACK = 1.15  # a mark is put near the rim

Ellipse = tuple[tuple[float, float], tuple[float, float], float]  # centre, full axes, degrees


def proposals(still: Luma, images: Sequence[Luma]) -> list[PlateView]:
    """Views of possible plates, the unit circle on the rim (about), largest first."""
    factor = -(-max(still.shape) // LARGEST_SIDE)
    small = _reduced(still, factor)
    some = [
        _reduced(images[i], factor) for i in spread_choice(len(images), TRACK_FRAMES)
    ]
    found: list[Ellipse] = []
    for ellipse in (*_edges(small), *_mark_tracks(small, some)):
        if not any(_same(ellipse, other) for other in found):
            found.append(ellipse)
    found.sort(key=lambda e: -e[1][0] * e[1][1])
    return [_view(ellipse, factor) for ellipse in found[:MOST]]


def _reduced(image: Luma, factor: int) -> Luma:
    if factor == 1:
        return image
    h, w = (n // factor for n in image.shape)
    whole = image[: h * factor, : w * factor]
    return np.asarray(cv2.resize(whole, (w, h), interpolation=cv2.INTER_AREA), np.uint8)


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


def _edges(still: Luma) -> list[Ellipse]:
    """Ellipses around connected areas brighter or darker than one of several levels."""
    smooth = cv2.GaussianBlur(still, (5, 5), 0)
    low, high = np.percentile(smooth, (2, 98))
    found = []
    for level in np.linspace(low, high, LEVELS + 2)[1:-1]:
        bright = np.where(smooth > level, 255, 0).astype(np.uint8)
        for area in (bright, cv2.bitwise_not(bright)):
            for opening in OPENINGS:
                size = 2 * round(opening * min(still.shape) / 2) + 1
                kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
                opened = cv2.morphologyEx(area, cv2.MORPH_OPEN, kernel)
                contours, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
                found += [
                    fit
                    for contour in contours
                    if (fit := _ellipse_around(np.asarray(contour), still.shape)) is not None
                ]
    found.sort(key=lambda item: item[0])
    return [ellipse for _, ellipse in found]


def _ellipse_around(contour: NDArray[Any], shape: tuple[int, ...]) -> tuple[float, Ellipse] | None:
    """Relative misfit and ellipse of the part of a contour that is not the frame's border."""
    if len(contour) < 40 or cv2.contourArea(contour) < SMALLEST_AREA * shape[0] * shape[1]:
        return None
    points = cv2.convexHull(contour)[:, 0].astype(np.float64)
    # The hull keeps the ends of straight runs only; points between them keep the fit balanced.
    points = _resample(points)
    inside = (
        (points > 2).all(axis=1) & (points[:, 0] < shape[1] - 3) & (points[:, 1] < shape[0] - 3)
    )
    points = points[inside]
    if len(points) < 20:
        return None
    ellipse = _fitted(points)
    misfit = np.sqrt(np.mean(_distance(ellipse, points) ** 2))
    return (float(misfit), ellipse) if _sound(ellipse, shape) and misfit < FIT_TOLERANCE else None


def _fitted(points: NDArray[np.float64]) -> Ellipse:
    (x, y), (a, b), degrees = cv2.fitEllipseDirect(points.astype(np.float32))
    return (float(x), float(y)), (float(a), float(b)), float(degrees)


def _sound(ellipse: Ellipse, shape: tuple[int, ...]) -> bool:
    (x, y), axes, _ = ellipse
    h, w = shape[:2]
    return bool(
        np.isfinite([x, y, *axes]).all()
        and min(axes) > FLATTEST * max(axes)
        and max(axes) < 2 * max(h, w)
        and -0.2 * w < x < 1.2 * w
        and -0.2 * h < y < 1.2 * h
    )


def _resample(polygon: NDArray[np.float64], spacing: float = 3.0) -> NDArray[np.float64]:
    closed = np.vstack([polygon, polygon[:1]])
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.arange(0, along[-1], spacing)
    return np.stack([np.interp(at, along, closed[:, i]) for i in (0, 1)], axis=1)


def _distance(ellipse: Ellipse, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of points from an ellipse along the ray from its centre, in mean axes."""
    (x, y), (a, b), degrees = ellipse
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    dx, dy = points[:, 0] - x, points[:, 1] - y
    ratio = np.hypot((dx * c + dy * s) * 2 / a, (-dx * s + dy * c) * 2 / b)
    reach = np.hypot(dx, dy)
    return np.asarray(reach * np.abs(1 - 1 / np.maximum(ratio, 1e-6)) * 2 / np.sqrt(a * b))


def _mark_tracks(still: Luma, images: Sequence[Luma]) -> list[Ellipse]:
    """The ellipse along which the most conspicuous moving spot runs, grown to the rim."""
    spots = []
    for image in images:
        change = cv2.GaussianBlur(cv2.absdiff(image, still), (5, 5), 0)
        _, peak, _, (x, y) = cv2.minMaxLoc(change)
        box = change[max(y - 8, 0) : y + 9, max(x - 8, 0) : x + 9].astype(float)
        box[box < peak / 2] = 0
        rows, columns = np.indices(box.shape)
        spots.append(
            [
                max(x - 8, 0) + (box * columns).sum() / max(box.sum(), 1),
                max(y - 8, 0) + (box * rows).sum() / max(box.sum(), 1),
            ]
        )
    points = np.array(spots)
    if len(points) < 12:
        return []
    rng = Random(0)  # the same clip gives the same proposals
    best: NDArray[np.bool_] = np.zeros(len(points), bool)
    needed = float(TRACK_TRIALS)
    for trial in range(TRACK_TRIALS):
        if trial >= needed:
            break
        sample = points[rng.sample(range(len(points)), 6)]
        ellipse = _fitted(sample)
        if not _sound(ellipse, still.shape) or min(ellipse[1]) < 0.1 * min(still.shape):
            continue
        near = _distance(ellipse, points) < TRACK_TOLERANCE
        if near.sum() > best.sum():
            best = near
            needed = np.log(TRACK_MISSED) / np.log1p(-min(best.mean() ** len(sample), 0.99))
    if best.sum() < max(10, TRACK_INLIERS * len(points)):
        return []
    centre, axes, degrees = _fitted(points[best])
    return [(centre, (axes[0] * RIM_OVER_TRACK, axes[1] * RIM_OVER_TRACK), degrees)]
