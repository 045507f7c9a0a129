"""How the plate of the simulated bench turns: the one truth behind film and inertial readings.

The plate is driven at a base rate that may drift, run up or coast, and its drive is uneven at
places that stay fixed on the plate (an eccentric hub, a kink in the belt pulley):

    dθ/dt = β(t) g(θ),   g(θ) = 1 + Σ a_k cos(k θ + p_k)

The two factors separate, so θ follows without a step-by-step solver: with B(t) = ∫β dt and
H(θ) = ∫dθ/g(θ), the motion is H(θ(t)) = B(t). Both integrals are taken numerically on a fine grid.
Nothing here is shared with the packages under test.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

FloatArray = NDArray[np.float64]

GRID_S = 2e-3  # base-rate grid; its fastest feature, a run-up, takes seconds
CELLS_PER_WAVE = 200  # angle grid, per period of the highest order of wow
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class PlateMotion:
    """Angle and rate of the plate against time, from ``time_s = 0`` on.

    Parameters
    ----------
    rate_rad_s : float
        Base rate; positive is counter-clockwise seen from above, which is as filmed. 0 is a
        plate at rest.
    wow : tuple of (order, amplitude, phase)
        Relative unevenness of the drive, ``order`` waves per revolution (not necessarily whole),
        ``amplitude`` relative to the rate, ``phase`` in radians at plate angle zero.
    drift_rad_s2 : float
        Rate of change of the base rate.
    run_up_s : float
        Time constant of the start from rest; 0 starts at full rate.
    coast_from_s, coast_s : float
        From ``coast_from_s`` on the base rate decays with time constant ``coast_s``.
    angle_rad : float
        Plate angle at ``time_s = 0``.
    """

    rate_rad_s: float
    wow: tuple[tuple[float, float, float], ...] = ()
    drift_rad_s2: float = 0.0
    run_up_s: float = 0.0
    coast_from_s: float = float("inf")
    coast_s: float = 20.0
    angle_rad: float = 0.0

    def base_rate(self, time_s: FloatArray) -> FloatArray:
        """β(t) in rad/s: the rate without the unevenness of the drive."""
        beta = self.rate_rad_s + self.drift_rad_s2 * time_s
        if self.run_up_s > 0:
            beta = beta * -np.expm1(-time_s / self.run_up_s)
        return beta * np.exp(-np.maximum(time_s - self.coast_from_s, 0.0) / self.coast_s)

    def unevenness(self, angle_rad: FloatArray) -> FloatArray:
        """g(θ), dimensionless, mean close to one."""
        g = np.ones_like(angle_rad)
        for order, amplitude, phase in self.wow:
            g = g + amplitude * np.cos(order * angle_rad + phase)
        return g

    def angle(self, time_s: FloatArray) -> FloatArray:
        """Plate angle in radians, not wrapped, same shape as ``time_s``."""
        time_s = np.asarray(time_s, float)
        if time_s.size and time_s.min() < 0:
            raise ValueError("the motion of the plate is defined from time 0 on")
        driven = self._base_angle(time_s)  # B(t)
        if not self.wow or not np.any(driven):
            return self.angle_rad + driven
        amplitude = sum(abs(a) for _, a, _ in self.wow)
        reach = driven / (1 - amplitude)
        order = max(1.0, *(k for k, _, _ in self.wow))
        low, high = min(0.0, reach.min()), max(0.0, reach.max())
        cells = int(np.ceil((high - low) * order * CELLS_PER_WAVE / (2 * np.pi))) + 1
        # The grid passes through zero so that H(0) = 0 exactly.
        step = (high - low) / cells
        theta = step * np.arange(np.floor(low / step) - 1, np.ceil(high / step) + 2)
        nodes = theta[:-1, None] + 0.5 * step * (GAUSS_NODES + 1)
        piece = 0.5 * step * (GAUSS_WEIGHTS / self.unevenness(self.angle_rad + nodes)).sum(axis=1)
        h = np.concatenate([[0.0], np.cumsum(piece)])
        h -= h[np.flatnonzero(np.abs(theta) < 0.5 * step)[0]]
        invert = CubicHermiteSpline(h, theta, self.unevenness(self.angle_rad + theta))
        return self.angle_rad + invert(driven)

    def rate(self, time_s: FloatArray) -> FloatArray:
        """dθ/dt in rad/s, same shape as ``time_s``."""
        time_s = np.asarray(time_s, float)
        return self.base_rate(time_s) * self.unevenness(self.angle(time_s))

    def _base_angle(self, time_s: FloatArray) -> FloatArray:
        if self.run_up_s == 0 and np.isinf(self.coast_from_s):
            return self.rate_rad_s * time_s + 0.5 * self.drift_rad_s2 * time_s**2
        end = float(time_s.max()) if time_s.size else 0.0
        # Knots on both sides of the kink where coasting sets in.
        kink = [self.coast_from_s] if 0 < self.coast_from_s < end else []
        grid = np.unique(
            np.concatenate([np.linspace(0.0, end + GRID_S, int(end / GRID_S) + 3), kink])
        )
        width = np.diff(grid)
        nodes = grid[:-1, None] + 0.5 * width[:, None] * (GAUSS_NODES + 1)
        piece = 0.5 * width * (GAUSS_WEIGHTS * self.base_rate(nodes)).sum(axis=1)
        total = np.concatenate([[0.0], np.cumsum(piece)])
        return CubicHermiteSpline(grid, total, self.base_rate(grid))(time_s)
