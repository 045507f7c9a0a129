"""Simulated phase tracks of every kind that the rate's thresholds decide on."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.vision.cut_label import cut_label
from tests.vision.motor_tracks import motor_track
from tests.vision.phase_tracks import RPM, phase_track, steady
from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack


@dataclass(frozen=True, eq=False)
class Case:
    """A track and what is true of it; None where that is not judged."""

    kind: str
    track: PhaseTrack
    rate_rad_s: float | None  #: None: no constant rate, to be refused
    dropped: int | None = 0
    missing: str | None = None  #: term that the diagnosis should name, "" for none
    warning: str | None = None  #: what one of the warnings should say, "" for no warning at all
    how: dict[str, Any] = field(default_factory=dict)


def _even(rng: np.random.Generator) -> tuple[FloatArray, FloatArray, float, float]:
    """Time, angle, signed rate and frame time of an even rotation with 5 to 90 frames per turn."""
    while True:
        fps = float(rng.choice([10, 15, 25, 29.97, 30, 60, 120]))
        rpm = float(rng.choice([16.67, 33.3, 45, 78.26, 20.3, 60.2]) * rng.choice([-1, 1]))
        if 5 < 60 * fps / abs(rpm) < 90:
            break
    time, angle = steady(rpm, seconds=float(rng.uniform(8, 24)), fps=fps)
    return time, angle + rng.uniform(0, 6), rpm * RPM, 1 / fps


def _noise(rng: np.random.Generator) -> float:
    return float(10 ** rng.uniform(-4, -2.7))


def plain(rng: np.random.Generator) -> Case:
    """An even rotation."""
    time, angle, rate, _ = _even(rng)
    track = phase_track(time, angle, noise_rad=_noise(rng), seed=int(rng.integers(1 << 30)))
    return Case("plain", track, rate, missing="", warning="")


def wobble(rng: np.random.Generator) -> Case:
    """Waves once and twice per turn, and a faster one."""
    time, angle, rate, _ = _even(rng)
    noise = _noise(rng)
    order = int(rng.integers(1, 3))
    size = noise * rng.uniform(3, 30)
    seen = angle + size * np.cos(order * angle + rng.uniform(0, 6))
    seen += 0.3 * noise * np.cos(2 * np.pi * 3.1 * time)
    track = phase_track(time, seen, noise_rad=noise, seed=int(rng.integers(1 << 30)))
    name = ("once_per_rev", "twice_per_rev")[order - 1]
    return Case("wobble", track, rate, missing=name if len(time) > 200 else None, warning="")


def drift(rng: np.random.Generator) -> Case:
    """A rate that changes by 0.02 to 0.4 %, or by more than can be taken."""
    time, angle, rate, _ = _even(rng)
    refused = rng.random() < 0.5
    change = rng.uniform(0.015, 0.1) if refused else 10 ** rng.uniform(-3.7, -2.4)
    span = time[-1]
    seen = angle + rate * change * (time**2 / (2 * span) - time / 2)
    track = phase_track(time, seen, noise_rad=_noise(rng), seed=int(rng.integers(1 << 30)))
    if span * abs(rate) < 6 * np.pi:  # of fewer than three turns the change cannot be seen
        return Case("drift", track, rate, warning=None)
    return Case("drift", track, None if refused else rate,
                warning="changes by" if 0.0025 < change < 0.009 else None)


def stop(rng: np.random.Generator) -> Case:
    """Switched off, or switched on while filming; measured where it turns steadily for turns."""
    time, _, rate, _ = _even(rng)
    span = time[-1]
    at = rng.uniform(0.3, 0.7) * span
    tau = rng.uniform(1, 5)
    past = np.maximum(time - at, 0)
    angle = rate * (np.minimum(time, at) + tau * (1 - np.exp(-past / tau)))
    if rng.random() < 0.5:
        angle = -angle[::-1] + angle[-1]
    track = phase_track(time, angle, noise_rad=_noise(rng), seed=int(rng.integers(1 << 30)))
    turns = at * abs(rate) / (2 * np.pi)
    return Case("stop", track, rate if turns > 3 else None, dropped=None)


def motor(rng: np.random.Generator) -> Case:
    """A start, a stop or both, with turns between them."""
    made = motor_track(rng)
    return Case("motor", made.track, made.rate_rad_s, dropped=None)


def shutter(rng: np.random.Generator) -> Case:
    """An exposure that changes by up to three stops, the stamps at its beginning."""
    time, angle, rate, frame_s = _even(rng)
    first, last = frame_s * 2.0 ** -rng.uniform(0.2, 3.5, 2)
    exposure = first + (last - first) * time / time[-1]
    noise = _noise(rng)
    smear = (rate * exposure) ** 2 / 12
    smear = smear - smear.mean() + rng.uniform(0.02, 0.2) * smear.mean() * rng.standard_normal(
        len(time))
    track = phase_track(time, angle + rate * exposure / 2, noise_rad=noise, smear_rad2=smear,
                        seed=int(rng.integers(1 << 30)))
    return Case("shutter", track, rate, warning="lock the exposure" if
                abs(last - first) > 0.15 * frame_s else None)


def dropped(rng: np.random.Generator) -> Case:
    """Frames that the recorder dropped and stamped as if it had not; at times blended."""
    time, angle, rate, frame_s = _even(rng)
    keep = rng.random(len(time)) > rng.uniform(0.002, 0.03)
    keep[:12] = keep[-12:] = True
    gone = np.flatnonzero(~keep)
    for later, share in enumerate(rng.choice([0.0, 0.5]) * np.array([1.0, 0.3]), start=1):
        angle[gone + later] -= share * rate * frame_s
    noise = min(_noise(rng), abs(rate) * frame_s / 40)
    track = phase_track(time[: keep.sum()], angle[keep], noise_rad=noise,
                        seed=int(rng.integers(1 << 30)))
    return Case("dropped", track, rate, dropped=len(gone), warning="dropped" if len(gone) else "",
                missing="frame_steps" if len(gone) > 1 else None)


def mismeasured(rng: np.random.Generator) -> Case:
    """Frames whose angle is wrong: alone, in runs, or coming back bit by bit."""
    time, angle, rate, frame_s = _even(rng)
    for _ in range(int(rng.integers(1, 8))):
        at = int(rng.integers(5, len(time) - 12))
        n = int(rng.integers(1, 7))
        away = rng.choice([-1, 1]) * rng.uniform(0.5, 2.2) * rate * frame_s
        back = rng.random() < 0.5
        angle[at : at + n] += away * (np.linspace(1, 0.2, n) if back else 1.0)
    track = phase_track(time, angle, noise_rad=_noise(rng), seed=int(rng.integers(1 << 30)))
    return Case("mismeasured", track, rate, warning="")


def noisy(rng: np.random.Generator) -> Case:
    """Angles that scatter by 0.5 to 3 degrees."""
    time, angle, rate, _ = _even(rng)
    noise = np.radians(rng.uniform(0.5, 3))
    track = phase_track(time, angle, noise_rad=float(noise), seed=int(rng.integers(1 << 30)))
    return Case("noisy", track, rate, warning="scatters" if noise > np.radians(1) else None)


def wandering(rng: np.random.Generator) -> Case:
    """A slow wander such as an encoder makes of dropped frames of a fast camera."""
    time, angle = steady(16.67, seconds=20, fps=240)
    step = 0.0
    wander = np.empty(len(time))
    for i, kick in enumerate(rng.standard_normal(len(time))):
        wander[i] = step = 0.99 * step + kick
    wander *= np.radians(rng.uniform(0.27, 0.5)) / wander.std()
    track = phase_track(time, angle + wander, noise_rad=4e-4)
    return Case("wandering", track, None)


def late(rng: np.random.Generator) -> Case:
    """Stamps that come some milliseconds early or late, in bursts, or in whole milliseconds."""
    time, angle, rate, frame_s = _even(rng)
    kind = rng.integers(3)
    if kind == 0:
        stamps = time + np.clip(rng.normal(0, 0.1, len(time)), -0.4, 0.4) * frame_s
    elif kind == 1:
        stamps = np.round(time, 3)
    else:
        stamps = time.copy()
        stamps[1::2] = time[:-1:2] + 2e-3 if len(time) % 2 else time[::2] + 2e-3
    track = phase_track(stamps - stamps[0], angle, noise_rad=_noise(rng))
    return Case("late", track, rate)


def repeated(rng: np.random.Generator) -> Case:
    """Frames delivered twice, noticed; a camera that was slower than its clip."""
    time, angle, rate, frame_s = _even(rng)
    slower = rng.uniform(0.6, 0.97)
    ahead = rng.random()  # of the first frame of the clip, in frames of the camera
    taken = (np.floor(time / frame_s * slower + ahead) - ahead) / slower * frame_s
    shown = angle[0] + rate * taken
    again = np.diff(taken, prepend=-1) == 0
    track = phase_track(time, shown, noise_rad=_noise(rng), duplicate=again)
    return Case("repeated", track, rate)


def hidden(rng: np.random.Generator) -> Case:
    """Something stands before the plate for seconds at a time, or for a part of each turn."""
    time, angle, rate, _ = _even(rng)
    quality = 0.99 + 0.003 * rng.standard_normal(len(time)).clip(-2, 2)
    away = np.cos(angle + 1.0) > rng.uniform(0.6, 0.9)
    away &= time < rng.uniform(0.3, 0.8) * time[-1]
    quality = np.where(away, rng.uniform(0.2, 0.85), quality)
    wrong = np.where(away, rng.normal(0, 0.5, len(time)), 0.0)
    track = phase_track(time, angle + wrong, noise_rad=_noise(rng), quality=quality)
    return Case("hidden", track, rate, warning="")


def label(rng: np.random.Generator) -> Case:
    """A plate that shows little at one angle: the angle jumps there and creeps back."""
    time, angle, rate, frame_s = _even(rng)
    jump = abs(rate) * frame_s * rng.choice([1.0, 2.0])
    if jump > 0.5:
        jump = abs(rate) * frame_s
    error = cut_label(angle, jump_rad=float(jump), over_rad=float(rng.uniform(0.05, 0.4)),
                      rng=rng)
    track = phase_track(time, angle + np.sign(rate) * error, noise_rad=_noise(rng))
    return Case("label", track, rate)


def aliased(rng: np.random.Generator) -> Case:
    """A rate beyond half the frame rate, chosen by the nominal one or by uneven stamps."""
    rpm = float(rng.uniform(500, 800))
    time, angle = steady(rpm, seconds=20, fps=15)
    if rng.random() < 0.5:
        track = phase_track(time, angle, noise_rad=_noise(rng))
        nominal = rpm * rng.uniform(0.97, 1.03)
        return Case("aliased", track, rpm * RPM, how={"nominal_rpm": nominal})
    time = time + rng.uniform(-0.01, 0.01, len(time))
    track = phase_track(time - time[0], rpm * RPM * time, noise_rad=_noise(rng))
    return Case("aliased", track, rpm * RPM)


KINDS: tuple[Callable[[np.random.Generator], Case], ...] = (
    plain, wobble, drift, stop, shutter, dropped, mismeasured, noisy, wandering, late, repeated,
    hidden, label, aliased, motor,
)


def cases(count: int) -> Iterator[Case]:
    """The first ``count`` tracks, each kind in turn."""
    for i in range(count):
        yield KINDS[i % len(KINDS)](np.random.default_rng([i, 5]))
