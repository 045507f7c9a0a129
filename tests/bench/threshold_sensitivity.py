"""What halving and doubling each threshold changes.

    python -m tests.bench.threshold_sensitivity vision.plate|vision.tracking|vision.rate
                                                [--only MODULE[.NAME]] [--keep DIR]

One constant at a time (``--only plate.detect.SAME``) is multiplied by a half and by two, and the
clips below are measured again: for ``vision.rate`` from phase tracks that are made once, for the
others from the frames. Printed per value: measurable clips that are refused, clips without a rate
that get one, the error in ppm (median, largest) and in stated standard deviations (largest), and
the clips of which anything changes, also the marks, the symmetry and the warnings. Another set of
cases is another function for :func:`sensitivity`.
"""

import argparse
import dataclasses
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.bench.threshold_records import FACTORS, with_factors
from tests.bench.vision_films import Shot
from tests.source_tree import begins
from tests.thresholds import Threshold, thresholds, written
from tests.vision.edited_clips import again
from tests.world.film import Recorder, Scene, film
from tests.world.plate import PlateMotion
from tests.world.scene import Mark
from vision.errors import VisionError
from vision.phase_track import PhaseTrack
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RPM = 2 * np.pi / 60
MEAN_OVER_S = 3000.0
SAME_PPM, SAME_SD = 1e-6, 1e-6  # smaller changes are rounding
STRONG = Recorder(crf=30)
ROLLING, ROLL_DEG_PER_FRAME = "rolling camera", 0.1 / 15
RED = Mark(luma=Scene().plate_luma, blue=-10.0, red=50.0)


@dataclass(frozen=True)
class Outcome:
    """What became of one case: the error and its stated sd in ppm, NaN where it was refused."""

    name: str
    error_ppm: float
    sd_ppm: float
    measurable: bool = True
    stated: str = ""  # besides the rate: marks, symmetry, warnings

    @property
    def refused(self) -> bool:
        """No rate is stated."""
        return bool(np.isnan(self.error_ppm))

    def same_as(self, other: "Outcome") -> bool:
        """The same rate with the same sd, or both refused."""
        if self.refused or other.refused:
            return self.refused == other.refused
        return (abs(self.error_ppm - other.error_ppm) < SAME_PPM
                and abs(self.sd_ppm - other.sd_ppm) < SAME_SD * self.sd_ppm
                and self.stated == other.stated)


@dataclass(frozen=True)
class Effect:
    """What one value of one threshold does."""

    path: str
    value: Any
    factor: float
    outcomes: tuple[Outcome, ...]
    changed: tuple[str, ...]

    def __str__(self) -> str:
        if not self.outcomes:
            return "not a possible value"
        if not self.changed:
            return "no effect"
        return f"{summary(self.outcomes)}; changed: {', '.join(self.changed)}"

    @property
    def in_short(self) -> str:
        """For a cell of a table."""
        if not self.outcomes or not self.changed:
            return str(self)
        return f"{len(self.changed)} clips change: {summary(self.outcomes)}"


Measure = Callable[[], Sequence[Outcome]]


def summary(outcomes: Sequence[Outcome]) -> str:
    """Refusals and errors of some outcomes."""
    refused = sum(each.refused for each in outcomes if each.measurable)
    wrong = sum(not each.refused for each in outcomes if not each.measurable)
    measured = [each for each in outcomes if each.measurable and not each.refused]
    error = np.abs([each.error_ppm for each in measured] or [np.nan])
    in_sd = np.abs([each.error_ppm / each.sd_ppm for each in measured] or [np.nan])
    return (f"refused {refused}, wrongly measured {wrong}, median {np.median(error):.2f} ppm, "
            f"worst {error.max():.1f} ppm, {in_sd.max():.2f} sd")


def table(constants: Sequence[Threshold], effects: Sequence[Effect]) -> str:
    """A table of constants, in Markdown."""
    lines = ["| threshold | value | unit, origin | × 0.5 | × 2 |", "|---|---|---|---|---|"]
    for one in constants:
        by_factor = [each.in_short for each in effects if each.path == one.path]
        if by_factor:
            lines.append(f"| {' | '.join((*one.cells, *by_factor))} |")
    return "\n".join(lines)


def sensitivity(constants: Sequence[Threshold], measure: Measure) -> Iterator[Effect]:
    """The effect of each factor on each constant of ``vision``, one changed at a time.

    Parameters
    ----------
    constants : sequence of Threshold
    measure : callable
        Measures all cases with the thresholds as they stand.
    """
    usual = {each.name: each for each in measure()}
    for one in constants:
        for factor, outcomes in zip(FACTORS, with_factors("vision", one, measure), strict=True):
            others = tuple(o.name for o in outcomes or () if not o.same_as(usual[o.name]))
            yield Effect(one.path, one.value, factor, tuple(outcomes or ()), others)


def print_effects(home: str, measure: Measure) -> None:
    """The effects of the constants of a module of ``vision``, or of one, as they are measured."""
    constants = [one for one in thresholds("vision") if begins(one.path, home)]
    effects = []
    for effect in sensitivity(constants, measure):
        effects.append(effect)
        print(f"{effect.path} = {written(effect.value)} x {effect.factor:g}: {effect}", flush=True)
    if effects:
        print(f"\n{table(constants, effects)}\n", flush=True)


