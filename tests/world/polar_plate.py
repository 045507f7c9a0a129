"""The plate of a scene as a polar image, and the samples of a picture that are looked up in it.

Rows are radii, half a pixel of the picture each, columns azimuths; the image holds two turns, so
that a shift along a row is a turn of the plate.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.world.scene import FloatArray, Scene

Image = NDArray[np.float32]

AZIMUTHS = 4096  # columns of a turn: 0.2 pixel at the rim of a plate of 140 pixels
ORDERED = 512  # samples that stand side by side in the order of the polar image


class Samples:
    """The samples of a picture (h, w), looked up in the order in which the polar image holds them.

    In the order of the picture nearly every sample would wait for another line of the memory.
    """

    def __init__(self, scene: Scene, radius: Image, azimuth: Image) -> None:
        row = radius * rows_per_radius(scene)
        order = np.argsort((np.floor(row) * AZIMUTHS + azimuth).ravel())
        order = np.resize(order, (-(-order.size // ORDERED), ORDERED))
        self._row, self._azimuth = row.ravel()[order], azimuth.ravel()[order]
        self._line = (order // row.shape[1]).astype(np.uint16)
        place = np.empty((row.size, 2), np.int16)  # x, y of a sample in this order
        there = np.indices(order.shape[::-1]).T.reshape(-1, 2)
        place[order.ravel()[: row.size]] = there[: row.size]
        self._place = place.reshape(*row.shape, 2)

    def look_up(self, polar: Image, angle_rad: FloatArray) -> Image:
        """The polar image at the samples, each line (h,) of the picture at its angle."""
        shift = (np.mod(angle_rad, 2 * np.pi) * AZIMUTHS / (2 * np.pi)).astype(np.float32)
        still = (shift == shift[0]).all()
        column = self._azimuth - (shift[0] if still else shift[self._line])
        column += AZIMUTHS  # the polar image holds two turns
        seen = cv2.remap(polar, column, self._row, cv2.INTER_LINEAR)
        return cv2.remap(seen, self._place, None, cv2.INTER_NEAREST)


def rows_per_radius(scene: Scene) -> np.float32:
    return np.float32(np.ceil(2 * scene.radius_px))


def ramp(distance_px: Image) -> Image:
    """Coverage of an edge seen by the lens: 0 outside to 1 inside over one pixel."""
    return np.clip(0.5 + distance_px, 0, 1).astype(np.float32)


def two_turns(polar: FloatArray) -> Image:
    once = polar.astype(np.float32)
    return np.hstack([once, once, once[:, :2]])


def polar_plate(scene: Scene, rng: np.random.Generator) -> tuple[Image, tuple[Image, Image]]:
    """Luma and chroma (offset from grey) of the plate at angle zero, as polar images."""
    rows = int(rows_per_radius(scene))
    radius = (np.arange(rows + 2) / rows)[:, None]
    azimuth = (np.arange(AZIMUTHS) * 2 * np.pi / AZIMUTHS)[None, :]
    x, y = radius * np.cos(azimuth), radius * np.sin(azimuth)
    px = scene.radius_px

    grooves = 1.5 * np.sin(radius * px * 1.9)
    luma = np.broadcast_to(scene.plate_luma + grooves, x.shape).copy()
    cb, cr = np.zeros_like(x), np.zeros_like(x)
    if scene.texture:
        speckle = cv2.GaussianBlur(rng.standard_normal((256, 256)), (0, 0), 1.5)
        speckle *= scene.texture / speckle.std()
        luma += cv2.remap(
            speckle.astype(np.float32),
            ((x + 1.05) * 121).astype(np.float32),
            ((y + 1.05) * 121).astype(np.float32),
            cv2.INTER_LINEAR,
        )

    def paint(
        near: slice, inside: FloatArray, value: float, blue: float = 0.0, red: float = 0.0
    ) -> None:
        for plane, colour in ((luma, value), (cb, blue), (cr, red)):
            plane[near] += inside * (colour - plane[near])

    def ring(inner: float, outer: float) -> slice:
        """The rows between two radii, and a pixel more on either side for the ramps."""
        return slice(max(0, int((inner - 1 / px) * rows)), int((outer + 1 / px) * rows) + 2)

    def box(
        cx: float, cy: float, turn: float, length: float, width: float
    ) -> tuple[slice, FloatArray]:
        middle, reach = np.hypot(cx, cy), np.hypot(length, width) / 2
        near = ring(middle - reach, middle + reach)
        dx, dy = x[near] - cx, y[near] - cy
        along = dx * np.cos(turn) + dy * np.sin(turn)
        across = -dx * np.sin(turn) + dy * np.cos(turn)
        return near, ramp(px * (length / 2 - np.abs(along))) * ramp(
            px * (width / 2 - np.abs(across))
        )

    if scene.label:
        near = ring(0, 0.30)
        paint(near, ramp(px * (0.30 - radius[near])) * np.ones_like(x[near]), 95, -10, 40)
        sector = ramp(px * radius[near] * (0.7 - np.abs(np.angle(np.exp(1j * (azimuth - 4.0))))))
        paint(near, ramp(px * (0.30 - radius[near])) * sector, 190, -8, 6)
    if scene.sensor_box:
        paint(*box(0.02, -0.01, 0.3, 0.34, 0.27), 150, -70, 60)
        near = ring(0.15, 0.62)
        reach = radius[near] - 0.15
        bend = 0.3 + 0.12 * np.sin(9 * reach)
        across = np.abs(np.angle(np.exp(1j * (azimuth - bend - np.pi)))) * radius[near]
        cable = ramp(px * (0.012 - across)) * ramp(px * reach) * ramp(px * (0.62 - radius[near]))
        paint(near, cable, 22)
    for mark in scene.marks:
        cx, cy = mark.radius * np.cos(mark.azimuth_rad), mark.radius * np.sin(mark.azimuth_rad)
        paint(
            *box(cx, cy, mark.azimuth_rad, mark.length, mark.width), mark.luma, mark.blue, mark.red
        )
    near = ring(0, 0.02)
    paint(near, ramp(px * (0.02 - radius[near])) * np.ones_like(x[near]), 180)
    if not scene.colour:
        cb[:], cr[:] = 0, 0
    return two_turns(luma), (two_turns(cb), two_turns(cr))
