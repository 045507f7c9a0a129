"""The roll of the camera, seen by everything around the plate at once.

A camera that rolls adds its own rate to that of the plate: 0.05 °/s are 250 ppm at 33 rpm. A roll
of less than a pixel escapes ``vision.tracking.registration``, as does a larger one if its corners
lie on a round rim. Each pixel x around the plate shows a small motion d(x) of the picture S by its
gradient, I(x) - S(x) = -∇S(x)·d(x); roll, shift and zoom of the camera and a change of the light
are solved from all of them together. Pixels that vary otherwise, by a hand, count the less.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from vision.geometry import FloatArray, PlateView
from vision.numbers import median
from vision.phase_track import BoolArray
from vision.plate.background import spread_choice
from vision.video.reader import Luma
from vision.video.reduction import reduced

SMALL = 320  #: pixels of the longer side: of single ones the codec keeps no small motion
LEARNED_FROM = 14  #: frames; as many as a registration looks at
BESIDE = 1.08  # plate radii: beyond the rim and its blur
EDGE_PX = 2  # at the edge of a frame a registered one has none of its own
ROUNDING = 1 / 12  # luma steps squared: least variance of a pixel
ROUNDS = 3  #: rounds of the weights; numerical
FEWEST = 500  # pixels: a plate that fills the frame leaves nothing around it


class RollGauge:
    """The picture around the plate, and its derivatives by the motion of a camera.

    Parameters
    ----------
    frames : sequence of arrays of uint8, shape (h, w)
        From which the picture is learned.
    view : PlateView
        Of the plate in them.
    """

    def __init__(self, frames: Sequence[Luma], view: PlateView) -> None:
        self._factor = -(-max(frames[0].shape) // SMALL)
        chosen = np.stack([self._small(frames[i])
                           for i in spread_choice(len(frames), LEARNED_FROM)])
        picture = chosen.mean(axis=0)
        self._around = _outside(view, self._factor, picture.shape)
        y, x = np.nonzero(self._around)
        x, y = (at - centre / self._factor for at, centre in zip((x, y), view.centre_px,
                                                                 strict=True))
        by_y, by_x = (each[self._around] for each in np.gradient(picture))
        self._picture = picture[self._around]
        columns = np.stack([x * by_y - y * by_x, by_x, by_y, x * by_x + y * by_y,
                            self._picture, np.ones(len(x))], axis=1)
        change, rest = chosen[:, self._around] - self._picture, np.zeros(len(x))
        for _ in range(ROUNDS):
            weighted = columns / (rest + max(float(median(rest)), ROUNDING))[:, None]
            solve = np.linalg.pinv(weighted.T @ columns, hermitian=True) @ weighted.T
            # What the motion explains varies most at the edges, which show it best.
            rest = ((change - change @ solve.T @ columns.T) ** 2).mean(axis=0)
        self._roll = solve[0]

    def roll_rad(self, luma: Luma) -> float:
        """Roll in a frame (h, w) against the learned ones, rad, with the sign of the plate's angle.

        NaN where too little is visible around the plate.
        """
        if len(self._picture) < FEWEST:
            return np.nan
        return float(self._roll @ (self._small(luma)[self._around] - self._picture))

    def _small(self, luma: Luma) -> FloatArray:
        return reduced(luma.astype(np.float32), self._factor)  # a step is more than it moves


def _outside(view: PlateView, factor: int, shape: tuple[int, ...]) -> BoolArray:
    """Whether the pixels of a reduced frame lie outside the rim, (h, w)."""
    rim = np.stack(view.pixels(np.full(90, BESIDE), np.linspace(0, 2 * np.pi, 90)), axis=1)
    mask = np.zeros(shape, np.uint8)
    mask[EDGE_PX:-EDGE_PX, EDGE_PX:-EDGE_PX] = 1
    return np.asarray(cv2.fillPoly(mask, [np.rint(rim / factor).astype(np.int32)], 0)) > 0
