"""A camera that rolls while it films adds its own rate to that of the plate."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD
from vision.phase_track import PhaseTrack

FEWEST_ROLLS = 6  # frames in which the surroundings were looked at
SMOOTHED_ROLLS = 5  # of them


@dataclass(frozen=True)
class RollThresholds:
    """When a roll matters.

    Attributes
    ----------
    rolled_rad : float
        Range of the camera's roll that matters, rad.
    clear_roll : float
        Times the noise of one roll, that the range exceeds.
    """

    rolled_rad: float = 0.0052
    clear_roll: float = 8.0


THRESHOLDS = RollThresholds()


@dataclass(frozen=True)
class CameraRoll:
    """A camera that rolled while it filmed.

    Attributes
    ----------
    range_rad : float
        How far, rad.
    rate_rad_s : float
        Slope against time, counter-clockwise as filmed: what it adds to the rate of the plate.
    """

    range_rad: float
    rate_rad_s: float


def camera_roll(track: PhaseTrack, time_s: FloatArray) -> CameraRoll | None:
    """The camera's roll; None where it stood still, or where that cannot be seen.

    Parameters
    ----------
    track : PhaseTrack
    time_s : array, shape (f,)
        Of every frame of the track, s.
    """
    seen = np.isfinite(track.roll_rad)
    if seen.sum() < FEWEST_ROLLS:
        return None
    time, roll = time_s[seen], track.roll_rad[seen]
    noise = SD_PER_MAD * float(np.median(np.abs(np.diff(roll, 2)))) / np.sqrt(6.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(roll, SMOOTHED_ROLLS), axis=1)
    range_rad = float(np.ptp(smooth))
    if range_rad < max(THRESHOLDS.rolled_rad, THRESHOLDS.clear_roll * noise):
        return None
    away = time - time.mean()
    return CameraRoll(range_rad, float(away @ roll / (away @ away)))
