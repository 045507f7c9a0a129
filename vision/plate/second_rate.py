"""A second rotation, beside a plate or about its spindle: a label that slips.

Light, shade and the view stand; what they do to the turning pattern T is a product of both,

    F_k(r, t) = Σ_m S_{k-m}(r) T_m(r) exp(-imθ_t) + residual,

that is, in an order k of the rings waves of every whole multiple of the plate's rate: a sheen on
the grooves alone leaves order 3 at twice the plate's angle, as if something turned at two thirds of
its rate. All of them are removed, and the residual is searched for a rate like the frames
themselves (``vision.plate.rotation``). What turns together is counted as a share of all that T and
the background leave, products of both included.
"""


import numpy as np

from vision.geometry import FloatArray
from vision.numbers import FASTEST_USUAL
from vision.plate.low_orders import Orders
from vision.plate.rotation import CoarseRotation

# Limits for a rotation beside a plate, or in its residual.
MOSTLY = 0.5
"""Share of the variation there that turns together. Derived: half. It is at most 0.45 in the
residual of 70 plates, and 0.77 and more in those with a second rotation about the spindle."""
APART_TURNS = 0.25
"""Difference between the two in the learning frames. Derived: from a quarter of a turn on the waves
of order four are distinct."""


def left_by(spectra: Orders, angle_rad: FloatArray) -> tuple[Orders, float]:
    """Ring spectra, (orders, r, f), without all that repeats with the angles, (f,).

    And their share of the variation that the background and the plate alone leave.
    """
    waves = np.exp(-1j * np.outer(angle_rad, np.arange(len(spectra) + 1)))
    rest = spectra - _projected(spectra, waves)
    beside = sum(float((np.abs(of_order - _projected(of_order, waves[:, [0, k]])) ** 2).sum())
                 for k, of_order in enumerate(spectra, start=1))
    return np.asarray(rest), float((np.abs(rest) ** 2).sum()) / max(beside, 1e-9)


def _projected(spectra: Orders, waves: Orders) -> Orders:
    """The part of ring spectra, (..., f), in the span of waves, (f, k)."""
    base = np.linalg.qr(waves)[0].astype(spectra.dtype)
    return np.asarray((spectra @ base.conj()) @ base.T)


def turns_itself(
    seen: CoarseRotation, lasts_s: float, plate_rad: FloatArray | None = None
) -> bool:
    """Whether a motion over some seconds turns one way, unlike the angles of a plate, (f,)."""
    turned = seen.angle_rad[-1]
    one_way = (np.diff(seen.angle_rad) * turned > 0).all()  # a hand turns back
    if seen.coherence < MOSTLY or abs(turned) > FASTEST_USUAL * lasts_s or not one_way:
        return False
    if plate_rad is None:
        return True
    apart = seen.angle_rad - plate_rad
    return bool(abs(apart[-1] - apart[0]) > 2 * np.pi * APART_TURNS)
