"""How well the rate is measured in films that are less even than those of ``vision_scenes``.

    python -m tests.bench.vision_films colours|mixed [--films 20] [--first 0] [--keep DIR]

``colours``: random scenes at 15 fps, 60 s, strong H.264, with one to three marks of random hue that
the luma does not show. ``mixed``: 8 to 20 s at 10 to 120 fps and 17 to 101 rpm, with any of a
tonearm, a hand, uneven frame times, pictures dropped, lost silently or shown twice, a plate partly
outside the picture, flicker, no mark. Prints one row per film (rate error in ppm and in stated
standard deviations) and the figures over all. Films already in DIR are used again.
"""

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.bench.vision_scenes import FPS, MEAN_OVER_S, SECONDS, Clip
from tests.world.film import Recorder, Scene, film, random_scene
from tests.world.plate import PlateMotion
from tests.world.scene import colour_scene
from vision.errors import VisionError
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RPM = 2 * np.pi / 60


@dataclass(frozen=True)
class Shot:
    """What is filmed and how."""

    scene: Scene
    motion: PlateMotion
    fps: float
    seconds: float
    recorder: Recorder
    says: str = ""


def colours(seed: int) -> Shot:
    """A plate whose marks differ from it in colour only."""
    motion = Clip(seed, SECONDS, texture=False).motion
    scene = colour_scene(np.random.default_rng([seed, 12]))
    return Shot(scene, motion, FPS, SECONDS, Recorder(crf=30))


def mixed(seed: int) -> Shot:
    """Anything that may go wrong in a film of a turning plate, several things at a time."""
    rng = np.random.default_rng([seed, 77])
    scene = random_scene(rng)
    fps = float(rng.choice([10, 15, 24, 25, 29.97, 30, 50, 60, 120]))
    rpm = rng.choice([16.67, 33.3, 45, 78.26, 20.3, 60.2, 100.7]) * rng.choice([-1, 1])
    seconds = float(rng.uniform(8, 20))
    fault: dict[str, float] = {}
    if rng.random() < 0.25:
        scene = replace(scene, tonearm=True)
    if rng.random() < 0.25:
        scene = replace(scene, hand_until_s=float(rng.uniform(1, 3)))
    if rng.random() < 0.3:
        fault["jitter_s"] = float(rng.uniform(0, 0.1 / fps))
    if rng.random() < 0.25:
        fault["dropped"] = float(rng.uniform(0, 0.15))
    elif rng.random() < 0.2:
        fault["lost"] = float(rng.uniform(0, 0.03))
    if rng.random() < 0.1 and "lost" not in fault:
        fault["duplicated"] = 0.03
    if rng.random() < 0.2:
        x, y = scene.centre_px
        aside = rng.choice([-1, 1]) * scene.radius_px * rng.uniform(0.3, 0.9)
        scene = replace(scene, centre_px=(x + aside, y))
    if rng.random() < 0.3:
        scene = replace(scene, flicker=0.05, flicker_hz=float(rng.uniform(0.2, 5)))
    if rng.random() < 0.2:
        scene = replace(scene, marks=())
    wow = ((1.0, rng.uniform(0, 1e-3), rng.uniform(0, 6)),)
    motion = PlateMotion(float(rpm) * RPM, wow=wow, angle_rad=rng.uniform(0, 6))
    recorder = Recorder(crf=int(rng.choice([22, 28, 32])), **fault)
    says = f"{fps:g} fps, {rpm:g} rpm, {' '.join(fault)}"
    return Shot(scene, motion, fps, seconds, recorder, says)


KINDS: dict[str, Callable[[int], Shot]] = {"colours": colours, "mixed": mixed}


def study(kind: str, seed: int, folder: Path) -> tuple[float, float]:
    """Rate error and its stated standard deviation in ppm, NaN where refused; prints the row."""
    shot, path = KINDS[kind](seed), folder / f"{kind}_{seed:02d}.mp4"
    if not path.exists():
        half = path.with_suffix(".part.mp4")
        film(half, shot.motion, shot.scene, fps=shot.fps, seconds=shot.seconds, seed=seed,
             recorder=shot.recorder)
        half.rename(path)
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    except VisionError as error:
        print(f"{seed:3d} {shot.says:<32} {error}", flush=True)
        return np.nan, np.nan
    true = np.ptp(shot.motion.angle(np.array([0.0, MEAN_OVER_S]))) / MEAN_OVER_S
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    error_ppm = float(signed / (true * np.sign(shot.motion.rate_rad_s)) - 1) * 1e6
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    print(
        f"{seed:3d} {shot.says:<32} error {error_ppm:9.3f} ppm = {error_ppm / sd_ppm:6.2f} sd "
        f"(sd {sd_ppm:7.3f} ppm) by {track.plate.channel}  {'; '.join(rate.warnings)[:120]}",
        flush=True,
    )
    return error_ppm, sd_ppm


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--films", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="films_"))
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(options.first, options.first + options.films)
    error, sd = np.array([study(options.kind, seed, folder) for seed in seeds]).T
    seen = np.isfinite(error)
    print(f"refused {int((~seen).sum())} of {len(seeds)}")
    if seen.any():
        size, in_sd = np.abs(error[seen]), np.abs(error[seen] / sd[seen])
        print(
            f"rate error: median {np.median(size):.3f} ppm, largest {size.max():.3f} ppm\n"
            f"|error|/sd: under 2 in {(in_sd < 2).sum()} of {in_sd.size}, largest "
            f"{in_sd.max():.2f}, rms {np.sqrt((in_sd**2).mean()):.2f}"
        )


if __name__ == "__main__":
    main()
