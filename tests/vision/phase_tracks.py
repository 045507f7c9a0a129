"""Phase tracks made from numbers, for tests of everything that comes after the frames."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vision.drawing import png
from vision.geometry import view_of_ellipse
from vision.phase_track import LUMA, PhaseTrack, PlateLayout
from vision.rate.timebase import Timebase

FloatArray = NDArray[np.float64]

RPM = 2 * np.pi / 60
CLOCK = Timebase(ppm=0.0)
NOISE = 4e-4  #: rad, of one frame
LAYOUT: dict[str, Any] = {
    "view": view_of_ellipse((240.0, 180.0), (140.0, 140.0), 0.0).matrix,
    "reduction": 1,
    "size_px": (480, 360),
    "channel": LUMA,
    "symmetry": 1,
    "mark_azimuth_rad": 0.0,
    "mark_radius": 0.9,
    "explained": 0.95,
}


def phase_track(
    time_s: FloatArray,
    angle_rad: FloatArray,
    *,
    noise_rad: float = 0.0,
    seed: int = 0,
    **changes: Any,
) -> PhaseTrack:
    """A track of a plate of 140 pixels seen from above, its mark at azimuth zero.

    The changes are fields of the track or of its plate.
    """
    rng = np.random.default_rng(seed)
    n = len(time_s)
    phase = angle_rad + noise_rad * rng.standard_normal(n)
    grid = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    # A pattern of several waves, each pixel seeing another part of it: returns once per turn.
    pattern = (
        128 + 40 * np.cos(angle_rad[:, None] - grid) + 30 * np.cos(3 * angle_rad[:, None] + grid)
    )
    plate = {name: changes.pop(name, value) for name, value in LAYOUT.items()}
    values: dict[str, Any] = {
        "source": "made.mp4",
        "plate": PlateLayout(**plate),
        "time_s": np.asarray(time_s, float),
        "phase_rad": np.angle(np.exp(1j * phase)),
        "quality": np.full(n, 0.99),
        "duplicate": np.zeros(n, bool),
        "coding": np.full(n, ord("B"), np.uint8),
        "thumbnail": np.rint(pattern).astype(np.uint8),
        "smear_rad2": np.zeros(n),
        "brightness": np.full(n, 128.0),
        "motion": np.tile(np.eye(3), (n, 1, 1)),
        "roll_rad": np.full(n, np.nan),
        "annotated": png(np.zeros((4, 4, 3), np.uint8)),
        "notes": (),
    }
    return PhaseTrack(**{**values, **changes})


def steady(
    rpm: float = 33.3, seconds: float = 60.0, fps: float = 15.0, start_rad: float = 0.7
) -> tuple[FloatArray, FloatArray]:
    """Times and angles of an even rotation."""
    time = np.arange(round(seconds * fps)) / fps
    return time, start_rad + rpm * RPM * time
