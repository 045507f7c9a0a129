"""A camera before a turning disc on a table: planes in space to pixels.

The table is the plane z = 0, the disc turns about the z axis at a height above it; lengths are in
radii of the disc. The camera looks at a point, and a hand moves and rolls it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

TABLE_SIDE = 7.0  #: radii
DISC_HEIGHT = 0.12


@dataclass(frozen=True)
class Camera:
    """Where the camera stands and how a hand moves it.

    Parameters
    ----------
    size_px : (width, height)
    radius_px : float
        The disc's radius as seen at its middle.
    distance : float
        To the disc, radii.
    tilt_rad, azimuth_rad : float
        Of the line of sight from the vertical, and towards where.
    aim_px : (x, y)
        Where the spindle appears, from the middle of the frame.
    sway_px, roll_rad : float
        Amplitudes of the motion of a hand; 0 on a stand.
    creep_rad_s : float
        Rate at which a holder that gives way rolls it.
    bump_s, bump_px : float
        When the camera is pushed, and how far.
    """

    size_px: tuple[int, int] = (480, 360)
    radius_px: float = 130.0
    distance: float = 6.0
    tilt_rad: float = 0.4
    azimuth_rad: float = -1.6
    aim_px: tuple[float, float] = (0.0, 0.0)
    sway_px: float = 0.0
    roll_rad: float = 0.0
    creep_rad_s: float = 0.0
    bump_s: float = np.inf
    bump_px: float = 0.0
    seed: int = 0

    @property
    def moves(self) -> bool:
        """A hand holds it or bumps it, or its holder gives way."""
        return bool(self.sway_px or self.roll_rad or self.creep_rad_s or np.isfinite(self.bump_s))

    def view(self, time_s: float) -> Matrix:
        """Space to pixels, shape (3, 4)."""
        sway = self._hand(time_s, 0) * self.sway_px, self._hand(time_s, 1) * self.sway_px
        st, ct = np.sin(self.tilt_rad), np.cos(self.tilt_rad)
        away = np.array([st * np.cos(self.azimuth_rad), st * np.sin(self.azimuth_rad), ct])
        # A third of the sway is the hand's place, the rest its direction.
        aside = np.array([sway[0], -sway[1], 0.0]) / (3 * self.radius_px)
        place = self.distance * away + aside
        place[2] += DISC_HEIGHT
        down = np.array([0, -1, 0.0]) if st < 1e-3 else -np.array([0, 0, 1.0])
        forward = -away
        right = np.cross(down, forward)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(forward, right), forward])
        roll = self.roll_rad * self._hand(time_s, 2) + self.creep_rad_s * time_s
        c, s = np.cos(roll), np.sin(roll)
        axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ axes
        past = time_s - self.bump_s
        bump = self.bump_px * (1 - np.exp(-past / 0.1)) if past > 0 else 0.0
        w, h = self.size_px
        x = (w - 1) / 2 + self.aim_px[0] + 0.67 * sway[0] + bump
        y = (h - 1) / 2 + self.aim_px[1] + 0.67 * sway[1] + 0.6 * bump
        focal = self.radius_px * self.distance
        inner = np.array([[focal, 0, x], [0, focal, y], [0, 0, 1.0]])
        return inner @ np.column_stack([axes, -axes @ place])

    def _hand(self, time_s: float, what: int) -> float:
        """A few slow waves, about 1 in size."""
        rng = np.random.default_rng([self.seed, 5, what])
        hz, phase = rng.uniform([0.05, 0.2, 0.6, 1.5], [0.2, 0.6, 1.5, 4]), rng.uniform(0, 6.28, 4)
        return float((np.array([0.6, 0.5, 0.25, 0.08]) * np.sin(6.283 * hz * time_s + phase)).sum())


def table_to_frame(view: Matrix, side: int) -> Matrix:
    """Pixels of the table's drawing to pixels of the frame."""
    return _plane(view, np.zeros(3), np.eye(3)[0], np.eye(3)[1], TABLE_SIDE / side, side)


def disc_to_frame(
    view: Matrix, side: int, half_side: float, angle_rad: float, wobble_rad: float
) -> Matrix:
    """Pixels of the disc's drawing to pixels of the frame, the disc turned and warped."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    u = turn @ np.array([np.cos(wobble_rad), 0, np.sin(wobble_rad)])
    v = turn @ np.array([0, 1.0, 0])
    return _plane(view, np.array([0, 0, DISC_HEIGHT]), u, v, 2 * half_side / side, side)


def disc_box(
    view: Matrix, size_px: tuple[int, int], half_side: float, wobble_rad: float
) -> tuple[slice, slice]:
    """Rows and columns of the frame outside which the disc never is, however it turns."""
    around = np.linspace(0, 2 * np.pi, 90)
    reach = half_side  # beyond the rim the drawing is empty
    rim = np.array([[reach * np.cos(a), reach * np.sin(a), DISC_HEIGHT + z, 1.0]
                    for a in around for z in reach * np.sin(wobble_rad) * np.array([-1, 1])])
    x, y, depth = view @ rim.T
    w, h = size_px
    columns, rows = ((int(np.clip(np.floor((c / depth).min()), 0, most - 1)),
                      int(np.clip(np.ceil((c / depth).max()) + 1, 1, most)))
                     for c, most in ((x, w), (y, h)))
    return slice(*rows), slice(*columns)


def _plane(view: Matrix, origin: Matrix, u: Matrix, v: Matrix, step: float, side: int) -> Matrix:
    middle = (side - 1) / 2
    plane = np.column_stack([u, v, origin])
    draw = np.array([[step, 0, -step * middle], [0, -step, step * middle], [0, 0, 1.0]])
    lift = np.vstack([plane @ draw, [0, 0, 1.0]])
    return np.asarray(view @ lift)
