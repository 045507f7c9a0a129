"""What halving and doubling a threshold does on clips whose camera or whose fields move.

    python -m tests.bench.moving_thresholds [--clips 2] [--first 1000] [--only MODULE[.NAME]]
                                            [--categories hand_held,bump] [--keep DIR]

The modules are those that the clips of ``threshold_sensitivity`` do not touch: registration,
fields, the motion of the camera, whether anything moves, the smallest area that does, two outlines
of one rim, the inertia of a plate whose mark leaves the frame, frames that show no angle, the
orders that look standing, plates of equal parts. The clips are those of ``clip_study``, by default
of the categories below;
clips already in DIR are used again.
"""

import argparse
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from tests.bench.clip_study import file_of
from tests.bench.hard_clips.footage import Shot
from tests.bench.hard_clips.shots import shot
from tests.bench.threshold_sensitivity import Outcome, print_effects, summary
from vision.errors import VisionError
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

CATEGORIES = ("plain", "hand_held", "bump", "interlaced", "dark", "small")
#: Modules of ``vision`` whose constants are of interest here, or one constant of them.
HOMES = ("tracking.registration", "plate.fields", "plate.evidence", "plate.inertia",
         "plate.template", "tracking.tracker.SHOWN")


def outcome(clip: Shot, path: Path) -> Outcome:
    """Measure a clip and compare with the truth."""
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0), nominal_rpm=clip.nominal_rpm)
    except VisionError:
        return Outcome(path.stem, np.nan, np.nan)
    assert clip.rate_rad_s is not None
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    stated = " ".join(sorted(text[:40] for text in rate.warnings))
    return Outcome(path.stem, (signed / clip.rate_rad_s - 1) * 1e6, sd_ppm, True, stated)


def outcomes(clips: list[tuple[Shot, Path]]) -> list[Outcome]:
    """All clips with the thresholds as they stand."""
    return [outcome(clip, path) for clip, path in clips]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", type=int, default=2)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--only", default="")
    parser.add_argument("--categories", default=",".join(CATEGORIES))
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="clips_"))
    folder.mkdir(parents=True, exist_ok=True)
    shots = [(name, shot(name, seed)) for name in options.categories.split(",")
             for seed in range(options.first, options.first + options.clips)]
    clips = [(clip, file_of(clip, name, folder)) for name, clip in shots]
    print(summary(outcomes(clips)), flush=True)
    for home in [options.only] if options.only else HOMES:
        print_effects(home, partial(outcomes, clips))


if __name__ == "__main__":
    main()
