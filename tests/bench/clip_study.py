"""How well the rate is measured on clips as people film them, by category.

    python -m tests.bench.clip_study [--clips 3] [--first 1000] [--only hand_held,bump] [--keep DIR]

Prints one row per clip, then for each category: clips measured, within two stated sds of the truth,
beyond four, and measurable clips that were refused. The sd is that of ``pipeline rate`` without the
clock's share, since the clock of these clips is exact. Clips already in DIR are used again.
Development uses seeds from 1000 on; figures are reported from seeds that were never looked at.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from tests.bench.hard_clips.footage import Shot, write
from tests.bench.hard_clips.shots import CATEGORIES, shot
from vision.errors import VisionError
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RPM = 2 * np.pi / 60


def file_of(clip: Shot, name: str, folder: Path) -> Path:
    """The rendered clip."""
    path = folder / f"{name}_{clip.seed}{clip.suffix}"
    if not path.exists():
        half = path.with_name(f"part_{path.name}")
        write(clip, half)
        half.rename(path)
    return path


def study(clip: Shot, path: Path) -> tuple[float, float]:
    """Rate error and stated sd in ppm, NaN where refused; prints the row."""
    head = f"{path.stem:<24}"
    start = time.perf_counter()
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0), nominal_rpm=clip.nominal_rpm)
    except VisionError as error:
        print(f"{head} refused ({time.perf_counter() - start:.1f} s): {error}", flush=True)
        return np.nan, np.nan
    lasts = time.perf_counter() - start
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    error_ppm = (signed / clip.rate_rad_s - 1) * 1e6 if clip.rate_rad_s else np.inf
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    print(f"{head} {error_ppm:10.1f} ppm ± {sd_ppm:9.1f} = {error_ppm / sd_ppm:6.2f} sd "
          f"({lasts:.1f} s)  {' | '.join(w[:110] for w in rate.warnings)}", flush=True)
    return error_ppm, sd_ppm


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", type=int, default=3)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--only", default=",".join(CATEGORIES))
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="clips_"))
    folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for name in options.only.split(","):
        for seed in range(options.first, options.first + options.clips):
            clip = shot(name, seed)
            rows[name].append(study(clip, file_of(clip, name, folder)))
    print(f"{'category':<16} clips measured within-2-sd beyond-4-sd refused median-ppm median-sd")
    everything = [row for each in rows.values() for row in each]
    for name, each in (*rows.items(), ("all", everything)):
        error, sd = np.array(each).T
        seen = np.isfinite(sd)
        off = np.abs(error[seen] / sd[seen])
        middle = [f"{np.median(v):10.1f}" if v.size else f"{'-':>10}"
                  for v in (np.abs(error[seen]), sd[seen])]
        print(f"{name:<16} {len(each):5d} {seen.sum():8d} {(off < 2).sum():11d} "
              f"{(off > 4).sum():11d} {(~seen).sum():7d} {' '.join(middle)}")


if __name__ == "__main__":
    main()
