"""An independent fit of a gyroscope on somebody else's record player (freeimucal).

Each log is cut into the blocks of 100 samples in which it was recorded; a block counts where its
magnitude is steady. One pose is what follows in the same attitude: its blocks share one weight.

    |M (w - b)| = rate       turning;        w = b       at rest
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calib.poses.imu_log import FloatArray
from tests.studies.real_sets.independent import magnitudes
from tests.studies.real_sets.logs import REAL, numbers_in

BLOCK, RATE_HZ = 100, 69.0
STEADY, NEAR_RATE, SAME_ATTITUDE = 0.01, 0.2, 0.05
RPM = {"0RPMgyr": 0.0, "33RPMgyr": 100 / 3, "45RPMgyr": 45.0}

CONFIGURATION = "\n".join([
    "sensor: {gyroscope: {unit: rad_s}}",
    "rate:",
    *(f"  r{rpm:.0f}: {{rate_rad_s: {rpm * np.pi / 30:.6f}, sd_rad_s: 0.001}}"
      for rpm in RPM.values() if rpm),
    "gyroscope:",
    "  runs:",
    *(f"  - {{rate: {f'r{rpm:.0f}' if rpm else 'stopped'}, poses: {{log: {REAL}/freeimucal/"
      f"{name}.txt.gz, columns: [gyr_x, gyr_y, gyr_z], sample_rate_hz: {RATE_HZ:g}, find: still}}}}"
      for name, rpm in RPM.items()),
    "",
])


@dataclass(frozen=True, eq=False)
class Turntable:
    """What the independent fit says: gain per axis (paper's k⁻¹), relative scatter of the poses."""

    poses: int
    gain: FloatArray
    scatter: float
    rest_sd: float


def poses_of(name: str, rate: float) -> FloatArray:
    """Means (n, 3) of the poses of one log."""
    values = numbers_in(REAL / f"freeimucal/{name}.txt.gz", 3)
    means: list[list[FloatArray]] = []
    for i in range(0, len(values) - BLOCK + 1, BLOCK):
        block = values[i : i + BLOCK]
        size = np.linalg.norm(block, axis=1)
        moving = size.std() > STEADY * max(rate, 1.0) or np.ptp(block, axis=0).max() > 0.1
        if moving or abs(np.linalg.norm(block.mean(axis=0)) - rate) > NEAR_RATE * max(rate, 1.0):
            continue
        mean = block.mean(axis=0)
        if means and rate and np.linalg.norm(means[-1][-1] - mean) < SAME_ATTITUDE * rate:
            means[-1].append(mean)
        else:
            means.append([mean])
    return np.array([np.mean(each, axis=0) for each in means])


def fit_turntable() -> Turntable:
    """All three logs together; the plate's rate scatters, so every pose counts alike."""
    rates = {name: rpm * np.pi / 30 for name, rpm in RPM.items()}
    poses = {name: poses_of(name, rate) for name, rate in rates.items()}
    rest = poses["0RPMgyr"]
    bias = np.median(rest, axis=0)

    def residual(x: FloatArray) -> FloatArray:
        turning = [magnitudes(x, poses[name]) / rate - 1 for name, rate in rates.items() if rate]
        return np.concatenate([*turning, (x[6:9] - bias) / 3.5])

    start = np.r_[1, 0, 0, 1, 0, 1, bias]
    x = least_squares(residual, start, loss="soft_l1", f_scale=1e-3).x
    turning = np.concatenate(
        [magnitudes(x, poses[name]) / rate - 1 for name, rate in rates.items() if rate])
    return Turntable(
        len(turning), 1 / x[[0, 3, 5]], float(np.median(np.abs(turning)) / 0.6745),
        float(np.median(np.abs(rest - bias)) / 0.6745))
