"""Phase tracks of a plate whose motor is started or stopped while it is filmed."""

from dataclasses import dataclass

import numpy as np

from tests.vision.phase_tracks import RPM, FloatArray, phase_track
from vision.phase_track import PhaseTrack

STEP_S = 1e-3  #: of the integration of the rate


@dataclass(frozen=True, eq=False)
class MotorTrack:
    """A track, the rate between start and stop, and the turns that it lasts."""

    track: PhaseTrack
    rate_rad_s: float
    turns: float


def motor_track(rng: np.random.Generator) -> MotorTrack:
    """A start, a stop or both, of a motor of one of three kinds; noise and wow as of a clip."""
    fps = float(rng.choice([25, 30, 60]))
    rpm = float(rng.choice([16.67, 33.3, 45, 78]))
    starts, stops = ((1, 0), (0, 1), (1, 1))[rng.integers(3)]
    turns, still, tau = rng.uniform(4, 15), rng.uniform(0.3, 2), rng.uniform(0.2, 1.5)
    off_s = starts * (still + 6 * tau) + turns * 60 / rpm
    fall_s = rng.uniform(0.5, 4)
    fine_s = np.arange(0, off_s + (fall_s + 1) * stops, STEP_S)
    share = np.ones_like(fine_s)
    if starts:
        share = _run_up(rng, np.maximum(fine_s - still, 0), tau)
    if stops:
        past = np.maximum(fine_s - off_s, 0)
        brakes = rng.random() < 0.5
        share *= np.clip(1 - past / fall_s, 0, 1) if brakes else np.exp(-3 * past / fall_s)
    turned = rpm * RPM * np.cumsum(share) * STEP_S
    time = np.arange(int(fine_s[-1] * fps)) / fps
    angle = np.interp(time, fine_s, turned)
    angle += rng.uniform(0, 1.5e-3) * np.sin(angle + rng.uniform(0, 6))
    track = phase_track(time, angle, noise_rad=float(10 ** rng.uniform(-4, -2.9)),
                        seed=int(rng.integers(1 << 30)))
    return MotorTrack(track, rpm * RPM, turns)


def _run_up(rng: np.random.Generator, past_s: FloatArray, tau_s: float) -> FloatArray:
    """Share of the rate: a motor with friction, one with a controller that rings, or a ramp."""
    kind = rng.integers(3)
    if kind == 0:
        return np.asarray(1 - np.exp(-past_s / tau_s))
    if kind == 1:
        damping, natural = rng.uniform(0.4, 0.9), 3 / tau_s
        rings = natural * np.sqrt(1 - damping**2)
        wave = np.cos(rings * past_s) + damping * natural / rings * np.sin(rings * past_s)
        return np.asarray(1 - np.exp(-damping * natural * past_s) * wave)
    return np.clip(past_s / (3 * tau_s), 0, 1)
