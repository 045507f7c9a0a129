"""Drawings of discs and of a table, in linear light from 0 to 1."""

import cv2
import numpy as np
from numpy.typing import NDArray

Drawing = NDArray[np.float32]

MARGIN = 1.04  #: half the side of a disc's drawing, in radii


def disc(kind: str, side: int, rng: np.random.Generator, off_centre: float = 0.0) -> Drawing:
    """A disc, shape (side, side, 3): light of its surface, whether it is there, its grooves.

    Parameters
    ----------
    kind : str
        mark, label, print, paper, ribs, strobe, fold2, fold3, fold4, plain.
    side : int
        Pixels.
    off_centre : float
        Of the record on the platter, in radii.
    """
    scale = side / (2 * MARGIN)
    y, x = (np.mgrid[:side, :side] - (side - 1) / 2) / scale
    radius, azimuth = np.hypot(x, y), np.arctan2(-y, x)
    own_x = x - off_centre
    own = np.hypot(own_x, y)
    inside = np.clip((1 - radius) * scale + 0.5, 0, 1)
    surface = np.full_like(x, rng.uniform(0.02, 0.06))
    speckle = cv2.GaussianBlur(rng.standard_normal((side, side)), (0, 0), 2.5)
    surface += 0.004 * speckle / speckle.std()
    grooves = 1 + 0.5 * np.sin(own * rng.uniform(90, 140)) * np.sin(own * 17.0)
    painted = np.ascontiguousarray(surface, np.float32)
    if kind in ("label", "mark", "print"):
        around = np.arctan2(-y, own_x)
        tone = rng.uniform(0.15, 0.45)
        label = np.full_like(x, tone) + 0.25 * (np.abs(around - rng.uniform(-2, 2)) < 0.5)
        if kind == "label":
            label += 0.2 * tone * np.sign(np.sin(40 * y + 3)) * (np.abs(own_x) < 0.18)
        edge = np.clip((0.34 - own) * scale + 0.5, 0, 1)
        painted[:] = painted * (1 - edge) + label * edge
    if kind == "mark":
        _stick(painted, scale, 0.82, rng.uniform(0, 6.28), 0.16, rng.uniform(0.07, 0.12), 0.8)
    if kind == "print":
        for _ in range(7):
            _stick(painted, scale, rng.uniform(0.4, 0.9), rng.uniform(0, 6.28),
                   rng.uniform(0.05, 0.3), rng.uniform(0.03, 0.1), rng.uniform(0.1, 0.5))
    if kind == "paper":
        _stick(painted, scale, 0.8, rng.uniform(0, 6.28), 0.22, 0.2, 0.75)
    if kind == "ribs":
        count = int(rng.integers(18, 40))
        painted[:] += 0.08 * (np.sin(count * azimuth) > 0.3) * (radius > 0.45) * (radius < 0.93)
    if kind == "strobe":
        count = int(rng.choice([72, 90, 120]))
        painted[:] += 0.35 * (np.sin(count * azimuth) > 0) * (radius > 0.86) * (radius < 0.96)
    if kind.startswith("fold"):
        fold = int(kind[4:])
        for i in range(fold):
            at = 2 * np.pi * i / fold
            _stick(painted, scale, 0.62, at + 0.4, 0.35, 0.12, 0.6)
            _stick(painted, scale, 0.3, at, 0.12, 0.2, 0.4)
    painted = cv2.GaussianBlur(painted, (0, 0), 0.7)
    return np.dstack([painted * inside, inside, grooves * inside]).astype(np.float32)


def _stick(
    canvas: Drawing, scale: float, radius: float, azimuth: float, length: float, width: float,
    light: float,
) -> None:
    """A rectangle of tape, along the radius."""
    middle = (canvas.shape[0] - 1) / 2
    x, y = middle + scale * radius * np.cos(azimuth), middle - scale * radius * np.sin(azimuth)
    corners = cv2.boxPoints(((x, y), (scale * length, scale * width), -np.degrees(azimuth)))
    fixed = np.round(np.asarray(corners) * 16).astype(np.int32)
    cv2.fillPoly(canvas, [fixed], float(light), cv2.LINE_8, 4)


def streak(side: int, azimuth: float, width: float, light: float) -> Drawing:
    """What the grooves mirror of a lamp: a bow tie that stays in place, shape (side, side)."""
    scale = side / (2 * MARGIN)
    y, x = (np.mgrid[:side, :side] - (side - 1) / 2) / scale
    away = np.angle(np.exp(2j * (np.arctan2(-y, x) - azimuth))) / 2
    radius = np.hypot(x, y)
    return (light * np.exp(-((away / width) ** 2) / 2) * (radius > 0.36)).astype(np.float32)


def table(side: int, rng: np.random.Generator, *, bare: bool = False) -> Drawing:
    """A table top with things on it, shape (side, side); bare: an even one."""
    tone = rng.uniform(0.08, 0.3)
    if bare:
        return np.full((side, side), tone, np.float32)
    grain = cv2.resize(rng.standard_normal((side // 4, side // 24)), (side, side),
                       interpolation=cv2.INTER_CUBIC)
    top = (tone * (1 + 0.15 * grain)).astype(np.float32)
    for _ in range(26):
        middle = rng.uniform(0, side, 2)
        size = rng.uniform(0.02, 0.12, 2) * side
        corners = cv2.boxPoints((tuple(middle), tuple(size), float(rng.uniform(0, 90))))
        cv2.fillPoly(top, [np.round(corners).astype(np.int32)], float(rng.uniform(0.02, 0.6)))
    return np.asarray(cv2.GaussianBlur(np.clip(top, 0.01, 0.9), (0, 0), 1.2), np.float32)
