"""Whether the camera itself turns: what surrounds the plate stands still, unless the camera moves.

A camera that rolls adds its own rate to the plate's, and the plate cannot show it; what lies around
it can. Against the background S, each frame of the surroundings is, for a small
roll α about the spindle and a small shift (u, v),

    P - S = -α t·∇S - u ∂S/∂x - v ∂S/∂y + g S + h,        t = (-(y - y₀), x - x₀),

with the light allowed to change by g and h. Large motions are followed step by step: a frame is
first moved back by what the one before it gave. A camera moves all the surroundings alike; a hand
moves in one place. So α counts where it is the same with any of the sectors left out.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.video.reader import Luma
from vision.video.reduction import reduced

LARGEST_SIDE = 160  # pixels; the surroundings are large
BORDER = 4  # pixels; what moves in there from outside is unknown
ITERATIONS = 2  #: iterations of the motion; numerical
BACK = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
RIDGE = 1e-12  # of the mean diagonal: above rounding, below all that is measured
SECTORS = 8  # of the surroundings, about the spindle
LASTING = 3  # frames that are looked at: a hand or a flash is gone by then


@dataclass(frozen=True)
class CameraMotionThresholds:
    """Which of the surroundings count.

    Attributes
    ----------
    around : float
        Plate radii, from which on nothing turns with the plate. Tuned on tests.bench.vision_scenes.
    stray : float
        Steps of luma; more pulls no harder: it is something in the way. Derived: six times the
        noise of a frame.
    moved_px : float
        Shift of the surroundings, pixels of the analysed frame, that is a camera's. Tuned on
        tests.bench.clip_study bump.
    seen_rad : float
        Sd of the roll in rad, above which the surroundings show too little. Derived: a third of the
        range that is worth a warning.
    """

    around: float = 1.06
    stray: float = 12.0
    moved_px: float = 1.0
    seen_rad: float = math.radians(0.1)


THRESHOLDS = CameraMotionThresholds()


class CameraMotion:
    """The camera's roll against the background around the plate.

    Parameters
    ----------
    view : PlateView
    background : array of uint8, shape (h, w)
    """

    def __init__(self, view: PlateView, background: Luma) -> None:
        self._factor = -(-max(background.shape) // LARGEST_SIDE)
        self._background = self._reduced(background)
        h, w = self._background.shape
        middle = (self._factor - 1) / 2
        y, x = np.mgrid[0:h, 0:w].astype(float)
        radius, azimuth = view.at_rest.plate(x * self._factor + middle, y * self._factor + middle)
        around = radius > THRESHOLDS.around
        around[:BORDER] = around[-BORDER:] = False
        around[:, :BORDER] = around[:, -BORDER:] = False
        self._spindle = [(c - middle) / self._factor for c in view.at_rest.centre_px]
        by_x = cv2.Sobel(self._background, cv2.CV_32F, 1, 0, scale=1 / 8)
        by_y = cv2.Sobel(self._background, cv2.CV_32F, 0, 1, scale=1 / 8)
        roll = by_y * (x - self._spindle[0]) - by_x * (y - self._spindle[1])
        parts = (-roll, -by_x, -by_y, self._background, np.ones_like(self._background))
        sector = np.floor(azimuth[around] * SECTORS / (2 * np.pi)).astype(int) % SECTORS
        order = np.argsort(sector, kind="stable")
        ends = np.searchsorted(sector[order], np.arange(SECTORS + 1))
        self._sectors = [slice(start, stop) for start, stop in pairwise(ends)]
        self._places = np.flatnonzero(around)[order]
        self._basis = np.stack([part.ravel()[self._places] for part in parts]).astype(np.float32)
        self._normal = np.array(
            [self._basis[:, part] @ self._basis[:, part].T for part in self._sectors], float
        )
        without = self._normal.sum(axis=0) - self._normal
        self._determined = bool((np.linalg.matrix_rank(without) == len(parts)).all())
        self._moved = np.zeros(3)  # α, u, v of the latest frame
        self._shifts_px: list[float] = []

    def roll(self, image: Luma) -> float:
        """Angle by which the surroundings seem to turn since the background.

        Parameters
        ----------
        image : array of uint8, shape (h, w)
            Frames have to come in order.

        Returns
        -------
        float
            In rad, counter-clockwise as filmed; NaN where the surroundings do not determine it.
        """
        if not self._determined:
            return float("nan")
        small, normal = self._reduced(image), self._normal
        h, w = small.shape
        for _ in range(ITERATIONS):
            alpha, u, v = self._moved
            c, s = np.cos(alpha), np.sin(alpha)
            x0, y0 = self._spindle
            back = np.array([[c, -s, x0 - c * x0 + s * y0 + u], [s, c, y0 - s * x0 - c * y0 + v]])
            moved = cv2.warpAffine(small, back, (w, h), flags=BACK)
            beyond = (moved - self._background).ravel()[self._places]
            pull = self._basis * np.clip(beyond, -THRESHOLDS.stray, THRESHOLDS.stray)
            by_sector = np.array([pull[:, part].sum(axis=1) for part in self._sectors], float)
            change = _solved(normal.sum(axis=0), by_sector.sum(axis=0))
            self._moved = self._moved + change[:3]
        without = _solved(normal.sum(axis=0) - normal, by_sector.sum(axis=0) - by_sector)
        sd = float(np.sqrt(SECTORS - 1) * np.std(without[:, 0]))  # of the jackknife
        if sd >= THRESHOLDS.seen_rad:
            return float("nan")
        self._shifts_px.append(self._factor * float(np.hypot(*self._moved[1:])))
        return -float(self._moved[0])

    @property
    def moved(self) -> bool:
        """The surroundings went elsewhere, and not only in a frame or two."""
        if len(self._shifts_px) < LASTING:
            return False
        lasting = np.lib.stride_tricks.sliding_window_view(self._shifts_px, LASTING).min(axis=1)
        return bool(lasting.max() > THRESHOLDS.moved_px)

    def _reduced(self, image: Luma) -> NDArray[np.float32]:
        small = reduced(image, self._factor).astype(np.float32)
        return np.asarray(cv2.GaussianBlur(small, (3, 3), 0))


def _solved(normal: FloatArray, pull: FloatArray) -> FloatArray:
    """Solutions of one or several systems, kept near zero in what they do not determine."""
    size = normal.shape[-1]
    ridge = RIDGE * np.trace(normal, axis1=-2, axis2=-1)[..., None, None] * np.eye(size)
    return np.asarray(np.linalg.solve(normal + ridge, pull[..., None])[..., 0])
