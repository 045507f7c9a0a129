"""How evenly the angles of a track go: which of two tracks of a plate is the better one."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack

FEWEST_FRAMES = 12  # two per parameter of an even rotation with its waves
CHANGES = 0.2  # of the usual rate, from turn to turn: a plate that runs up, stops or is turned


def scatter_rad(track: "PhaseTrack") -> float:
    """Robust sd of the angles about an even rotation with a wave once and twice per turn, rad.

    Of a plate that changes its speed, and is seen well, the noise of a frame; infinite where too
    few frames can be used.
    """
    from vision.rate.slow_camera import frame_times
    from vision.rate.unwrap import (
        continuous_angle,
        rate_history,
        rough_rate,
        scatter_about_even,
        usable,
    )

    if usable(track).sum() < FEWEST_FRAMES:
        return np.inf
    frames = frame_times(track, track.time_s)  # a camera slower than its clip is no uneven plate
    track = frames.track
    angle = continuous_angle(track, frames.time_s, rough_rate(track, frames.time_s))
    history = rate_history(angle)
    rate = history.rate_rad_s
    if np.ptp(rate) > CHANGES * abs(np.median(rate)):
        return history.phase_noise_rad
    return scatter_about_even(angle)