def rolled(index: int, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The frame as a camera sees it that rolls."""
    h, w = image.shape[:2]
    turn = cv2.getRotationMatrix2D((w / 2, h / 2), ROLL_DEG_PER_FRAME * index, 1.0)
    moved = cv2.warpAffine(image, turn, (w, h), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)


def cases() -> dict[str, tuple[Shot, bool]]:
    """Short clips, each with something in it that a threshold may be for, and if it has a rate."""
    bare = Scene(label=False, sensor_box=False)
    steep = Scene(marks=(), tilt_rad=0.6, camera_distance=4.2, texture=2.5)
    two = (Mark(radius=0.85), Mark(radius=0.45, azimuth_rad=2.1))
    dots = tuple(Mark(0.9, a, 0.06, 0.05) for a in np.linspace(0, 2 * np.pi, 24, endpoint=False))

    def shot(scene: Scene, rpm: float = 33.3, recorder: Recorder = STRONG, fps: float = 15.0,
             seconds: float = 8.0, measurable: bool = True) -> tuple[Shot, bool]:
        motion = PlateMotion(rpm * RPM, wow=((1.0, 3e-4, 1.0),) if rpm else (), angle_rad=0.4)
        return Shot(scene, motion, fps, seconds, recorder), measurable

    return {
        "one mark": shot(Scene()),
        "tilt of 40°": shot(Scene(tilt_rad=0.7, camera_distance=4.5, radius_px=135), -33.4),
        "texture only": shot(Scene(marks=(), label=False, sensor_box=False, texture=6.0)),
        "label and box": shot(Scene(marks=(), glare=90), -45.0),
        "label seen steeply": shot(steep, 16.7, seconds=12.0),
        "tonearm": shot(Scene(tonearm=True), 45.0),
        "hand": shot(Scene(hand_until_s=3.0)),
        "dim and noisy": shot(Scene(light=0.3, noise=5.0), 16.7),
        "rolling shutter": shot(dataclasses.replace(bare, marks=two, line_time_s=60e-6), 45.0),
        "half outside": shot(Scene(centre_px=(5.0, 181.0), sensor_box=False), 33.21),
        "small plate": shot(Scene(radius_px=50.0)),
        "flicker": shot(Scene(flicker=0.05), -33.2),
        "repeated frames": shot(Scene(), fps=30.0, recorder=Recorder(camera_fps=20.0)),
        "late stamps": shot(bare, recorder=Recorder(late_s=6e-3)),
        "dropped frames": shot(Scene(), recorder=Recorder(lost=0.02)),
        "two equal marks": shot(dataclasses.replace(bare, marks=(Mark(), Mark(azimuth_rad=np.pi)))),
        "red mark": shot(dataclasses.replace(bare, marks=(RED,), chroma_noise=1.0), -33.3),
        ROLLING: shot(Scene(tilt_rad=0.3), seconds=12.0),
        "hand, fast camera": shot(Scene(hand_until_s=2.0), -45.0, fps=50.0, seconds=6.0),
        "at rest": shot(Scene(), 0.0, measurable=False),
        "mark half hidden": shot(dataclasses.replace(bare, centre_px=(5.0, 181.0))),
        "strobe dots": shot(dataclasses.replace(bare, marks=dots), measurable=False),
    }


def rendered(folder: Path) -> dict[str, Path]:
    """The files of the cases, rendered unless they are there."""
    paths = {}
    for seed, (name, (shot, _)) in enumerate(cases().items()):
        paths[name] = folder / f"{name.replace(' ', '_')}.mp4"
        if not paths[name].exists():
            half = paths[name].with_suffix(".part.mp4")
            film(half, shot.motion, shot.scene, fps=shot.fps, seconds=shot.seconds, seed=seed,
                 recorder=shot.recorder)
            if name == ROLLING:
                again(half, paths[name], change=rolled)
            else:
                half.rename(paths[name])
    return paths


def outcome(name: str, track: Callable[[], PhaseTrack]) -> Outcome:
    """Measure one case and compare with the plate's mean rate over many turns."""
    shot, measurable = cases()[name]
    try:
        plate_track = track()
        rate = measure_rate(plate_track, timebase=Timebase(ppm=0.0))
    except VisionError:
        return Outcome(name, np.nan, np.nan, measurable)
    true = float(np.diff(shot.motion.angle(np.array([0.0, MEAN_OVER_S])))[0]) / MEAN_OVER_S
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    error_ppm = (signed / true - 1) * 1e6 if true else np.inf
    plate = plate_track.plate
    stated = (f"{plate.symmetry} {plate.mark_radius:.2f} {plate.mark_azimuth_rad:.2f} "
              f"{sorted(text[:40] for text in rate.warnings)}")
    sd_ppm = rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6
    return Outcome(name, error_ppm, sd_ppm, measurable, stated)


def from_clips(paths: dict[str, Path]) -> list[Outcome]:
    """All cases from their frames."""
    return [outcome(name, partial(track_phase, path)) for name, path in paths.items()]


def from_tracks(tracks: dict[str, PhaseTrack]) -> list[Outcome]:
    """The cases whose plate was tracked, from there."""
    return [outcome(name, partial(lambda track: track, track)) for name, track in tracks.items()]


def tracked(paths: dict[str, Path]) -> dict[str, PhaseTrack]:
    """Phase tracks of the clips in which a plate turns."""
    tracks = {}
    for name, path in paths.items():
        try:
            tracks[name] = track_phase(path)
        except VisionError:
            continue
    return tracks


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("package", choices=("vision.plate", "vision.tracking", "vision.rate"))
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="thresholds_"))
    folder.mkdir(parents=True, exist_ok=True)
    paths = rendered(folder)
    measure: Measure = partial(from_clips, paths)
    if options.package == "vision.rate":
        measure = partial(from_tracks, tracked(paths))
    start = time.perf_counter()
    for each in measure():
        print(f"{each.name:20s} {each.error_ppm:10.3f} ppm (sd {each.sd_ppm:8.3f})")
    print(f"{summary(measure())}, {(time.perf_counter() - start) / 2:.1f} s", flush=True)
    print_effects(options.only or options.package.partition(".")[2], measure)


if __name__ == "__main__":
    main()
