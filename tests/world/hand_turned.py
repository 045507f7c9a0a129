"""A sensor that is turned by hand, on a gimbal or on a table, sample by sample.

The case follows a chain of rotations: rests, in which a hand trembles and slowly gives way or a
table does neither, and moves from one rest to the next, in which the hand also pushes. What the
axes read follows from the rotation and the push alone; nothing here knows how rests are looked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

GRAVITY_M_S2 = 9.80665
TREMOR_HZ = (6.0, 12.0)  #: physiological tremor of a hand
TREMOR_WAVES = 5
MOVE_S = (0.7, 1.8)
PUSH_M_S2 = 4.0  #: largest acceleration of the hand in a move

#: Of the sensor: what gain, axes and zero make of the specific force, and its noise.
MIXING = np.array([[1.012, 0.006, -0.009], [0.0, 0.991, 0.012], [0.0, 0.0, 1.004]])
OFFSET_M_S2 = np.array([0.12, -0.08, 0.21])
GYRO_OFFSET_RAD_S = np.array([0.011, -0.02, 0.006])


@dataclass(frozen=True)
class Stop:
    """One rest: how long, sd of the tremor per axis, how fast the attitude gives way."""

    seconds: float
    tremor_m_s2: float = 0.0
    drift_deg_s: float = 0.0


@dataclass(frozen=True, eq=False)
class HandTurned:
    """What was logged, SI: times (t,), both triads (t, 3), and when each rest began and ended."""

    time_s: FloatArray
    force_m_s2: FloatArray
    rate_rad_s: FloatArray
    rests: tuple[tuple[float, float], ...]


def by_hand(seed: int, count: int = 24, tremor_m_s2: float = 0.04) -> list[Stop]:
    """Stops of 0.7 to 10 s in a hand that trembles and gives way, each in its own measure."""
    rng = np.random.default_rng(seed)
    seconds = np.exp(rng.uniform(np.log(0.7), np.log(10.0), count))
    return [Stop(float(s), tremor_m_s2 * float(rng.uniform(0.5, 1.5)), float(rng.uniform(0, 0.2)))
            for s in seconds]


def on_gimbal(count: int = 20, seconds: float = 3.0) -> list[Stop]:
    """Stops of a gimbal, as quiet as the sensor."""
    return [Stop(seconds) for _ in range(count)]


def turn_through(
    stops: Sequence[Stop], seed: int, rate_hz: float = 100.0, noise_m_s2: float = 0.02,
    noise_rad_s: float = 0.002,
) -> HandTurned:
    """Log the stops one after another, with a move between each two, in attitudes drawn anew."""
    rng = np.random.default_rng(seed)
    attitude = Rotation.random(random_state=rng)
    turned: list[Rotation] = []
    pushed: list[FloatArray] = []
    rests: list[tuple[float, float]] = []
    now = 0
    for i, stop in enumerate(stops):
        n = max(2, round(stop.seconds * rate_hz))
        rests.append((now / rate_hz, (now + n) / rate_hz))
        path = _give_way(attitude, n, stop.drift_deg_s / rate_hz, rng)
        turned.append(path)
        pushed.append(_tremor(n, rate_hz, stop.tremor_m_s2, rng))
        now += n
        if i + 1 == len(stops):
            break
        following = Rotation.random(random_state=rng)
        m = round(rng.uniform(*MOVE_S) * rate_hz)
        turned.append(_turn(path[-1], following, m))
        pushed.append(_push(m, rng))
        attitude = following
        now += m
    path = Rotation.concatenate(turned)
    gravity = path.inv().apply([0.0, 0.0, GRAVITY_M_S2])
    force = (gravity + np.concatenate(pushed)) @ MIXING.T + OFFSET_M_S2
    rate = (path[:-1].inv() * path[1:]).as_rotvec() * rate_hz
    rate = np.vstack([rate, rate[-1:]]) + GYRO_OFFSET_RAD_S
    return HandTurned(
        np.arange(now) / rate_hz,
        force + noise_m_s2 * rng.standard_normal(force.shape),
        rate + noise_rad_s * rng.standard_normal(rate.shape),
        tuple(rests),
    )


def _give_way(
    attitude: Rotation, n: int, step_deg: float, rng: np.random.Generator
) -> Rotation:
    """The attitude turned by so much at every sample, about an axis of its own."""
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    return attitude * Rotation.from_rotvec(np.radians(step_deg) * np.arange(n)[:, None] * axis)


def _turn(start: Rotation, end: Rotation, n: int) -> Rotation:
    """From one attitude to the other, beginning and ending at rest."""
    share = (1 - np.cos(np.pi * (np.arange(n) + 1) / (n + 1))) / 2
    return start * Rotation.from_rotvec(share[:, None] * (start.inv() * end).as_rotvec())


def _push(n: int, rng: np.random.Generator) -> FloatArray:
    """Speeding up and slowing down again: a whole wave, so that the hand ends at rest."""
    wave = np.sin(2 * np.pi * (np.arange(n) + 1) / (n + 1))
    direction = rng.standard_normal(3)
    direction *= rng.uniform(0.3, 1.0) * PUSH_M_S2 / np.linalg.norm(direction)
    return np.asarray(wave[:, None] * direction)


def _tremor(n: int, rate_hz: float, sd: float, rng: np.random.Generator) -> FloatArray:
    """Waves of about ten hertz, of the given sd on every axis."""
    time_s = np.arange(n)[:, None, None] / rate_hz
    hz = rng.uniform(*TREMOR_HZ, (TREMOR_WAVES, 3))
    phase = rng.uniform(0, 2 * np.pi, (TREMOR_WAVES, 3))
    waves = np.sin(2 * np.pi * hz * time_s + phase).sum(axis=1)
    return np.asarray(sd * waves / np.sqrt(TREMOR_WAVES / 2))
