"""What turns at a rate of its own, beside a plate or about its spindle: a label that slips.

What turns with the plate, and what stands, is taken off every order k of the rings,

    F_k(r, t) = S_k(r) + T_k(r) exp(-ikθ_t) + left,

and what is left is searched for a rate as the frames themselves are (``vision.plate.rotation``).
Errors of the view leave single orders, each at a rate of its own.
"""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import FASTEST_USUAL
from vision.plate.low_orders import Orders
from vision.plate.rotation import CoarseRotation


@dataclass(frozen=True)
class SecondRateThresholds:
    """When something turns beside a plate, or in what it leaves.

    Attributes
    ----------
    mostly : float
        Of what varies there, that turns together. Derived: half. Of what 70 plates leave at most
        0.45 does, of those with a second thing about the spindle 0.77 and more.
    apart_turns : float
        Between the two in the frames that are learned from. Derived: from a quarter of a turn on
        the waves of order four do not look alike.
    """

    mostly: float = 0.5
    apart_turns: float = 0.25


THRESHOLDS = SecondRateThresholds()


def left_by(spectra: Orders, angle_rad: FloatArray) -> Orders:
    """Spectra of rings, (orders, r, f), without what stands and what turns by the angles, (f,)."""
    rest = np.empty_like(spectra)
    for k, of_order in enumerate(spectra, start=1):
        turns = np.exp(-1j * k * angle_rad)
        base = np.linalg.qr(np.stack([np.ones_like(turns), turns], axis=1))[0]
        rest[k - 1] = of_order - (of_order @ base.conj()) @ base.T
    return rest


def turns_itself(
    seen: CoarseRotation, lasts_s: float, plate_rad: FloatArray | None = None
) -> bool:
    """Whether what is seen in some seconds turns, and not by the angles of a plate there, (f,)."""
    if seen.coherence < THRESHOLDS.mostly or abs(seen.angle_rad[-1]) > FASTEST_USUAL * lasts_s:
        return False
    if plate_rad is None:
        return True
    apart = seen.angle_rad - plate_rad
    return bool(abs(apart[-1] - apart[0]) > 2 * np.pi * THRESHOLDS.apart_turns)
