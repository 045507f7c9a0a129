"""A second rotation, beside a plate or about its spindle: a label that slips.

The part that turns with the plate, and the background, are removed from every order k of the rings,

    F_k(r, t) = S_k(r) + T_k(r) exp(-ikθ_t) + residual,

and the residual is searched for a rate like the frames themselves (``vision.plate.rotation``).
Errors of the view leave single orders, each at a different rate.
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


def left_by(spectra: Orders, angle_rad: FloatArray) -> Orders:
    """Ring spectra, (orders, r, f), without the background and the part at the angles, (f,)."""
    rest = np.empty_like(spectra)
    for k, of_order in enumerate(spectra, start=1):
        turns = np.exp(-1j * k * angle_rad)
        base = np.linalg.qr(np.stack([np.ones_like(turns), turns], axis=1))[0]
        rest[k - 1] = of_order - (of_order @ base.conj()) @ base.T
    return rest


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
