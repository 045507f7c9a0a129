"""The view of the plate: where a point of its plane appears in the frame.

A pinhole camera maps the plane of the plate by a homography,

    (x, y, 1) ∝ H (u, v, 1),

with the spindle at u = v = 0 and the rim at √(u² + v²) = 1. Turning and scaling the plate leaves
six numbers that matter: the two of the centre, two of the foreshortening, two of the perspective.

Most cameras read a frame row by row, and the plate turns meanwhile: a point that is at azimuth φ
when the row of the spindle is read appears at φ + λ (y - y_spindle) in row y, with λ the rate times
the time per row. That is the seventh number.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

VIEW_PARAMETERS = 7  #: parameters of a view: six of H, and the lag of the read-out
READOUT_ROUNDS = 3  # of the row of a point, which its own lag moves: exact to λ³ times the radius³


@dataclass(frozen=True, eq=False)
class PlateView:
    """Plate coordinates to pixels.

    Attributes
    ----------
    matrix : array, shape (3, 3)
        H of the module's equation.
    lag_rad_px : float
        λ, rotation of the plate from one row to the next.
    """

    matrix: FloatArray
    lag_rad_px: float = 0.0

    @property
    def at_rest(self) -> "PlateView":
        """The view of the parts that do not turn: the read-out does not move them."""
        return replace(self, lag_rad_px=0.0)

    @property
    def centre_px(self) -> tuple[float, float]:
        """Pixel of the spindle."""
        x, y, n = self.matrix[:, 2]
        return float(x / n), float(y / n)

    @property
    def radius_px(self) -> float:
        """Approximate semi-major axis of the rim in the frame."""
        x, y = self.pixels(np.ones(72), np.linspace(0, 2 * np.pi, 72, endpoint=False))
        return float(np.hypot(x - x.mean(), y - y.mean()).max())

    @property
    def tilt_rad(self) -> float:
        """Angle between the optical axis and the turning axis, from the foreshortening."""
        squeeze = np.linalg.svd(self.jacobian_at_centre(), compute_uv=False)
        return float(np.arccos(np.clip(squeeze[1] / squeeze[0], 0, 1)))

    def jacobian_at_centre(self) -> FloatArray:
        """∂(x, y)/∂(u, v) at the spindle, px per plate radius, shape (2, 2)."""
        h = self.matrix / self.matrix[2, 2]
        return np.asarray(h[:2, :2] - np.outer(h[:2, 2], h[2, :2]))

    def pixels(self, radius: FloatArray, azimuth_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Pixels x and y, each (...,), of points in polar plate coordinates (broadcast)."""
        x, y = self._project(radius, azimuth_rad)
        if self.lag_rad_px:
            spindle = self.centre_px[1]
            for _ in range(READOUT_ROUNDS):
                x, y = self._project(radius, azimuth_rad + self.lag_rad_px * (y - spindle))
        return x, y

    def _project(
        self, radius: FloatArray, azimuth_rad: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        u, v = radius * np.cos(azimuth_rad), radius * np.sin(azimuth_rad)
        x, y, n = (row[0] * u + row[1] * v + row[2] for row in self.matrix)
        return x / n, y / n

    def plate(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radius in plate radii and azimuth in rad, each (...,), of pixels (broadcast)."""
        u, v, n = (row[0] * x + row[1] * y + row[2] for row in np.linalg.inv(self.matrix))
        azimuth = np.arctan2(v / n, u / n) - self.lag_rad_px * (y - self.centre_px[1])
        return np.hypot(u / n, v / n), azimuth

    @property
    def down(self) -> FloatArray:
        """Direction on the plate that points down in the frame, times its pixels, shape (2,)."""
        return np.asarray(self.jacobian_at_centre()[1])

    def adjusted(self, change: FloatArray) -> "PlateView":
        """The view after a small change, shape (7,).

        Shift u, v; stretch; shear; perspective u, v; lag over the rows of one plate radius down
        the frame. A point (u, v) moves to (u, v) + shift + stretch (u, -v) + shear (v, u), divided
        by 1 + p_u u + p_v v.
        """
        du, dv, stretch, shear, pu, pv, lag = change
        step = np.array([[1 + stretch, shear, du], [shear, 1 - stretch, dv], [pu, pv, 1.0]])
        rows = float(np.hypot(*self.down))
        return PlateView(self.matrix @ step, self.lag_rad_px + lag / rows)

    def encloses(self, x: float | FloatArray, y: float | FloatArray) -> NDArray[np.bool_]:
        """Whether pixels are inside the rim, (...,) (broadcast)."""
        return np.asarray(self.at_rest.plate(np.asarray(x), np.asarray(y))[0] < 1)

    def about(self, x: float, y: float) -> "PlateView":
        """The view with the same rim whose spindle appears at a pixel inside it.

        The projective maps that keep the unit circle carry its centre to any point p inside:
        (u, v, 1) ∝ (I + (γ-1) p̂p̂ᵀ, γp; γpᵀ, γ) (u', v', 1) with γ = 1/√(1-p²).
        """
        radius, azimuth = self.at_rest.plate(np.array(x), np.array(y))
        if not radius < 1:
            raise ValueError(f"the pixel ({x}, {y}) is outside the rim")
        towards = np.array([np.cos(azimuth), np.sin(azimuth)])
        gamma = 1 / np.sqrt(1 - radius**2)
        step = np.eye(3)
        step[:2, :2] += (gamma - 1) * np.outer(towards, towards)
        step[:2, 2] = step[2, :2] = gamma * radius * towards
        step[2, 2] = gamma
        return replace(self, matrix=self.matrix @ step)


def view_of_ellipse(
    centre_px: tuple[float, float], axes_px: tuple[float, float], angle_rad: float
) -> PlateView:
    """The view without perspective in which the unit circle appears as the ellipse.

    Parameters
    ----------
    centre_px : (x, y)
    axes_px : (a, b)
        Semi-axes.
    angle_rad : float
        Direction of the first axis, from x towards y (downwards).
    """
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    along, across = np.array([c, s]), np.array([-s, c])
    # Symmetric, so that azimuth zero stays on the right and the frame is not rotated.
    shape = axes_px[0] * np.outer(along, along) + axes_px[1] * np.outer(across, across)
    matrix = np.eye(3)
    matrix[:2, :2] = shape @ np.diag([1.0, -1.0])  # v upwards
    matrix[:2, 2] = centre_px
    return PlateView(matrix)


@dataclass(frozen=True)
class PlateOverride:
    """The plate's rim as an ellipse that the user measured in the frame.

    Parameters
    ----------
    centre_px : (x, y)
        Centre of the ellipse in pixels of the clip.
    radius_px : float
        Its semi-major axis.
    minor_px : float, optional
        Its semi-minor axis; a circle without it.
    angle_deg : float
        Direction of the major axis, from x to the right towards y down.
    """

    centre_px: tuple[float, float]
    radius_px: float
    minor_px: float | None = None
    angle_deg: float = 0.0

    def view(self, reduction: int) -> PlateView:
        """The view in pixels of a frame reduced by a whole factor."""
        minor = self.radius_px if self.minor_px is None else self.minor_px
        # A block of n pixels has its centre at (n - 1)/2 of the old pixels.
        x, y = ((c + 0.5) / reduction - 0.5 for c in self.centre_px)
        axes = (self.radius_px / reduction, minor / reduction)
        return view_of_ellipse((x, y), axes, np.radians(self.angle_deg))
