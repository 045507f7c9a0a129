"""The clock against which the rate is measured.

A rate is an angle over a time, and the time is the camera's. Its error is a pure scale error of
the rate that nothing in the clip can show, so it is stated, never estimated.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import median
from vision.phase_track import PhaseTrack

#: Sd of a camera's clock, parts per million, by default: crystals are accurate to 20-100;
#: a stated frame rate ("15 fps") is often a rounded or nominal one.
CLOCK_PPM = {"container": 100.0, "constant": 500.0}

#: fact: time lapse and high-speed cameras; other values are a mistake
SLOWEST_FPS, FASTEST_FPS = 0.5, 2000.0


@dataclass(frozen=True)
class Timebase:
    """Source of the times of the frames, and their uncertainty.

    Parameters
    ----------
    source : "container" or "constant"
        The stamps in the file, or frame number over ``fps``.
    fps : float, optional
        Frames per second when filmed; needed by "constant", not allowed with "container".
    ppm : float
        Standard deviation of the clock's rate, parts per million. A quartz in a camera or phone
        keeps 20 to 100.
    fast_ppm : float
        Measured excess rate of the clock: the rate of the plate is larger than by its seconds.
    camera : str
        Camera with the measured clock; empty without one.
    """

    source: Literal["container", "constant"] = "container"
    fps: float | None = None
    ppm: float = 50.0
    fast_ppm: float = 0.0
    camera: str = ""

    def __post_init__(self) -> None:
        if self.source not in ("container", "constant"):
            raise ValueError(f"timebase: source is '{self.source}', expected container or constant")
        if (self.source == "constant") != (self.fps is not None):
            raise ValueError("timebase: fps goes with source: constant, and only with it")
        if self.fps is not None and not self.fps > 0:
            raise ValueError(f"timebase: fps is {self.fps}, a positive number is expected")
        if not self.ppm >= 0:
            raise ValueError(f"timebase: ppm is {self.ppm}, zero or more is expected")

    def times(self, track: PhaseTrack) -> FloatArray:
        """Time of each frame in seconds, shape (f,).

        Raises
        ------
        RateRefused
            The container's stamps cannot be times of frames.
        """
        if self.fps is not None:
            return np.arange(len(track.time_s)) / self.fps / (1 + 1e-6 * self.fast_ppm)
        time = track.time_s
        step = np.diff(time)
        fps = 1 / max(float(median(step)), 1e-9)
        standing = int((step <= 0).sum())
        if standing or not SLOWEST_FPS <= fps <= FASTEST_FPS:
            fault = (
                f"{standing} of {len(step)} steps from frame to frame do not go forward"
                if standing
                else f"they state {fps:.6g} frames per second"
            )
            raise RateRefused(
                f"{track.source}: the time stamps in the file cannot be those of a clip: {fault}. "
                f"If the camera's frame rate is known, give it (--fps, or timebase: {{source: "
                f"constant, fps: ...}}); otherwise record into .mp4 or .mkv."
            )
        return np.asarray(time / (1 + 1e-6 * self.fast_ppm)) if self.fast_ppm else time
