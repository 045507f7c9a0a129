"""What a camera that rolls does to the rate."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack

FEWEST = 6  # pictures in which the surroundings were looked at
SMOOTHED = 5  # of them
ROLLED_RAD = np.radians(0.3)
CLEAR = 8.0  # times the noise, for a roll to be told from it


@dataclass(frozen=True)
class CameraRoll:
    """A camera that rolled while it filmed.

    Attributes
    ----------
    range_rad : float
        How far.
    rate_rad_s : float
        Slope against time, counter-clockwise as filmed: what it adds to the rate of the plate.
    """

    range_rad: float
    rate_rad_s: float


def camera_roll(track: PhaseTrack, time_s: FloatArray) -> CameraRoll | None:
    """The camera's roll; None where it stood still, or where that cannot be seen."""
    seen = np.isfinite(track.roll_rad)
    if seen.sum() < FEWEST:
        return None
    time, roll = time_s[seen], track.roll_rad[seen]
    noise = 1.4826 * float(np.median(np.abs(np.diff(roll, 2)))) / np.sqrt(6.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(roll, SMOOTHED), axis=1)
    range_rad = float(np.ptp(smooth))
    if range_rad < max(ROLLED_RAD, CLEAR * noise):
        return None
    away = time - time.mean()
    return CameraRoll(range_rad, float(away @ roll / (away @ away)))
