"""A camera that rolls while it films: its own rate is part of the plate's.

What stands around the plate shows it in some frames (``vision.tracking.roll_gauge``).
Codecs repeat a picture that hardly moves, and show a slow roll late and too small. So it is not
subtracted: all of it is part of the sd of the rate.
"""

from dataclasses import dataclass

import numpy as np

from vision.phase_track import PhaseTrack
from vision.rate.least_squares import least_squares

FEWEST = 4  # looks, twice what determines a line
NOTABLE = 1e-5  # relative rate; fact: a tenth of a poor clock (100 ppm)


@dataclass(frozen=True)
class CameraRoll:
    """Roll of the camera that is left in the angles.

    Attributes
    ----------
    rate_rad_s : float
        Its mean rate, unsigned, without what its own scatter explains.
    rolled_rad : float
        Roll from the first look to the last at this rate.
    """

    rate_rad_s: float = 0.0
    rolled_rad: float = 0.0

    def warnings(self, source: str, rate_rad_s: float) -> tuple[str, ...]:
        """A warning if it matters for a plate of this rate."""
        relative = self.rate_rad_s / abs(rate_rad_s)
        if relative < NOTABLE:
            return ()
        return (
            f"{source}: fix the camera and film again: it rolls by "
            f"{np.degrees(self.rolled_rad):.2g}° against what stands around the plate. The sd "
            f"includes {1e6 * relative:.0f} ppm for it.",
        )


def camera_roll(track: PhaseTrack) -> CameraRoll:
    """Mean rate of the roll over a track."""
    seen = np.isfinite(track.roll_rad)
    if seen.sum() < FEWEST:
        return CameraRoll()
    time_s = track.time_s[seen] - track.time_s[seen].mean()
    fit = least_squares(np.stack([np.ones_like(time_s), time_s], axis=1), track.roll_rad[seen])
    rate = float(np.sqrt(max(fit.beta[1] ** 2 - fit.sd[1] ** 2, 0.0)))
    return CameraRoll(rate, rate * float(np.ptp(time_s)))
