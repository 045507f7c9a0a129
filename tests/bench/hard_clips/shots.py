"""The categories of clips, each with its own chance."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tests.bench.hard_clips.footage import Shot
from tests.bench.hard_clips.stage import Camera

RPM = 2 * np.pi / 60


def _plain(category: str, seed: int, rng: np.random.Generator, **how: Any) -> Shot:
    """A steady plate before a camera on a stand."""
    rpm = float(rng.choice([16.667, 33.333, 45.0]) * (1 + rng.uniform(-0.01, 0.01)))
    rate = rpm * RPM * float(rng.choice([-1, 1]))
    start, wow, phase = rng.uniform(0, 6.28), rng.uniform(0, 5e-4), rng.uniform(0, 6.28)
    camera = Camera(
        radius_px=rng.uniform(100, 135), distance=rng.uniform(4, 9),
        tilt_rad=rng.uniform(0.05, 0.8), azimuth_rad=rng.uniform(-2.2, -0.9),
        aim_px=tuple(rng.uniform(-20, 20, 2)), seed=seed)
    exposure = float(rng.uniform(1 / 250, 1 / 50))
    given: dict[str, Any] = {
        "disc": str(rng.choice(["mark", "label", "print"])),
        "camera": camera,
        "exposure": lambda t: exposure,
        "streak": rng.uniform(0, 0.25),
        "off_centre": rng.uniform(0, 0.01),
        "wobble_rad": rng.uniform(0, 0.004),
        "seconds": max(10.0, 4.2 * 60 / rpm),
        "angle": lambda t: start + rate * t + wow * np.sin(start + rate * t + phase),
    }
    return Shot(category, seed, rate, **{**given, **how})


def _seen(shot: Shot, **camera: Any) -> Shot:
    return replace(shot, camera=replace(shot.camera, **camera))


def exposure_drift(seed: int, rng: np.random.Generator) -> Shot:
    """Auto-exposure follows a cloud: the shutter changes by one to three stops."""
    seconds = float(rng.uniform(12, 20))
    first = float(rng.uniform(1 / 250, 1 / 90))
    last = min(first * 2 ** rng.uniform(1, 3), 1 / 28)
    first, last = (first, last) if rng.random() < 0.7 else (last, first)
    step = rng.random() < 0.3

    def share(t: float) -> float:
        return float(np.clip((t / seconds - 0.4) / 0.2, 0, 1)) if step else t / seconds

    keeps = rng.uniform(0.7, 1.0)  # of the brightness

    def exposure(t: float) -> float:
        return float(first * (last / first) ** share(t))

    return _plain("exposure drift", seed, rng, seconds=seconds, exposure=exposure,
                  light=lambda t: float(keeps ** share(t)))


def hand_held(seed: int, rng: np.random.Generator) -> Shot:
    """A phone in a hand."""
    shot = _plain("hand-held", seed, rng, seconds=12.0)
    return _seen(shot, sway_px=float(10 ** rng.uniform(0.3, 1.3)),
                 roll_rad=float(rng.uniform(0.002, 0.03)), radius_px=rng.uniform(80, 110))


def bump(seed: int, rng: np.random.Generator) -> Shot:
    """The camera is pushed once."""
    shot = _plain("bump", seed, rng, seconds=12.0)
    return _seen(shot, bump_s=float(rng.uniform(2, 10)), bump_px=float(rng.uniform(3, 25)))


def interlaced(seed: int, rng: np.random.Generator) -> Shot:
    """A camcorder's fields."""
    return _plain("interlaced", seed, rng, interlaced=True)


def small(seed: int, rng: np.random.Generator) -> Shot:
    """A plate of some 60 pixels, filmed from across the room."""
    shot = _plain("small plate", seed, rng, disc=str(rng.choice(["mark", "paper"])))
    return _seen(shot, size_px=(640, 480), radius_px=float(rng.uniform(27, 40)), distance=20.0,
                 aim_px=tuple(rng.uniform(-120, 120, 2)))


def dark(seed: int, rng: np.random.Generator) -> Shot:
    """A room with the lights off."""
    dim = float(rng.uniform(0.04, 0.12))
    return _plain("dark room", seed, rng, disc=str(rng.choice(["mark", "paper"])),
                  light=lambda t: dim, noise=0.003, exposure=lambda t: 1 / 30, crf=28)


def partly_hidden(seed: int, rng: np.random.Generator) -> Shot:
    """Something stands before a part of the plate."""
    return _plain("partly hidden", seed, rng, hidden=float(rng.uniform(0.15, 0.6)))


def inset(seed: int, rng: np.random.Generator) -> Shot:
    """A clip within a clip, or in portrait."""
    shot = _plain("inset or portrait", seed, rng)
    if rng.random() < 0.5:
        return replace(shot, inset=float(rng.uniform(0.4, 0.6)))
    return _seen(shot, size_px=(270, 480), radius_px=float(rng.uniform(80, 110)))


def recorder(seed: int, rng: np.random.Generator) -> Shot:
    """Low bit rates, Motion JPEG, uneven frame rates, frames dropped and repeated."""
    faults: list[dict[str, Any]] = [
        {"bit_rate": 60_000}, {"codec": "mjpeg", "suffix": ".avi"},
        {"codec": "mjpeg", "suffix": ".mkv"}, {"jitter_s": 3e-3, "dropped": 0.1},
        {"lost": 0.02}, {"repeated": 0.05}]
    return _plain("recorder", seed, rng, **faults[rng.integers(len(faults))])


