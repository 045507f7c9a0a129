"""The mark on the plate, and its symmetry."""

from dataclasses import dataclass

import cv2
import numpy as np

from vision.geometry import FloatArray
from vision.plate.polar import ring_spectra, ring_strips
from vision.plate.template import Alignment, Template, energy

APART = 0.5  # correlation below which a mark does not overlap itself
MOST_FOLD = 12  # largest symmetry of a plate with a mark
NARROWEST = 3  # samples of azimuth, width of a mark


# Limits for a mark. Tuned on tests.bench.vision_scenes.
EDGE = 0.5  #: share of the highest contrast from which a place belongs to the mark
WIDEST_RAD = 0.7  #: largest width of a mark, rad
ALIKE = 0.9  #: least correlation of a symmetric template with itself turned by a part of a turn
TURNING = 0.5
"""Share of what the equal parts lack that turns with the plate, from which it tells them apart.
Derived: half. Fans of equal blades show 0.01 to 0.33, a label 0.73 and more."""


@dataclass(frozen=True)
class PlateMark:
    """A compact spot on the plate: the azimuth of its centroid at plate angle zero, its radius."""

    azimuth_rad: float
    radius: float


def find_mark(template: Template) -> PlateMark | None:
    """The compact spot that carries most of the turning contrast, or None."""
    turning, radius = template.turning, template.grid.radius
    n = template.grid.azimuths
    best: tuple[float, PlateMark] | None = None
    for sign in (1, -1):
        contrast = np.maximum(cv2.blur(sign * np.hstack([turning, turning]), (3, 3)), 0)
        spots = (contrast > EDGE * contrast.max()).astype(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(spots)
        for i in range(1, count):
            first, top, width, height, _ = stats[i]
            width_rad = width * 2 * np.pi / n
            in_the_middle = n // 4 <= first + width / 2 < n // 4 + n
            if not in_the_middle or width < NARROWEST or width_rad > WIDEST_RAD:
                continue
            inside = np.where(labels == i, contrast, 0)[top : top + height, first : first + width]
            strength = float((inside**2 * radius[top : top + height, None]).sum())
            if best is not None and strength <= best[0]:
                continue
            columns = (inside.sum(axis=0) * np.arange(width)).sum() / inside.sum()
            azimuth = (first + columns) * 2 * np.pi / n
            ring = (inside.sum(axis=1) * radius[top : top + height]).sum() / inside.sum()
            best = (strength, PlateMark(float(np.angle(np.exp(1j * azimuth))), float(ring)))
    return None if best is None else best[1]


def symmetry(template: Template, coarse: Alignment) -> int:
    """Number of times per turn that the plate looks the same.

    A label, which ``coarse`` shows, may tell the equal marks of a template apart.
    """
    alike = _likeness(template)
    half = len(alike) // 2 + 1
    beside = int(np.argmax(alike < APART))  # at smaller turns a mark overlaps itself
    peak = beside + int(np.argmax(alike[beside:half] > ALIKE))
    if beside == 0 or alike[peak] <= ALIKE:
        return 1
    while peak < half and alike[peak + 1] > alike[peak]:
        peak += 1
    parts = round(len(alike) / peak)
    return 1 if _turning_besides(coarse, parts) > TURNING else parts


def _turning_besides(coarse: Alignment, parts: int) -> float:
    """Share of the variation in orders that equal parts lack that turns, in all frames."""
    template = coarse.template
    grid, spectrum = template.grid, ring_spectra(template.turning)
    spectrum[:, ::parts] = 0
    besides = ring_strips(spectrum, grid.azimuths) * grid.seen
    turns = float(energy(besides[None], grid)[0]) * grid.view.radius_px**2 / grid.azimuths
    rest = (1 - 1 / parts) * (1 - template.explained) * template.varying
    return turns / max(turns + rest, 1e-9) * float(coarse.used.mean())


def _likeness(template: Template) -> FloatArray:
    """Correlation of the template with itself turned by 0, 1, 2, … samples, shape (n,)."""
    power = np.abs(ring_spectra(template.turning)) ** 2
    power = (power * template.grid.weight()[:, None]).sum(axis=0)
    correlation = np.fft.irfft(power, template.grid.azimuths)
    return np.asarray(correlation / max(float(correlation[0]), 1e-9))
