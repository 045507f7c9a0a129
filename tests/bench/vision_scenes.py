"""How well the rate is measured on rendered clips: 40 random scenes, 15 fps, 60 s, strong H.264.

    python -m tests.bench.vision_scenes [--scenes 40] [--keep DIR] [--first 0]

Prints one row per scene (rate error in ppm, in stated standard deviations, phase noise against
the bound from the picture noise) and the figures over all of them. Clips already in DIR are used
again.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from tests.world.film import FilmTruth, Recorder, film, random_scene
from tests.world.picture import Picture
from tests.world.plate import PlateMotion
from vision.errors import VisionError
from vision.rate import measure_rate
from vision.timebase import Timebase
from vision.track import track_phase

RPM = 2 * np.pi / 60
SPEEDS_RPM = (16.667, 33.333, 45.0)
NOISE_FRAMES = (100, 850, 7)


@dataclass(frozen=True)
class Row:
    """One scene."""

    seed: int
    error_ppm: float
    image_sd_ppm: float
    noise_over_bound: float
    noise_over_white_bound: float
    seconds: float
    says: str


def motion_of(seed: int) -> PlateMotion:
    """A record speed up to one per cent off, either direction, with some wow and flutter."""
    rng = np.random.default_rng([seed, 10])
    rate = rng.choice(SPEEDS_RPM) * RPM * (1 + rng.uniform(-0.01, 0.01)) * rng.choice([-1, 1])
    wow = (
        (1.0, rng.uniform(0, 1e-3), rng.uniform(0, 6.28)),
        (rng.uniform(4, 12), rng.uniform(0, 5e-4), rng.uniform(0, 6.28)),
    )
    return PlateMotion(rate, wow=wow, angle_rad=rng.uniform(0, 6.28))


def scene_film(seed: int, folder: Path) -> tuple[Path, FilmTruth | None, PlateMotion]:
    """Render the clip of a scene unless it is there."""
    path, motion = folder / f"scene_{seed:02d}.mp4", motion_of(seed)
    if path.exists():
        return path, None, motion
    scene = random_scene(np.random.default_rng([seed, 11]))
    half = path.with_suffix(".part.mp4")
    truth = film(half, motion, scene, seed=seed, recorder=Recorder(crf=30))
    half.rename(path)
    return path, truth, motion


def phase_bounds(path: Path, seed: int, motion: PlateMotion, fps: float = 15.0) -> list[float]:
    """Smallest possible angle noise in rad, from the noise of this clip's own pictures.

    With e the decoded picture less the noise-free rendering and g its change with angle, a filter
    that knew the noise-free picture would be off by Σge/Σg². First its scatter over the pictures,
    one and two waves per turn taken off as in the measurement: the noise as it is. Second what it
    would be if the errors of neighbouring pixels had nothing to do with each other, √Σg²e²/Σg²,
    which compression does not grant.
    """
    scene = random_scene(np.random.default_rng([seed, 11]))
    picture = Picture(scene, seed)
    swept = abs(motion.rate_rad_s) * scene.exposure_s
    rows = (np.arange(scene.height_px) - (scene.height_px - 1) / 2) * scene.line_time_s
    capture, step = cv2.VideoCapture(str(path)), 1e-3
    times, off, white = [], [], []
    wanted = set(range(*NOISE_FRAMES))
    for index in range(max(wanted) + 1):
        ok, decoded = capture.read()
        assert ok
        if index not in wanted:
            continue
        at = index / fps
        luma = cv2.cvtColor(decoded, cv2.COLOR_BGR2YUV)[:, :, 0].astype(float)
        angle = motion.angle(at + rows)
        ahead, clean, behind = (
            picture.luma(angle + s, swept, at).astype(float) for s in (step, 0.0, -step)
        )
        g = (ahead - behind) / (2 * step)
        # The decoder's colours are full range, the rendering is in limited range.
        e = luma * 219 / 255 + 16 - clean
        times.append(at)
        off.append((g * e).sum() / (g**2).sum())
        white.append(np.sqrt((g**2 * e**2).sum()) / (g**2).sum())
    time, off = np.array(times), np.array(off)
    angle = motion.angle(time)
    waves = [np.ones_like(time), time]
    waves += [f(k * angle) for k in (1, 2) for f in (np.cos, np.sin)]
    x = np.stack(waves, axis=1)
    left = off - x @ np.linalg.lstsq(x, off)[0]
    return [float(np.sqrt((left**2).sum() / (len(time) - x.shape[1]))), float(np.mean(white))]


def study(seed: int, folder: Path) -> Row:
    """Film, measure, compare."""
    path, _, motion = scene_film(seed, folder)
    start = time.perf_counter()
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    except VisionError as error:
        return Row(seed, *[np.nan] * 4, time.perf_counter() - start, str(error))
    seconds = time.perf_counter() - start
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    line = measure_rate(
        track, timebase=Timebase(ppm=0.0), model=("constant_rate", "once_per_rev", "twice_per_rev")
    )
    return Row(
        seed,
        (signed / motion.rate_rad_s - 1) * 1e6,
        rate.image_sd_rad_s / rate.rate_rad_s * 1e6,
        *(line.phase_rms_rad / bound for bound in phase_bounds(path, seed, motion)),
        seconds,
        f"{rate.diagnosis.verdict} {rate.diagnosis.name or ''} {'; '.join(rate.warnings)}",
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="scenes_"))
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in range(options.first, options.first + options.scenes):
        row = study(seed, folder)
        rows.append(row)
        print(
            f"{row.seed:3d} error {row.error_ppm:9.3f} ppm = "
            f"{row.error_ppm / row.image_sd_ppm:6.2f} sd (sd {row.image_sd_ppm:6.3f} ppm), phase "
            f"noise {row.noise_over_bound:5.2f} x bound "
            f"({row.noise_over_white_bound:5.2f} x white), "
            f"{row.seconds:5.2f} s  {row.says[:150]}",
            flush=True,
        )
    error = np.abs([row.error_ppm for row in rows])
    in_sd = error / np.array([row.image_sd_ppm for row in rows])
    bound = np.array([row.noise_over_bound for row in rows])
    refused = int(np.isnan(error).sum())
    print(f"refused {refused} of {len(rows)}")
    if refused < len(rows):
        print(
            f"rate error: median {np.nanmedian(error):.3f} ppm, largest {np.nanmax(error):.3f} ppm"
        )
        print(f"|error|/sd under 2: {np.nanmean(in_sd[np.isfinite(in_sd)] < 2):.1%}")
        print(
            f"phase noise/bound: median {np.nanmedian(bound):.2f}, largest {np.nanmax(bound):.2f}"
        )


if __name__ == "__main__":
    main()
