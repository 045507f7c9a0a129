"""A shot as frames in a file."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from tests.bench.hard_clips.art import MARGIN, disc, streak, table
from tests.bench.hard_clips.stage import Camera, disc_box, disc_to_frame, table_to_frame

Light = NDArray[np.float32]

TICKS = 90_000
TABLE_PIXELS = 1400
SMEAR_PX = 2.0  #: of motion between two moments of an exposure
MOST_MOMENTS = 9
MAINS_HZ = 100.0
INNER_RADIUS = 0.45  #: radii


def _even(rate: float) -> Callable[[float], float]:
    return lambda time_s: rate * time_s


@dataclass(frozen=True)
class Shot:
    """What is filmed, how, and what is true of it.

    Parameters
    ----------
    rate_rad_s : float or None
        None where no rate can be measured.
    angle : callable
        Plate angle in rad against time in s.
    exposure : callable
        Seconds against time; the stamp of a frame is the start of its exposure.
    light : callable
        Of the lamp and the camera's gain together, against time; 1 is ordinary.
    camera_fps : float
        Of a camera slower than the clip, whose recorder repeats frames; 0 takes them all.
    inner_share : float
        Of the plate's rate, at which the inner part of the disc turns; 0 with the rest.
    """

    category: str
    seed: int
    rate_rad_s: float | None
    angle: Callable[[float], float]
    seconds: float = 10.0
    fps: float = 25.0
    disc: str = "mark"
    camera: Camera = field(default_factory=Camera)
    exposure: Callable[[float], float] = lambda time_s: 1 / 100
    light: Callable[[float], float] = lambda time_s: 1.0
    noise: float = 0.004
    off_centre: float = 0.0
    wobble_rad: float = 0.0
    streak: float = 0.0
    flicker: float = 0.0
    line_s: float = 0.0
    distortion: float = 0.0
    defocus_px: float = 0.0
    bare: bool = False
    hidden: float = 0.0
    interlaced: bool = False
    inset: float = 0.0
    jitter_s: float = 0.0
    dropped: float = 0.0
    lost: float = 0.0
    repeated: float = 0.0
    codec: str = "libx264"
    suffix: str = ".mp4"
    crf: int = 24
    bit_rate: int = 0
    nominal_rpm: float | None = None
    camera_fps: float = 0.0
    inner_share: float = 0.0


class _Film:
    """Renders moments of a shot."""

    def __init__(self, shot: Shot) -> None:
        rng = np.random.default_rng([shot.seed, 3])
        self._shot = shot
        self._side = int(2.4 * MARGIN * shot.camera.radius_px)
        drawn = disc(shot.disc, self._side, rng, shot.off_centre)
        self._disc = [np.ascontiguousarray(drawn[..., i]) for i in range(3 if shot.streak else 2)]
        y, x = (np.mgrid[: self._side, : self._side] - (self._side - 1) / 2) * 2 * MARGIN
        self._inner = np.asarray(np.hypot(x, y) < INNER_RADIUS * self._side, np.float32)
        self._streak = streak(self._side, rng.uniform(0, 3), 0.12, shot.streak)
        self._table = table(TABLE_PIXELS, rng, bare=shot.bare)
        self._rng = rng
        self._still: _Still | None = None
        w, h = shot.camera.size_px
        y, x = np.mgrid[:h, :w].astype(np.float32)
        x0, y0, size = w / 2, h / 2, w / 2
        bend = 1 + shot.distortion * (((x - x0) ** 2 + (y - y0) ** 2) / size**2)
        self._lens = (x0 + (x - x0) * bend, y0 + (y - y0) * bend)
        self._noise = rng.standard_normal((h + 64, w + 64)).astype(np.float32)

    def frame(self, time_s: float) -> NDArray[np.uint8]:
        """Luma (h, w) of the frame whose exposure begins at a time."""
        shot = self._shot
        exposure = shot.exposure(time_s)
        swept = abs(shot.angle(time_s + exposure) - shot.angle(time_s)) * shot.camera.radius_px
        moments = int(np.clip(np.ceil(swept / SMEAR_PX), 1, MOST_MOMENTS))
        at = time_s + exposure * (np.arange(moments) + 0.5) / moments
        w, h = shot.camera.size_px
        light = np.zeros((h, w), np.float32)
        for moment_s in at:
            self._add_moment(float(moment_s), light)
        light *= np.float32(shot.light(time_s) / moments)
        if shot.flicker:
            row_s = time_s + exposure / 2 + np.arange(h) * shot.line_s
            depth = shot.flicker * np.sinc(MAINS_HZ * exposure)
            light = light * (1 + depth * np.sin(2 * np.pi * MAINS_HZ * row_s))[:, None]
        if shot.distortion:
            light = cv2.remap(light, *self._lens, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if shot.defocus_px:
            light = cv2.GaussianBlur(light, (0, 0), shot.defocus_px)
        if shot.hidden:
            wide = int(w / 2 + shot.camera.aim_px[0] + shot.camera.radius_px * (1 - shot.hidden))
            light = np.array(light)
            light[:, wide:] = 0.2
        i, j = self._rng.integers(0, 64, 2)
        grain = self._noise[i : i + h, j : j + w] * self._rng.choice([-1, 1])
        # Read noise, and that of the light's own grains.
        variance = shot.noise**2 + 0.02 * shot.noise * np.maximum(light, 0)
        light = np.asarray(light + grain * np.sqrt(variance), np.float32)
        luma = 16 + 219 * np.asarray(cv2.pow(np.clip(light, 0, 1), 1 / 2.2))
        return np.rint(luma).astype(np.uint8)

    def _add_moment(self, time_s: float, light: Light) -> None:
        """Add the light of a moment."""
        shot = self._shot
        view = shot.camera.view(time_s) if shot.camera.moves else None
        if self._still is None or (view is not None and (view != self._still.view).any()):
            self._still = self._what_stands(shot.camera.view(time_s))
        still = self._still
        turned = disc_to_frame(
            still.view, self._side, MARGIN, shot.angle(time_s), shot.wobble_rad)
        (rows, columns), size = still.box, still.mirrored.shape[::-1]
        onto_box = np.array([[1, 0, -columns.start], [0, 1, -rows.start], [0, 0, 1.0]]) @ turned
        surface, there, *grooves = (cv2.warpPerspective(d, onto_box, size) for d in self._disc)
        light += still.table
        light[still.box] += surface - there * still.table[still.box]
        for each in grooves:
            light[still.box] += still.mirrored * each
        if shot.inner_share:
            inner = onto_box @ np.linalg.inv(turned) @ disc_to_frame(
                still.view, self._side, MARGIN, shot.inner_share * shot.angle(time_s),
                shot.wobble_rad)
            label, within = (cv2.warpPerspective(d, inner, size)
                             for d in (self._disc[0] * self._inner, self._inner))
            light[still.box] += label - within * (surface - there * still.table[still.box]
                                                  + still.table[still.box])

    def _what_stands(self, view: NDArray[np.float64]) -> "_Still":
        shot, size = self._shot, self._shot.camera.size_px
        on_table = table_to_frame(view, TABLE_PIXELS)
        table_light = cv2.warpPerspective(
            self._table, on_table, size, borderMode=cv2.BORDER_REPLICATE)
        at_rest = disc_to_frame(view, self._side, MARGIN, 0.0, 0.0)
        mirrored = cv2.warpPerspective(self._streak, at_rest, size)
        box = disc_box(view, size, MARGIN, shot.wobble_rad)
        return _Still(view, np.asarray(table_light), np.asarray(mirrored)[box], box)


@dataclass(frozen=True, eq=False)
class _Still:
    """What does not turn, before a camera: the table, and in the disc's box what it mirrors."""

    view: NDArray[np.float64]
    table: Light
    mirrored: Light
    box: tuple[slice, slice]


