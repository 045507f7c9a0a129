"""Phase tracks made from numbers, for tests of everything that comes after the pictures."""

import numpy as np

from vision.geometry import view_of_ellipse
from vision.phase_track import LUMA, PhaseTrack

RPM = 2 * np.pi / 60


def phase_track(time_s, angle_rad, *, noise_rad=0.0, seed=0, **changes):
    """A track of a plate of 140 pixels seen from above, its mark at azimuth zero."""
    rng = np.random.default_rng(seed)
    n = len(time_s)
    phase = angle_rad + noise_rad * rng.standard_normal(n)
    grid = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    # A pattern of several waves, each pixel seeing another part of it: returns once per turn.
    pattern = (
        128 + 40 * np.cos(angle_rad[:, None] - grid) + 30 * np.cos(3 * angle_rad[:, None] + grid)
    )
    values = {
        "source": "made.mp4",
        "time_s": np.asarray(time_s, float),
        "phase_rad": np.angle(np.exp(1j * phase)),
        "seed_rad": np.angle(np.exp(1j * (phase + noise_rad * rng.standard_normal(n)))),
        "quality": np.full(n, 0.99),
        "duplicate": np.zeros(n, bool),
        "coding": np.full(n, ord("B"), np.uint8),
        "thumbnail": np.rint(pattern).astype(np.uint8),
        "roll_rad": np.full(n, np.nan),
        "symmetry": 1,
        "mark_rad": 0.0,
        "mark_radius": 0.9,
        "deck_mark_rad": -1.0,
        "deck_mark_radius": 1.1,
        "view": view_of_ellipse((240.0, 180.0), (140.0, 140.0), 0.0).matrix,
        "size_px": (480, 360),
        "reduction": 1,
        "explained": 0.99,
        "fps_stated": 15.0,
        "annotated": np.zeros((4, 4, 3), np.uint8),
        "notes": (),
        "channel": LUMA,
    }
    return PhaseTrack(**{**values, **changes})


def steady(rpm=33.3, seconds=60.0, fps=15.0, start_rad=0.7):
    """Times and angles of an even rotation."""
    time = np.arange(round(seconds * fps)) / fps
    return time, start_rad + rpm * RPM * time
