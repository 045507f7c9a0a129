"""A hand drawn on a computer's screen, as a camera sees it: held from refresh to refresh.

A screen shows the same picture until its next refresh. The page draws at every refresh the angle of
that moment, by its own clock; what a camera sees in an exposure is the mean of what was shown
during it. This is summed from the true times of the refreshes; nothing is shared with the package.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ScreenHand:
    """The angle of the hand against true time, seen with an exposure; made like a ``PlateMotion``.

    Parameters
    ----------
    rate_rad_s : float
        By the clock of the page.
    refresh_hz : float
        True refreshes per second.
    exposure_s : float
        Of the camera.
    page_ppm : float
        The page's clock runs fast by so much.
    missed : float
        Share of the refreshes at which the page was late: the picture of the one before stays.
    phase : float
        When the first refresh comes, 0 to 1 of their distance.
    seed : int
        Of the missed refreshes.
    """

    rate_rad_s: float
    refresh_hz: float = 60.0
    exposure_s: float = 1 / 100
    page_ppm: float = 0.0
    missed: float = 0.0
    phase: float = 0.3
    seed: int = 0

    def shown(self, refresh: NDArray[np.int64]) -> FloatArray:
        """Angle on the screen from refresh number ``refresh`` on, same shape."""
        if self.missed:
            late = np.random.default_rng([self.seed, 9]).random(1 << 16) < self.missed
            refresh = refresh - late[refresh % len(late)]
        begun_s = (refresh + self.phase) / self.refresh_hz
        return self.rate_rad_s * (1 + 1e-6 * self.page_ppm) * begun_s

    def angle(self, time_s: FloatArray) -> FloatArray:
        """Mean of what is shown during the exposures about ``time_s``, same shape, rad."""
        time_s = np.asarray(time_s, float)
        first = time_s - self.exposure_s / 2
        last = time_s + self.exposure_s / 2
        at = np.floor(first * self.refresh_hz - self.phase).astype(int)
        seen, total = np.zeros_like(time_s), np.zeros_like(time_s)
        for step in range(int(np.ceil(self.exposure_s * self.refresh_hz)) + 1):
            begins = np.maximum((at + step + self.phase) / self.refresh_hz, first)
            ends = np.minimum((at + step + 1 + self.phase) / self.refresh_hz, last)
            lasts = np.maximum(ends - begins, 0.0)
            seen += lasts * self.shown(at + step)
            total += lasts
        return seen / total

    def rate(self, time_s: FloatArray) -> FloatArray:
        """What blurs the picture: the hand moves in steps, several of them in a long exposure."""
        time_s = np.asarray(time_s, float)
        return np.full_like(time_s, self.rate_rad_s)
