"""How many times per turn a plate looks the same."""

import numpy as np

from vision.geometry import FloatArray
from vision.plate.polar import ring_spectra
from vision.plate.template import Template

ALIKE = 0.9  # correlation of the template with itself turned by a part of a turn
APART = 0.5  # the same, where a mark does not overlap itself any more
MOST_FOLD = 12


def symmetry(template: Template) -> int:
    """How many times per turn the plate looks the same."""
    alike = _likeness(template)
    for fold in range(MOST_FOLD, 1, -1):
        at = round(template.grid.azimuths / fold)
        if alike[at - 1 : at + 2].max() > ALIKE:
            return fold
    return 1


def repeats_itself(template: Template) -> bool:
    """Whether the plate looks the same again anywhere around it."""
    alike = _likeness(template)
    beside = int(np.argmax(alike < APART))
    return bool(alike[beside : len(alike) - beside].max() > ALIKE)


def _likeness(template: Template) -> FloatArray:
    """Correlation of the template with itself turned by 0, 1, 2, … samples, shape (n,)."""
    power = np.abs(ring_spectra(template.turning)) ** 2
    power = (power * template.grid.weight()[:, None]).sum(axis=0)
    correlation = np.fft.irfft(power, template.grid.azimuths)
    return np.asarray(correlation / max(float(correlation[0]), 1e-9))
