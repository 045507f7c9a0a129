"""Simulated phase tracks with none, one or two defects of the times and of the angles.

The camera takes frames at its own instants, the plate stands where its motor brought it, the
recorder drops and repeats frames and stamps the rest. No formula of ``vision`` is used.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tests.vision.cut_label import cut_label
from tests.vision.phase_tracks import CLOCK, RPM, phase_track
from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import BoolArray, PhaseTrack
from vision.rate.measure import measure_rate

MOST_CHANGE = 0.01  #: of a rate that is called constant
FEWEST_TURNS = 1.5
KINDS = ("within 2", "within 4", "beyond, said", "beyond, unsaid", "refused", "unsteady, said",
         "unsteady, unsaid")


@dataclass(eq=False)
class Film:
    """A clip on its way from the plate to the container.

    Attributes
    ----------
    rate_rad_s, fps, noise_rad : float
        Of the plate, signed, and of the container; noise of an angle.
    taken_s, stamp_s : array, shape (f,)
        When each frame was taken and when it is said to have been.
    shows : bool
        Whether the container's stamps show the gaps of frames that are dropped.
    error_rad : array, shape (f,)
        Error of each angle beside the noise.
    again : array of bool, shape (f,)
        The recorder repeated the frame before.
    change : float
        Relative change of the plate's rate over the clip.
    waves : array, shape (2, 2)
        Size and phase of the waves once and twice per turn, rad.
    sector : callable
        Error of the angle at each plate angle, rad.
    """

    rate_rad_s: float
    fps: float
    noise_rad: float
    taken_s: FloatArray
    stamp_s: FloatArray
    shows: bool
    error_rad: FloatArray
    again: BoolArray
    change: float
    waves: FloatArray
    lost: int = 0
    sector: Callable[[FloatArray], FloatArray] = field(default=np.zeros_like)

    @property
    def step_rad(self) -> float:
        """Angle from frame to frame, unsigned."""
        return abs(self.rate_rad_s) / self.fps

    def turned_rad(self) -> FloatArray:
        """Angle of the plate when the frames were taken, even rotation and change of the rate."""
        t, span = self.taken_s, self.stamp_s[-1]
        return self.rate_rad_s * (t + self.change * (t * span - t**2) / (2 * span))

    def keep(self, kept: BoolArray) -> None:
        """Lose the other frames; the container shows it or closes the gap."""
        self.lost += int((~kept).sum())
        self.stamp_s = self.stamp_s[kept] if self.shows else self.stamp_s[: kept.sum()]
        for name in ("taken_s", "error_rad", "again"):
            setattr(self, name, getattr(self, name)[kept])


def drops_single(film: Film, rng: np.random.Generator) -> None:
    """The recorder drops single frames, one in 30 to one in 500."""
    kept = rng.random(len(film.taken_s)) > 10 ** rng.uniform(-2.7, -1.5)
    kept[[0, -1]] = True
    film.keep(kept)


def drops_burst(film: Film, rng: np.random.Generator) -> None:
    """The recorder drops two to nine frames at once, one to three times."""
    kept = np.ones(len(film.taken_s), bool)
    for _ in range(rng.integers(1, 4)):
        at = rng.integers(3, len(kept) - 13)
        kept[at : at + rng.integers(2, 10)] = False
    film.keep(kept)


def repeats(film: Film, rng: np.random.Generator) -> None:
    """Frames are delivered twice; most of the repetitions are noticed."""
    again = rng.random(len(film.taken_s)) < 10 ** rng.uniform(-2.7, -1.3)
    again[:2] = False
    for i in np.flatnonzero(again):
        film.taken_s[i] = film.taken_s[i - 1]
    shown = np.diff(film.taken_s, prepend=-1) == 0
    film.again = shown & (film.again | (rng.random(len(again)) < 0.95))


def slow_camera(film: Film, rng: np.random.Generator) -> None:
    """In the dark the camera is slower, and the recorder fills the clip with repetitions."""
    camera_s = 1 / (film.fps * rng.uniform(0.55, 0.98))
    number = np.floor(film.taken_s / camera_s + rng.random())
    film.again = np.diff(number, prepend=-1) == 0
    film.taken_s = number * camera_s


def pulldown(film: Film, rng: np.random.Generator) -> None:
    """24 frames of 30, or 25 of 30, are new."""
    of = int(rng.choice([5, 6]))
    number = np.arange(len(film.taken_s)) + rng.integers(0, of)
    taken = np.floor(number * (of - 1) / of + 1e-9) * of / (of - 1) / film.fps
    film.again = np.diff(taken, prepend=-1) == 0
    film.taken_s = taken


def clock_step(film: Film, rng: np.random.Generator) -> None:
    """The clock of the stamps leaps by a third of a frame time to three of them, once."""
    at = rng.integers(len(film.stamp_s) // 5, 4 * len(film.stamp_s) // 5)
    by = rng.uniform(0.33, 3) / film.fps
    if rng.random() < 0.5:  # seen in the stamps alone
        film.stamp_s = film.stamp_s + by * (np.arange(len(film.stamp_s)) >= at)
    else:
        film.taken_s = film.taken_s + by * (np.arange(len(film.stamp_s)) >= at)


def outliers(film: Film, rng: np.random.Generator) -> None:
    """Something in the way: single angles and short runs are wrong by up to two frame steps."""
    for _ in range(rng.integers(1, 10)):
        at = rng.integers(2, len(film.error_rad) - 8)
        film.error_rad[at : at + rng.integers(1, 6)] += rng.uniform(-2.2, 2.2) * film.step_rad


def sector_error(film: Film, rng: np.random.Generator) -> None:
    """A plate that shows little at one angle: the angle leaps there, and creeps back."""
    jump = float(min(rng.uniform(0.2, 2.2) * film.step_rad, 0.5))
    over, at = float(rng.uniform(0.05, 0.5)), float(rng.uniform(0, 2 * np.pi))
    film.sector = lambda angle: cut_label(angle, jump_rad=jump, over_rad=over, at_rad=at)


def slow_down(film: Film, rng: np.random.Generator) -> None:
    """The plate gets slower by a hundredth of a per cent to three per cent."""
    film.change = -(10 ** rng.uniform(-4, -1.5))


def late_stamps(film: Film, rng: np.random.Generator) -> None:
    """The stamps come early and late by some hundredths of a frame time."""
    film.stamp_s = film.stamp_s + rng.normal(0, rng.uniform(0.01, 0.08), len(film.stamp_s)
                                             ).clip(-0.3, 0.3) / film.fps


DEFECTS: tuple[Callable[[Film, np.random.Generator], None], ...] = (
    drops_single, drops_burst, repeats, slow_camera, pulldown, clock_step, outliers, sector_error,
    slow_down, late_stamps,
)
ORDER = (slow_down, sector_error, slow_camera, pulldown, repeats, outliers, clock_step, late_stamps,
         drops_single, drops_burst)


@dataclass(frozen=True, eq=False)
class Mixed:
    """A track, its defects, its mean rate, and whether a rate can be called constant."""

    track: PhaseTrack
    defects: tuple[str, ...]
    rate_rad_s: float
    change: float
    lost: int
    about: str

    @property
    def is_constant(self) -> bool:
        """Whether the rate may be called constant."""
        return abs(self.change) <= MOST_CHANGE


def mixed_track(seed: tuple[int, ...]) -> Mixed:
    """The track of a seed: a fifth without a defect, a half with one, the others with two."""
    rng = np.random.default_rng([*seed, 331])
    while True:
        rpm, fps = 10 ** rng.uniform(np.log10(16), np.log10(78)), rng.uniform(12, 60)
        seconds = 10 ** rng.uniform(np.log10(3), np.log10(60))
        if rng.random() < 0.7:
            rpm, fps = rng.choice([16.67, 33.33, 45, 78]), rng.choice([12, 15, 24, 25, 30, 50, 60])
        if seconds * rpm / 60 > FEWEST_TURNS and fps * seconds > 50:
            break
    time = np.arange(int(seconds * fps)) / fps
    film = Film(
        rate_rad_s=rpm * RPM * rng.choice([-1, 1]), fps=fps,
        noise_rad=10 ** rng.uniform(np.log10(3e-4), -2), taken_s=time.copy(), stamp_s=time.copy(),
        shows=rng.random() < 0.4, error_rad=np.zeros(len(time)), again=np.zeros(len(time), bool),
        change=0.0,
        waves=np.stack([rng.uniform(0, 1, 2) * 10 ** rng.uniform(-3.5, -1.7, 2),
                        rng.uniform(0, 2 * np.pi, 2)], axis=1),
    )
    count = rng.choice([0, 1, 2], p=[0.2, 0.45, 0.35])
    chosen = [DEFECTS[i] for i in rng.choice(len(DEFECTS), count, replace=False)]
    for defect in sorted(chosen, key=ORDER.index):
        defect(film, rng)
    turned = film.turned_rad() + rng.uniform(0, 2 * np.pi)
    angle = turned + film.error_rad + film.sector(turned)
    for order, (size, phase) in enumerate(film.waves, start=1):
        angle = angle + size * np.cos(order * turned + phase)
    stamp = film.stamp_s - film.stamp_s[0]
    if rng.random() < 0.4:
        stamp = np.round(stamp, 3)
    track = phase_track(stamp, angle, noise_rad=film.noise_rad, duplicate=film.again,
                        seed=int(rng.integers(1 << 30)))
    noise = track.phase_rad  # the repetition shows the noise of its frame too
    for i in np.flatnonzero(film.again):
        noise[i] = noise[i - 1]
    span = film.taken_s[-1] - film.taken_s[0]
    true = (film.turned_rad()[-1] - film.turned_rad()[0]) / span
    about = (f"{rpm:.1f} rpm {fps:.1f} fps {seconds:.0f} s, {len(stamp)} frames, noise "
             f"{1e3 * film.noise_rad:.1f} of {1e3 * film.step_rad:.0f} mrad, "
             f"{'shown' if film.shows else 'hidden'} gaps, lost {film.lost}, "
             f"change {film.change:.2%}")
    return Mixed(track, tuple(each.__name__ for each in chosen), float(true), film.change,
                 film.lost, about)


def verdict(case: Mixed) -> tuple[str, str]:
    """The kind of result of a track, and what was said."""
    try:
        rate = measure_rate(case.track, timebase=CLOCK)
    except RateRefused as error:
        said = str(error)[10:150]
        return ("refused" if case.is_constant else "unsteady, said"), said
    signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
    off, sd = signed / case.rate_rad_s - 1, rate.uncertainty.image_rad_s / rate.rate_rad_s
    text = (f"{1e6 * off:+.0f} ± {1e6 * sd:.0f} ppm, dropped {rate.frames.dropped}, "
            f"{[text[10:70] for text in rate.warnings]}")
    said = bool(rate.warnings)
    if not case.is_constant:
        return ("unsteady, said" if said else "unsteady, unsaid"), text
    if abs(off) > 4 * sd:
        return ("beyond, said" if said else "beyond, unsaid"), text
    return ("within 2" if abs(off) <= 2 * sd else "within 4"), text
