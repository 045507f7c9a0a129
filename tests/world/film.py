"""Films a turning plate: frames at true times, encoded as H.264 with their time stamps.

Everything a recorder does wrong happens here: uneven frame times, frames dropped with true stamps
or lost silently, pictures delivered twice, a clock that runs fast.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from tests.world.picture import Picture, picture_of
from tests.world.plate import PlateMotion
from tests.world.scene import FloatArray, Scene, random_scene

__all__ = ["FilmTruth", "Recorder", "Scene", "film", "random_scene"]

TICKS_PER_S = 90_000


@dataclass(frozen=True)
class Recorder:
    """How frames become a file. Fractions are of all frames, chosen at random.

    Parameters
    ----------
    crf : int
        x264 constant rate factor; 23 is ordinary, 30 strong compression.
    jitter_s : float
        Standard deviation of the frame times; the stamps tell them truly.
    dropped : float
        Frames missing, stamps of the others true.
    lost : float
        Frames missing, the others stamped as if none were.
    stalled_s : (float, float)
        No frames between these times; the others are stamped as if none were missing.
    duplicated : float
        Frames whose picture is that of the frame before.
    camera_fps : float or None
        The camera is slower than the film: a frame shows what the camera took last.
    late_s : float
        Standard deviation of the stamps about the frame times.
    clock_ppm : float
        The recorder's clock runs fast by this much: stamps are too large.
    codec, pixel_format
        As PyAV takes them; luma is written to the first plane.
    preset : str
        How long x264 thinks about a frame.
    """

    crf: int = 28
    jitter_s: float = 0.0
    dropped: float = 0.0
    lost: float = 0.0
    stalled_s: tuple[float, float] = (0.0, 0.0)
    duplicated: float = 0.0
    camera_fps: float | None = None
    late_s: float = 0.0
    clock_ppm: float = 0.0
    codec: str = "libx264"
    pixel_format: str = "yuv420p"
    preset: str = "veryfast"


@dataclass(frozen=True, eq=False)
class FilmTruth:
    """What was filmed, frame by frame of the file.

    Attributes
    ----------
    time_s : array, shape (f,)
        True time of mid-exposure of the middle row.
    stamp_s : array, shape (f,)
        Time stamp written to the file, the first at zero.
    angle_rad : array, shape (f,)
        Plate angle at ``time_s``.
    motion : PlateMotion
    picture : Picture
        Renders the scene again, for bounds from the picture itself.
    lost_before : array of int, shape (f,)
        Frames lost silently just before this one.
    duplicate : array of bool, shape (f,)
        The picture is that of the frame before.
    """

    time_s: FloatArray
    stamp_s: FloatArray
    angle_rad: FloatArray
    motion: PlateMotion
    picture: Picture
    lost_before: NDArray[np.int64]
    duplicate: NDArray[np.bool_]


def film(
    path: Path | str,
    motion: PlateMotion,
    scene: Scene | None = None,
    *,
    fps: float = 15.0,
    seconds: float = 60.0,
    start_s: float = 0.0,
    recorder: Recorder | None = None,
    seed: int = 0,
) -> FilmTruth:
    """Film ``motion`` from ``start_s`` on and write the clip to ``path``."""
    scene, recorder = scene or Scene(), recorder or Recorder()
    rng = np.random.default_rng([seed, 2])
    n = round(seconds * fps)
    nominal = np.arange(n) / fps
    time = start_s + nominal
    if recorder.jitter_s:
        time = time + np.clip(rng.normal(0, recorder.jitter_s, n), -0.4 / fps, 0.4 / fps)
        time += max(0.0, scene.exposure_s - time[0])
    kept = rng.random(n) >= recorder.dropped + recorder.lost
    kept &= (nominal < recorder.stalled_s[0]) | (nominal >= recorder.stalled_s[1])
    kept[0] = True
    duplicate = (rng.random(n) < recorder.duplicated) & kept
    if recorder.camera_fps is not None:
        time = start_s + np.floor(nominal * recorder.camera_fps + 1e-6) / recorder.camera_fps
        duplicate |= np.diff(time, prepend=-1.0) == 0
    duplicate[0] = False
    index = np.flatnonzero(kept)
    untold = recorder.lost > 0 or recorder.stalled_s[1] > 0
    told = nominal if recorder.camera_fps is not None else time
    stamp = nominal[: index.size] if untold else told[index] - told[index[0]]
    if recorder.late_s:
        stamp = stamp + np.clip(rng.normal(0, recorder.late_s, len(stamp)), -0.4 / fps, 0.4 / fps)
    stamp = stamp * (1 + 1e-6 * recorder.clock_ppm)
    picture = picture_of(scene, seed)
    truth = FilmTruth(
        time_s=time[index],
        stamp_s=stamp,
        angle_rad=motion.angle(time[index]),
        motion=motion,
        picture=picture,
        lost_before=np.diff(index, prepend=-1) - 1 if untold else np.zeros(len(index), int),
        duplicate=duplicate[index],
    )
    _encode(path, _frames(truth, rng), truth.stamp_s, scene, fps, recorder)
    return truth


def _frames(
    truth: FilmTruth, rng: np.random.Generator
) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]]:
    """Noisy 8-bit planes (luma, cb, cr) of every frame of the file."""
    scene, motion = truth.picture.scene, truth.motion
    h, w = scene.height_px, scene.width_px
    # Drawing fresh normals for every pixel would cost more than the rendering.
    stock = rng.standard_normal((h + 256, w + 256)).astype(np.float32)
    row_delay = (np.arange(h) - (h - 1) / 2) * scene.line_time_s
    planes = None
    for time, repeat in zip(truth.time_s, truth.duplicate, strict=True):
        if planes is None or not repeat:
            rows = motion.angle(np.maximum(time + row_delay, 0.0))
            swept = float(motion.rate(np.array([time]))[0]) * scene.exposure_s
            luma = truth.picture.luma(rows, swept, time)
            luma += scene.noise * _piece(stock, (h, w), rng)
            chroma = truth.picture.chroma(rows, swept, time)
            if scene.chroma_noise:
                chroma = tuple(p + scene.chroma_noise * _piece(stock, p.shape, rng) for p in chroma)
            planes = tuple(_rounded(p) for p in (luma, *chroma))
        yield planes


def _rounded(plane: NDArray[np.float32]) -> NDArray[np.uint8]:
    np.rint(plane, out=plane)
    return np.clip(plane, 0, 255, out=plane).astype(np.uint8)


def _piece(
    stock: NDArray[np.float32], shape: tuple[int, ...], rng: np.random.Generator
) -> NDArray[np.float32]:
    i, j = rng.integers(0, 256, 2)
    return stock[i : i + shape[0], j : j + shape[1]]


def _encode(
    path: Path | str,
    frames: Iterator[tuple[NDArray[np.uint8], ...]],
    stamp_s: FloatArray,
    scene: Scene,
    fps: float,
    recorder: Recorder,
) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream(recorder.codec, rate=Fraction(fps).limit_denominator(1001))
        stream.width, stream.height = scene.width_px, scene.height_px
        stream.pix_fmt = recorder.pixel_format
        if recorder.codec == "libx264":
            # The same film, byte for byte, every time: x264's AVX-512 code for the macroblock tree
            # reads memory that nobody has written.
            stream.options = {"crf": str(recorder.crf), "preset": recorder.preset,
                              "x264-params": "asm=SSE4.2"}
        stream.codec_context.thread_count = 1
        stream.codec_context.time_base = Fraction(1, TICKS_PER_S)
        stream.time_base = Fraction(1, TICKS_PER_S)
        for planes, stamp in zip(frames, stamp_s, strict=True):
            frame = av.VideoFrame(scene.width_px, scene.height_px, "yuv420p")
            for plane, values in zip(frame.planes, planes, strict=True):
                padded = np.zeros((plane.height, plane.line_size), np.uint8)
                padded[:, : plane.width] = values
                plane.update(padded)
            if recorder.pixel_format != "yuv420p":
                frame = frame.reformat(format=recorder.pixel_format)
            frame.pts, frame.time_base = round(stamp * TICKS_PER_S), Fraction(1, TICKS_PER_S)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