def write(shot: Shot, path: Path) -> None:
    """Render a shot into a file."""
    film = _Film(shot)
    rng = np.random.default_rng([shot.seed, 4])
    count = round(shot.seconds * shot.fps)
    time_s = np.arange(count) / shot.fps
    if shot.jitter_s:
        time_s = time_s + np.clip(rng.normal(0, shot.jitter_s, count), -0.4 / shot.fps,
                                  0.4 / shot.fps) + 0.4 / shot.fps
    kept = rng.random(count) >= shot.dropped + shot.lost
    again = rng.random(count) < shot.repeated
    if shot.camera_fps:
        number = np.floor(time_s * shot.camera_fps + 1e-6)
        again = np.diff(number, prepend=-1) == 0
        time_s = number / shot.camera_fps
    uneven = not (shot.lost or shot.camera_fps)
    stamps = time_s[kept] if uneven else np.arange(kept.sum()) / shot.fps
    _encode(shot, path, _frames(shot, film, time_s[kept], again[kept]), stamps)


def _frames(
    shot: Shot, film: _Film, time_s: NDArray[np.float64], again: NDArray[np.bool_]
) -> Iterator[NDArray[np.uint8]]:
    luma = film.frame(float(time_s[0]))
    for time, repeat in zip(time_s, again, strict=True):
        if not repeat:
            luma = film.frame(float(time))
            if shot.interlaced:
                later = film.frame(float(time) + 0.5 / shot.fps)
                luma[1::2] = later[1::2]
        yield _inset(luma, shot.inset) if shot.inset else luma