def lamps(seed: int, rng: np.random.Generator) -> Shot:
    """Flicker, banding, lens distortion, strong streaks, a warped record off its centre."""
    return _plain("lamps and lenses", seed, rng, flicker=float(rng.uniform(0.05, 0.4)),
                  line_s=float(rng.uniform(0, 60e-6)), distortion=float(rng.uniform(-0.12, 0.12)),
                  streak=float(rng.uniform(0.2, 0.7)), off_centre=float(rng.uniform(0.01, 0.03)),
                  wobble_rad=float(rng.uniform(0.005, 0.02)), fps=float(rng.choice([24, 29.97])))


def spin(seed: int, rng: np.random.Generator) -> Shot:
    """The motor is started, or stopped, or both within the clip."""
    shot = _plain("start and stop", seed, rng)
    rate = shot.rate_rad_s or 0.0
    start, stop = (bool(x) for x in ((1, 0), (0, 1), (1, 1))[rng.integers(3)])
    still, tau = rng.uniform(0.5, 2), rng.uniform(0.3, 0.8)
    steady = 5 * 2 * np.pi / abs(rate)
    begin = still if start else 0.0
    end = begin + 6 * tau * start + steady
    fall = rng.uniform(1, 3)

    def angle(t: float) -> float:
        past = max(min(t, end) - begin, 0.0)
        turned = rate * (past - tau * (1 - np.exp(-past / tau)) if start else past)
        beyond = min(max(t - end, 0.0), fall)
        return float(turned + (rate * (beyond - beyond**2 / (2 * fall)) if stop else
                               rate * max(t - end, 0.0)))

    return replace(shot, angle=angle, seconds=end + (fall + 1.0 if stop else 0.5))


def no_mark(seed: int, rng: np.random.Generator) -> Shot:
    """Ribs, strobe dots, or a label that looks the same two to four times a turn."""
    kind = str(rng.choice(["ribs", "strobe", "fold2", "fold3", "fold4"]))
    shot = _plain("no mark", seed, rng, disc=kind, fps=30.0)
    return replace(shot, nominal_rpm=round(abs(shot.rate_rad_s or 0) / RPM, 0))


def mark_leaves(seed: int, rng: np.random.Generator) -> Shot:
    """One mark that is in the frame for part of each turn only."""
    shot = _plain("mark leaves", seed, rng, disc="paper")
    return _seen(shot, aim_px=(float(rng.uniform(190, 225)), 0.0))


def edge_on(seed: int, rng: np.random.Generator) -> Shot:
    """Seen from nearly the side."""
    return _seen(_plain("edge-on", seed, rng), tilt_rad=float(rng.uniform(1.15, 1.36)))


def plain(seed: int, rng: np.random.Generator) -> Shot:
    """As the guide asks for."""
    return _plain("plain", seed, rng)


def from_the_side(seed: int, rng: np.random.Generator) -> Shot:
    """Seen at 50 to 80 degrees from above, from near by, with a mark or without."""
    shot = _plain("from the side", seed, rng)
    return _seen(shot, tilt_rad=float(np.radians(rng.uniform(50, 80))),
                 radius_px=float(rng.uniform(120, 190)), distance=float(rng.uniform(2.5, 8)))


def cut(seed: int, rng: np.random.Generator) -> Shot:
    """Cut by one edge of the frame, or by two."""
    shot = _plain("cut", seed, rng, disc=str(rng.choice(["label", "print", "mark"])))
    sides = rng.choice([-1, 1], 2) * (1, rng.integers(0, 2))
    aim = sides * rng.uniform(0.7, 1.0, 2) * (240, 180)
    return _seen(shot, aim_px=(float(aim[0]), float(aim[1])),
                 radius_px=float(rng.uniform(130, 200)), tilt_rad=float(rng.uniform(0.1, 1.2)))


def pulldown(seed: int, rng: np.random.Generator) -> Shot:
    """A camera of 24 or 25 frames per second in a clip of 30."""
    return _plain("pulldown", seed, rng, fps=30.0, camera_fps=float(rng.choice([24.0, 25.0])))


def two_rates(seed: int, rng: np.random.Generator) -> Shot:
    """A label that slips on its record."""
    return _plain("two rates", seed, rng, disc="print", inner_share=float(rng.uniform(0.6, 1.4)))


def locked_flicker(seed: int, rng: np.random.Generator) -> Shot:
    """A locked shutter, and a lamp whose flicker nearly keeps step with the frames."""
    return _plain("locked exposure, flicker", seed, rng, flicker=float(rng.uniform(0.1, 0.4)),
                  fps=25 - float(rng.uniform(0.002, 0.02)))


def creeping(seed: int, rng: np.random.Generator) -> Shot:
    """A holder that gives way slowly: the camera rolls by 0.03 to 2° while it films."""
    shot = _plain("creeping", seed, rng, seconds=12.0)
    creep = float(np.radians(10 ** rng.uniform(-2.6, -0.8)) * rng.choice([-1, 1]))
    return _seen(shot, creep_rad_s=creep)


CATEGORIES: dict[str, Callable[[int, np.random.Generator], Shot]] = {
    f.__name__: f for f in (
        plain, exposure_drift, hand_held, bump, interlaced, small, dark, partly_hidden, inset,
        recorder, lamps, spin, no_mark, mark_leaves, edge_on, from_the_side, cut,
        pulldown, two_rates, locked_flicker, creeping)
}


def shot(category: str, seed: int) -> Shot:
    """The clip of a category and a seed."""
    number = list(CATEGORIES).index(category)
    return CATEGORIES[category](seed, np.random.default_rng([seed, number]))
