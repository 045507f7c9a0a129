"""How well the rate is measured on rendered clips: random scenes, 15 fps, strong H.264.

    python -m tests.bench.vision_scenes [--texture] [--seconds 60] [--scenes 40] [--first 0]
                                        [--keep DIR]

With ``--texture`` no plate has a mark: half of them have a speckle and nothing else, half a label
or a sensor box or both, and all turn so near a record speed that they keep step with the pictures.

Prints one row per scene (rate error in ppm, in stated standard deviations, phase noise against
the bound from the picture noise) and the figures over all of them. Clips already in DIR are used
again. The true rate is the plate's mean over many turns: wow of relative amplitude a makes it
a²/2 slower than the drive. Phase noise is measured angle less true angle, over the pictures of the
bound, so that the drive's flutter is no noise and the chance of those pictures is in both.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from tests.world.film import Recorder, Scene, film, random_scene
from tests.world.picture import Picture
from tests.world.plate import PlateMotion
from tests.world.scene import FloatArray
from vision.errors import VisionError
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RPM = 2 * np.pi / 60
SPEEDS_RPM = (16.667, 33.333, 45.0)
FPS = 15.0
OFF_SPEED = 0.01  # relative, at most
SECONDS = 60.0
IN_STEP = 0.002  # the same with --texture: 0.05 pictures per turn at 33 1/3 rpm
MEAN_OVER_S = 3000.0
STEP_RAD = 2e-3  # of the numerical derivatives; a third of a pixel at the rim


@dataclass(frozen=True)
class Row:
    """One scene."""

    seed: int
    error_ppm: float
    image_sd_ppm: float
    noise_over_bound: float
    noise_over_one_step: float
    noise_over_white: float
    seconds: float
    says: str


@dataclass(frozen=True)
class Clip:
    """One clip of the bench: everything about it follows from these."""

    seed: int
    seconds: float
    texture: bool

    @property
    def scene(self) -> Scene:
        """What is filmed."""
        rng = np.random.default_rng([self.seed, 11])
        scene = random_scene(rng)
        if not self.texture:
            return scene
        if self.seed % 2:
            label, box = [(True, True), (True, False), (False, True)][rng.integers(3)]
            return replace(scene, marks=(), label=label, sensor_box=box)
        speckle = rng.uniform(6, 12)
        return replace(scene, marks=(), label=False, sensor_box=False, texture=speckle)

    @property
    def motion(self) -> PlateMotion:
        """Nearly a record speed, either direction, with some wow and flutter."""
        rng = np.random.default_rng([self.seed, 10])
        off = IN_STEP if self.texture else OFF_SPEED
        rate = rng.choice(SPEEDS_RPM) * RPM * (1 + rng.uniform(-off, off)) * rng.choice([-1, 1])
        wow = (
            (1.0, rng.uniform(0, 1e-3), rng.uniform(0, 6.28)),
            (rng.uniform(4, 12), rng.uniform(0, 5e-4), rng.uniform(0, 6.28)),
        )
        return PlateMotion(rate, wow=wow, angle_rad=rng.uniform(0, 6.28))

    @property
    def noise_frames(self) -> range:
        """Pictures whose noise is compared with the bounds."""
        frames = round(self.seconds * FPS)
        return range(frames // 9, frames * 17 // 18, 7)

    def rendered(self, folder: Path) -> Path:
        """The file, rendered unless it is there."""
        kind = "texture" if self.texture else "scene"
        length = "" if self.seconds == SECONDS else f"_{self.seconds:g}s"
        path = folder / f"{kind}_{self.seed:02d}{length}.mp4"
        if not path.exists():
            half = path.with_suffix(".part.mp4")
            recorder = Recorder(crf=30)
            film(half, self.motion, self.scene, fps=FPS, seconds=self.seconds, seed=self.seed,
                 recorder=recorder)
            half.rename(path)
        return path


@dataclass(frozen=True, eq=False)
class Bounds:
    """Angle errors in rad that the decoded pictures themselves impose, on ``noise_frames``.

    With e the decoded picture less the noise-free rendering C(θ), g = ∂C/∂θ and g' = ∂g/∂θ:

    Attributes
    ----------
    best : array
        Σge / (Σg² - Σg'e): where Σ(picture - C(θ))² is least. Nobody knows C; this filter does.
    one_step : array
        Σge / Σg²: the same after one step from the true angle. Strong compression washes edges
        out, the pictures answer a turn with only 0.65 to 0.95 of g, and a step that counts on the
        whole of g falls short by as much; its scatter is smaller than that of any true measurement.
    white : array
        √Σg²e² / Σg²: what the scatter would be if the errors of neighbouring pixels had nothing to
        do with each other, which compression does not grant.
    """

    best: FloatArray
    one_step: FloatArray
    white: FloatArray


def phase_bounds(path: Path, clip: Clip) -> Bounds:
    """From the noise of this clip's own pictures."""
    scene, motion = clip.scene, clip.motion
    picture = Picture(scene, clip.seed)
    swept = abs(motion.rate_rad_s) * scene.exposure_s
    rows = (np.arange(scene.height_px) - (scene.height_px - 1) / 2) * scene.line_time_s
    capture = cv2.VideoCapture(str(path))
    best, one_step, white = [], [], []
    for index in range(clip.noise_frames.stop):
        ok, decoded = capture.read()
        assert ok
        if index not in clip.noise_frames:
            continue
        at = index / FPS
        luma = cv2.cvtColor(decoded, cv2.COLOR_BGR2YUV)[:, :, 0].astype(float)
        angle = motion.angle(at + rows)
        ahead, clean, behind = (
            picture.luma(angle + s, swept, at).astype(float) for s in (STEP_RAD, 0.0, -STEP_RAD)
        )
        g = (ahead - behind) / (2 * STEP_RAD)
        bend = (ahead - 2 * clean + behind) / STEP_RAD**2
        # The decoder's colours are full range, the rendering is in limited range.
        e = luma * 219 / 255 + 16 - clean
        pull, stiffness = (g * e).sum(), (g**2).sum()
        best.append(pull / (stiffness - (bend * e).sum()))
        one_step.append(pull / stiffness)
        white.append(np.sqrt((g**2 * e**2).sum()) / stiffness)
    return Bounds(np.array(best), np.array(one_step), np.array(white))


def scatter(error: FloatArray, time_s: FloatArray, angle_rad: FloatArray) -> float:
    """Standard deviation with line and one and two waves per turn taken off, as in the fit."""
    waves = [np.ones_like(time_s), time_s]
    waves += [f(k * angle_rad) for k in (1, 2) for f in (np.cos, np.sin)]
    x = np.stack(waves, axis=1)
    left = error - x @ np.linalg.lstsq(x, error)[0]
    return float(np.sqrt((left**2).sum() / (len(time_s) - x.shape[1])))


def study(clip: Clip, folder: Path) -> Row:
    """Film, measure, compare."""
    path, motion, noise_frames = clip.rendered(folder), clip.motion, clip.noise_frames
    start = time.perf_counter()
    try:
        track = track_phase(path)
        rate = measure_rate(track, timebase=Timebase(ppm=0.0))
    except VisionError as error:
        return Row(clip.seed, *[np.nan] * 5, time.perf_counter() - start, str(error))
    seconds = time.perf_counter() - start
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    true = float(np.ptp(motion.angle(np.array([0.0, MEAN_OVER_S])))) / MEAN_OVER_S
    measured = rate.history.angle
    bounds = phase_bounds(path, clip)
    both = rate.fit.used & np.isin(measured.index, noise_frames)
    at = (measured.index[both] - noise_frames.start) // noise_frames.step
    time_s = measured.time_s[both]
    angle = motion.angle(time_s)
    noise = scatter(measured.angle_rad[both] - angle, time_s, angle)
    return Row(
        clip.seed,
        (signed / (true * np.sign(motion.rate_rad_s)) - 1) * 1e6,
        rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6,
        noise / scatter(bounds.best[at], time_s, angle),
        noise / scatter(bounds.one_step[at], time_s, angle),
        noise / float(np.mean(bounds.white)),
        seconds,
        f"{rate.diagnosis.verdict} {rate.diagnosis.name or ''} {'; '.join(rate.warnings)}",
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--texture", action="store_true")
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="scenes_"))
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in range(options.first, options.first + options.scenes):
        row = study(Clip(seed, options.seconds, options.texture), folder)
        rows.append(row)
        print(
            f"{row.seed:3d} error {row.error_ppm:9.3f} ppm = "
            f"{row.error_ppm / row.image_sd_ppm:6.2f} sd (sd {row.image_sd_ppm:6.3f} ppm), phase "
            f"noise {row.noise_over_bound:5.2f} x bound ({row.noise_over_one_step:5.2f} x one "
            f"step, {row.noise_over_white:5.2f} x white), "
            f"{row.seconds:5.2f} s  {row.says[:150]}",
            flush=True,
        )
    error = np.abs([row.error_ppm for row in rows])
    in_sd = error / np.array([row.image_sd_ppm for row in rows])
    bound = np.array([row.noise_over_bound for row in rows])
    refused = int(np.isnan(error).sum())
    print(f"refused {refused} of {len(rows)}")
    if refused == len(rows):
        return
    seen = np.isfinite(error)
    print(
        f"rate error: median {np.median(error[seen]):.3f} ppm, largest {error[seen].max():.3f} ppm"
    )
    share = float((in_sd[seen] < 2).mean())
    print(
        f"|error|/sd under 2: {share:.1%} ± {np.sqrt(share * (1 - share) / seen.sum()):.1%}, "
        f"rms {np.sqrt((in_sd[seen] ** 2).mean()):.2f}"
    )
    for name, ratio in (
        ("bound", bound[seen]),
        ("one-step bound", np.array([row.noise_over_one_step for row in rows])[seen]),
    ):
        print(
            f"phase noise/{name}: median {np.median(ratio):.2f}, largest {ratio.max():.2f}, "
            f"over 1.5 in {(ratio > 1.5).sum()}"
        )


if __name__ == "__main__":
    main()
