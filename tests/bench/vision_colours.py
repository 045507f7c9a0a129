"""How well the rate is measured where only marks of colour turn, as bright as the plate.

    python -m tests.bench.vision_colours [--scenes 20] [--keep DIR] [--first 0]

Random scenes like those of ``vision_scenes`` (15 fps, 60 s, strong H.264), with one to three marks
of random hue that the luma does not show. Prints one row per scene (what was followed, rate error
in ppm and in stated standard deviations) and the figures over all. Clips already in DIR are used
again.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from tests.bench.vision_scenes import MEAN_OVER_S, motion_of
from tests.world.film import Recorder, film
from tests.world.scene import colour_scene
from vision.errors import VisionError
from vision.rate import measure_rate
from vision.timebase import Timebase
from vision.track import track_phase


def colour_film(seed: int, folder: Path) -> Path:
    """Render the clip of a scene unless it is there."""
    path = folder / f"colours_{seed:02d}.mp4"
    if not path.exists():
        scene = colour_scene(np.random.default_rng([seed, 12]))
        half = path.with_suffix(".part.mp4")
        film(half, motion_of(seed), scene, seed=seed, recorder=Recorder(crf=30))
        half.rename(path)
    return path


def study(seed: int, folder: Path) -> tuple[float, float]:
    """Rate error and its stated standard deviation in ppm, NaN where refused; prints the row."""
    path, motion = colour_film(seed, folder), motion_of(seed)
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    except VisionError as error:
        print(f"{seed:3d} {error}", flush=True)
        return np.nan, np.nan
    true = np.ptp(motion.angle(np.array([0.0, MEAN_OVER_S]))) / MEAN_OVER_S
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    error_ppm = float(signed / (true * np.sign(motion.rate_rad_s)) - 1) * 1e6
    sd_ppm = rate.image_sd_rad_s / rate.rate_rad_s * 1e6
    print(
        f"{seed:3d} {track.channel:<18} error {error_ppm:9.3f} ppm = {error_ppm / sd_ppm:6.2f} sd "
        f"(sd {sd_ppm:6.3f} ppm)  {rate.diagnosis.verdict} {'; '.join(rate.warnings)[:150]}",
        flush=True,
    )
    return error_ppm, sd_ppm


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="colours_"))
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(options.first, options.first + options.scenes)
    error, sd = np.array([study(seed, folder) for seed in seeds]).T
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
