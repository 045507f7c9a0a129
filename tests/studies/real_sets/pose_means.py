"""An independent fit of a table of pose means (kerf: 30 poses of an MPU-6050, in counts)."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calib.poses.imu_log import FloatArray
from tests.studies.real_sets.independent import LEAST_LEFT, magnitudes
from tests.studies.real_sets.logs import REAL

TABLE = REAL / "kerf/mpu6050_board1_cal_data.txt"
GRAVITY, COUNTS_PER_G = 9.80665, 16384.0
CONFIGURATION = f"""
sensor: {{accelerometer: {{full_scale_g: 2, bits: 16, encoding: twos-complement}}}}
site: {{gravity_m_s2: {GRAVITY}}}
accelerometer:
  poses: {{means: {TABLE}, columns: [acc_x, acc_y, acc_z]}}
"""


@dataclass(frozen=True, eq=False)
class FittedMeans:
    """Counts per m/s² of each axis, rms within and of poses left out, m/s²."""

    scale: FloatArray
    rms: float
    left_out: float


def fit_means() -> FittedMeans:
    """Every pose counts alike."""
    readings = np.loadtxt(TABLE, delimiter=",") / COUNTS_PER_G * GRAVITY
    start = [1, 0, 0, 1, 0, 1, 0, 0, 0]
    solution = least_squares(lambda x: magnitudes(x, readings) - GRAVITY, start)
    hat = np.diag(solution.jac @ np.linalg.pinv(solution.jac))
    out = solution.fun / np.maximum(1 - hat, LEAST_LEFT)
    return FittedMeans(COUNTS_PER_G / GRAVITY / solution.x[[0, 3, 5]],
                       float(np.sqrt(np.mean(solution.fun**2))), float(np.sqrt(np.mean(out**2))))
