"""What a hidden effect of the bench does: to the plate's rate, to gravity, to the floor."""

from dataclasses import replace

import numpy as np

from tests.world.bench import Design, Run
from tests.world.hidden import Hidden


def disturbed_run(run: Run, begin_s: float, hidden: tuple[Hidden, ...]) -> Run:
    """The run as the plate really turns; its clip was taken at power-on, undisturbed.

    That of a plate that drifts was taken ``filmed_s`` of its detail later, or with a share
    ``filmed`` of each run behind it.
    """
    motion = run.motion
    for effect in hidden:
        if motion is None or effect.triad != "gyroscope":
            continue
        rate, size = motion.rate_rad_s, effect.size
        if effect.name == "reference_offset":
            motion = replace(motion, rate_rad_s=rate + np.sign(rate) * float(size))
        elif effect.name == "reference_scale":
            motion = replace(motion, rate_rad_s=rate * (1 + float(size)))
        elif effect.name == "reference_drift":
            filmed_s = float(effect.detail.get("filmed_s", 0.0))
            if "filmed" in effect.detail:
                filmed_s = begin_s + float(effect.detail["filmed"]) * run.length_s
            motion = replace(
                motion,
                rate_rad_s=rate * (1 + float(size) * (begin_s - filmed_s)),
                drift_rad_s2=motion.drift_rad_s2 + rate * float(size),
            )
        elif effect.name == "direction_dependent_rate":
            motion = replace(motion, rate_rad_s=rate * (1 + np.sign(rate) * float(size)))
        elif effect.name == "plate_wander":
            motion = replace(motion, wow=(*motion.wow, *_slow_wow(effect, rate, begin_s)))
    return replace(run, motion=motion)


def _slow_wow(
    effect: Hidden, rate_rad_s: float, begin_s: float
) -> tuple[tuple[float, float, float], ...]:
    """Waves of the plate's rate that last minutes, as waves per revolution."""
    rng = np.random.default_rng(int(effect.detail["draw"]))
    waves = []
    for period_s in rng.uniform(60.0, 600.0, 4):
        phase = rng.uniform(0, 2 * np.pi) + 2 * np.pi * begin_s / period_s
        order = 2 * np.pi / (period_s * abs(rate_rad_s))
        waves.append((order, float(effect.size) / 2, phase))
    return tuple(waves)


def true_gravity(design: Design, hidden: tuple[Hidden, ...]) -> float:
    """Gravity as it is; the session states ``design.site.gravity_m_s2``."""
    gravity = design.site.gravity_m_s2
    for effect in hidden:
        if effect.triad == "accelerometer" and effect.name == "reference_scale":
            gravity *= 1 + float(effect.size)
        elif effect.triad == "accelerometer" and effect.name == "reference_offset":
            gravity += float(effect.size)
    return gravity


def floor_rate(hidden: tuple[Hidden, ...]) -> float:
    """Unstated rotation of the whole bench about the vertical, in rad/s."""
    return float(sum(effect.size for effect in hidden if effect.name == "earth_rate"))
