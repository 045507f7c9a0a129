"""A sensor in a hand: eighteen rests with turns between them, and what other tools make of it."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

REST_S, TURN_S = 2.0, 1.0
GRAVITY_M_S2 = 9.80665
NOISE_M_S2, NOISE_RAD_S = 0.01, 0.001
ACC_SCALE = np.array([1.02, 0.98, 1.01])
ACC_BIAS = np.array([0.12, -0.2, 0.25])
FIELD = np.array([0.45, 0.0, -0.893])  #: direction in middle latitudes
PUSHES_HZ = np.array([1.3, 2.9, 4.7])
GYR_BIAS = np.array([0.02, -0.015, 0.01])


@dataclass(frozen=True, eq=False)
class HandLog:
    """Readings in SI units: ``time_s`` (t,), ``acc`` and ``gyr`` (t, 3), ``rest`` (t,) or -1.

    ``field`` (t, 3) is the direction of the magnetic field in the axes of the sensor.
    """

    time_s: np.ndarray
    acc: np.ndarray
    gyr: np.ndarray
    rest: np.ndarray
    rate_hz: float
    field: np.ndarray


def hand_log(
    seed: int = 0, rests: int = 18, rate_hz: float = 100.0, push_m_s2: float = 0.0,
    rpm: float = 0.0,
) -> HandLog:
    """Rests in random attitudes, each turn along the shortest way at a steady rate.

    While it turns, a hand pushes it to and fro by ``push_m_s2``. The second half of the rests are
    on a level plate that turns at ``rpm``.
    """
    rng = np.random.default_rng(seed)
    period = REST_S + TURN_S
    time_s = np.arange(round(rests * period * rate_hz)) / rate_hz
    attitudes = Rotation.random(rests + 1, random_state=seed)
    keys, knots = [], []
    for i in range(rests):
        keys += [i * period, i * period + REST_S]
        knots += [attitudes[i], attitudes[i]]
    keys.append(rests * period)
    knots.append(attitudes[rests])
    path = Slerp(keys, Rotation.concatenate(knots))
    on_plate = (time_s % period < REST_S) & (time_s > keys[-1] / 2)
    step = np.where(on_plate, rpm * np.pi / 30 / rate_hz, 0.0)
    plate = Rotation.from_rotvec(np.outer(np.cumsum(step) - step, [0, 0, 1]))
    # Body to world; the turn from one sample to the next is what the gyroscope reads.
    now = plate * path(time_s)
    after = (plate * Rotation.from_rotvec(np.outer(step, [0, 0, 1]))
             * path(np.minimum(time_s + 1 / rate_hz, keys[-1])))
    rate = (now.inv() * after).as_rotvec() * rate_hz
    force = now.inv().apply([0.0, 0.0, GRAVITY_M_S2])
    acc = force * ACC_SCALE + ACC_BIAS + rng.normal(0, NOISE_M_S2, (len(time_s), 3))
    gyr = rate + GYR_BIAS + rng.normal(0, NOISE_RAD_S, (len(time_s), 3))
    index = (time_s // period).astype(int)
    rest = np.where(time_s % period < REST_S, index, -1)
    push = push_m_s2 * np.sin(2 * np.pi * np.outer(time_s, PUSHES_HZ) + PUSHES_HZ)
    acc += np.where(rest[:, None] < 0, push, 0.0)
    return HandLog(time_s, acc, gyr, rest, rate_hz, now.inv().apply(FIELD))
