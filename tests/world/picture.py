"""The picture of a scene of the simulated bench at a given plate angle.

The reflectance of the plate is kept as a polar image, in which turning is a shift along the rows:
each pixel's place on the plate is computed once from the true perspective of a pinhole camera, and
a frame is one look-up at (radius, azimuth - θ) in the rectangle that holds the plate. Nothing is
resampled twice and nothing is rotated in pixels. Exposure averages the polar image over the angle
swept; a rolling shutter gives each picture row its own θ.

Every edge is drawn from its signed distance with a ramp one picture pixel wide (the blur of an
ordinary lens) and every pixel averages 2 x 2 samples, so that edges move by exact fractions of a
pixel.
"""

from functools import lru_cache

import cv2
import numpy as np

from tests.world.polar_plate import AZIMUTHS, Image, Samples, polar_plate, ramp, two_turns
from tests.world.scene import FloatArray, Scene, homography

OVERSAMPLING = 2
ALIGNED = 16  # pixels: what OpenCV adds up at once, so that a part is as exact as the whole
HAND_LUMA, HAND_CHROMA = 165.0, (-12.0, 20.0)


@lru_cache(maxsize=4)
def picture_of(scene: Scene, seed: int = 0) -> "Picture":
    """The picture of a scene; many clips show the same."""
    return Picture(scene, seed)