def _inset(luma: NDArray[np.uint8], share: float) -> NDArray[np.uint8]:
    """The frame small in the corner of another one."""
    h, w = luma.shape
    y, x = np.mgrid[:h, :w]
    outer = (90 + 40 * np.sin(x / 37.0) * np.cos(y / 23.0)).astype(np.uint8)
    small = cv2.resize(luma, (int(w * share), int(h * share)), interpolation=cv2.INTER_AREA)
    outer[20 : 20 + small.shape[0], w - 24 - small.shape[1] : w - 24] = small
    return outer


def _encode(
    shot: Shot, path: Path, frames: Iterator[NDArray[np.uint8]], stamps: NDArray[np.float64]
) -> None:
    w, h = shot.camera.size_px
    with av.open(str(path), "w") as container:
        stream = container.add_stream(shot.codec, rate=Fraction(shot.fps).limit_denominator(1001))
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height = w, h
        stream.pix_fmt = "yuvj420p" if shot.codec == "mjpeg" else "yuv420p"
        stream.codec_context.thread_count = 1
        if shot.codec == "libx264":
            stream.options = {"preset": "veryfast", "x264-params": "asm=SSE4.2"}
            if shot.bit_rate:
                stream.bit_rate = shot.bit_rate
            else:
                stream.options = {**stream.options, "crf": str(shot.crf)}
            if shot.interlaced:
                parameters = "asm=SSE4.2:tff=1"
                stream.options = {**stream.options, "x264-params": parameters}
        ticks = TICKS if shot.codec == "libx264" else round(shot.fps * 1000)
        stream.time_base = stream.codec_context.time_base = Fraction(1, ticks)
        if shot.codec == "mjpeg" and shot.suffix == ".avi":
            ticks = round(shot.fps)
            stream.time_base = stream.codec_context.time_base = Fraction(1, ticks)
        for luma, stamp in zip(frames, stamps, strict=True):
            frame = av.VideoFrame(w, h, "yuv420p")
            grey = np.full((h // 2, w // 2), 128, np.uint8)
            for plane, values in zip(frame.planes, (luma, grey, grey), strict=True):
                padded = np.zeros((plane.height, plane.line_size), np.uint8)
                padded[:, : plane.width] = values
                plane.update(padded)
            if shot.codec == "mjpeg":
                frame = frame.reformat(format="yuvj420p")
            frame.pts, frame.time_base = round(stamp * ticks), Fraction(1, ticks)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