class Picture:
    """Renders ``scene`` at given plate angles: luma (h, w) and chroma (h/2, w/2), without noise.

    The chroma of a scene without coloured marks is only for the eye: sharp, and in even light.
    """

    def __init__(self, scene: Scene, seed: int = 0) -> None:
        self.scene = scene
        rng = np.random.default_rng([seed, 1])
        h, w = scene.height_px, scene.width_px
        luma, self._chroma_plate = polar_plate(scene, rng)
        radius, azimuth = _place_on_plate(scene, h, w, OVERSAMPLING)
        inside = ramp((1.0 - radius) * scene.radius_px * OVERSAMPLING / 2)
        cover = _average(inside)
        self._part, fine = _part_inside(inside, OVERSAMPLING)
        self._samples = Samples(scene, radius[fine], azimuth[fine])
        self._inside, cover_part = inside[fine], cover[self._part]
        radius, azimuth = _place_on_plate(scene, h // 2, w // 2, 1)
        inside = ramp((1.0 - radius) * scene.radius_px / 2)
        self._part_c, _ = _part_inside(inside, 1)
        self._samples_c = Samples(scene, radius[self._part_c], azimuth[self._part_c])
        self._inside_c = inside[self._part_c]
        deck = _deck(scene, rng)
        self._shade, glare = _light(scene)
        self._glare = glare * cover
        self._arm = _tonearm(scene) if scene.tonearm else None
        # What stands still is lit once; in the part of the plate its share under the plate's.
        self._rest = self._lit(deck, (slice(None), slice(None)))
        self._deck_part = (1 - cover_part) * deck[self._part]
        seen = (luma, *(self._chroma_plate if scene.coloured_marks else ()))
        self._spectra = [np.fft.rfft(plane[:, :AZIMUTHS], axis=1) for plane in seen]
        self._blurred: dict[float, tuple[Image, ...]] = {}

    def luma(self, angle_by_row: FloatArray, swept_rad: float, time_s: float = 0.0) -> Image:
        """Luma at the plate angle of each picture row (h,), blurred over ``swept_rad``."""
        scene = self.scene
        part = self._part
        rows = np.repeat(angle_by_row[part[0]], OVERSAMPLING).astype(np.float64)
        plate = self._samples.look_up(self._blur(abs(swept_rad))[0], rows)
        plate *= self._inside
        picture = self._rest.copy()
        picture[part] = self._lit(_average(plate) + self._deck_part, part)
        if time_s < scene.hand_until_s:
            hand = _hand(scene, time_s)
            picture = np.asarray(picture * (1 - hand) + HAND_LUMA * hand, np.float32)
        gain = self._gain(time_s)
        picture -= 16
        if gain != 1:
            return (picture * gain + 16).astype(np.float32)
        picture += 16
        return picture

    def chroma(
        self, angle_by_row: FloatArray, swept_rad: float, time_s: float = 0.0
    ) -> tuple[Image, Image]:
        """Both chroma planes, seen as :meth:`luma` is."""
        scene = self.scene
        part = self._part_c
        rows = angle_by_row[::2][: scene.height_px // 2][part[0]]
        planes = self._blur(abs(swept_rad))[1:] if scene.coloured_marks else self._chroma_plate
        cb, cr = np.zeros((2, scene.height_px // 2, scene.width_px // 2), np.float32)
        for whole, plane in zip((cb, cr), planes, strict=True):
            whole[part] = self._inside_c * self._samples_c.look_up(plane, rows)
        if scene.coloured_marks:
            shown = _halved(self._shade) * self._gain(time_s)
            if self._arm is not None:
                shown = shown * _halved(1 - self._arm)
            cb, cr = cb * shown, cr * shown
            if time_s < scene.hand_until_s:
                cover = _halved(_hand(scene, time_s))
                cb, cr = (
                    plane * (1 - cover) + skin * cover
                    for plane, skin in zip((cb, cr), HAND_CHROMA, strict=True)
                )
        return (128 + cb).astype(np.float32), (128 + cr).astype(np.float32)

    def _lit(self, picture: Image, part: tuple[slice, slice]) -> Image:
        """A part of the picture behind the tonearm, in the light of the room."""
        if self._arm is not None:
            arm = self._arm[part]
            picture = picture * (1 - arm) + 150.0 * arm
        return (picture - 16) * self._shade[part] + 16 + self._glare[part]

    def _gain(self, time_s: float) -> np.float64:
        """How bright the light is."""
        scene = self.scene
        wave = np.sin(2 * np.pi * scene.flicker_hz * time_s)
        return np.float64(scene.light * (1 + scene.flicker * wave))

    def _blur(self, swept_rad: float) -> tuple[Image, ...]:
        """The polar images averaged over the exposure, width rounded to 1/4 column.

        Luma, and where marks are coloured both chroma planes.
        """
        columns = round(swept_rad * AZIMUTHS / (2 * np.pi) * 4) / 4
        if columns not in self._blurred:
            self._blurred.clear()
            half = np.arange(AZIMUTHS // 2 + 1)
            transfer = np.sinc(half * columns / AZIMUTHS)
            self._blurred[columns] = tuple(
                two_turns(np.fft.irfft(spectrum * transfer, AZIMUTHS, axis=1))
                for spectrum in self._spectra
            )
        return self._blurred[columns]


def _average(samples: Image) -> Image:
    """Mean of the samples of each pixel."""
    h, w = samples.shape
    return cv2.resize(samples, (w // OVERSAMPLING, h // OVERSAMPLING), interpolation=cv2.INTER_AREA)


def _part_inside(inside: Image, over: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """The rectangle of pixels that hold the plate, and the same of their ``over`` samples."""
    part = []
    for axis in (1, 0):
        seen = np.flatnonzero(inside.any(axis=axis))
        first, last = int(seen[0]) // over, int(seen[-1]) // over
        part.append((first // ALIGNED * ALIGNED, -(-(last + 1) // ALIGNED) * ALIGNED))
    rows, columns = (slice(*each) for each in part)
    fine = tuple(slice(a * over, b * over) for a, b in part)
    return (rows, columns), (fine[0], fine[1])


def _halved(plane: FloatArray) -> Image:
    h, w = plane.shape
    small = cv2.resize(plane, (w // 2, h // 2), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32)


def _place_on_plate(scene: Scene, h: int, w: int, over: int) -> tuple[Image, Image]:
    """Radius (radii) and azimuth (columns of the polar image) of every sample."""
    scale = scene.width_px / w
    y, x = np.mgrid[: h * over, : w * over].astype(float)
    # Pixel centres are whole numbers.
    x, y = ((x + 0.5) / over) * scale - 0.5, ((y + 0.5) / over) * scale - 0.5
    back = np.linalg.inv(homography(scene))
    u, v, n = (back[i, 0] * x + back[i, 1] * y + back[i, 2] for i in range(3))
    u, v = u / n, v / n
    azimuth = np.mod(np.arctan2(v, u), 2 * np.pi) * AZIMUTHS / (2 * np.pi)
    return np.hypot(u, v).astype(np.float32), azimuth.astype(np.float32)


def _deck(scene: Scene, rng: np.random.Generator) -> Image:
    """The fixed surroundings, with grain, and the fixed mark just outside the plate."""
    h, w = scene.height_px, scene.width_px
    grain = cv2.GaussianBlur(rng.standard_normal((h, w)), (0, 0), 2.0)
    deck = scene.deck_luma + 3.0 * grain / grain.std()
    if scene.deck_mark_azimuth_rad is not None:
        x, y = (np.mgrid[:h, :w][::-1]).astype(float)
        back = np.linalg.inv(homography(scene))
        u, v, n = (back[i, 0] * x + back[i, 1] * y + back[i, 2] for i in range(3))
        a = scene.deck_mark_azimuth_rad
        along = (u * np.cos(a) + v * np.sin(a)) / n - 1.08
        across = (-u * np.sin(a) + v * np.cos(a)) / n
        inside = ramp(scene.radius_px * (0.055 - np.abs(along))) * ramp(
            scene.radius_px * (0.03 - np.abs(across))
        )
        deck = deck + inside * (215 - deck)
    return np.asarray(deck, np.float32)


def _light(scene: Scene) -> tuple[Image, Image]:
    """Relative illumination, and the highlight that the glossy plate adds; both stand still."""
    y, x = np.mgrid[: scene.height_px, : scene.width_px].astype(float)
    shade = 1 - scene.shading * (x / scene.width_px + y / scene.height_px) / 2
    cx, cy, r = *scene.centre_px, scene.radius_px
    spot = ((x - cx - 0.5 * r) / (0.3 * r)) ** 2 + ((y - cy + 0.3 * r) / (0.13 * r)) ** 2
    return shade.astype(np.float32), (scene.glare * np.exp(-spot / 2)).astype(np.float32)


def _tonearm(scene: Scene) -> Image:
    """Coverage of a bar from the upper right over the plate."""
    y, x = np.mgrid[: scene.height_px, : scene.width_px].astype(float)
    cx, cy, r = *scene.centre_px, scene.radius_px
    foot, tip = np.array([cx + 1.15 * r, cy - 0.9 * r]), np.array([cx + 0.5 * r, cy + 0.25 * r])
    along = (tip - foot) / np.linalg.norm(tip - foot)
    s = np.clip((x - foot[0]) * along[0] + (y - foot[1]) * along[1], 0, np.linalg.norm(tip - foot))
    return ramp(0.035 * r - np.hypot(x - foot[0] - s * along[0], y - foot[1] - s * along[1]))


def _hand(scene: Scene, time_s: float) -> Image:
    """Coverage of a hand that lies on the rim and draws back."""
    y, x = np.ogrid[: scene.height_px, : scene.width_px]
    cx, cy, r = *scene.centre_px, scene.radius_px
    away = max(0.0, time_s / scene.hand_until_s - 0.3) * 1.2
    px, py = cx + (0.95 + away) * r, cy + (0.35 + 0.2 * np.sin(3 * time_s)) * r
    return ramp(0.02 * r * (1 - ((x - px) / (0.4 * r)) ** 2 - ((y - py) / (0.25 * r)) ** 2) * 20)
