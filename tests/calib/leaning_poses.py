"""Poses of a gyroscope on a plate that leans, simulated sample by sample."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.pose_set import PoseSet
from tests.fitting import pose_sets
from tests.world.designs import SLOW, paper_design
from tests.world.hidden import Hidden
from tests.world.imu import mpu6050
from tests.world.make_data import G_SENSITIVITY_DEG_S_PER_G, WOW
from tests.world.plate import PlateMotion
from tests.world.session import simulate

PER_SI = np.radians(G_SENSITIVITY_DEG_S_PER_G) / 9.80665


@lru_cache
def gyro_poses(
    tilt_deg: float, hide: bool = True, wow: float = 1.0, rate: float = SLOW, seed: int = 1,
    heading_deg: float = 0.0, noise: float = 1.0,
) -> tuple[PoseSet, TriadSpec]:
    """The published design with an MPU-6050 on a plate that leans about this heading.

    ``wow`` and ``noise`` are times an ordinary one.
    """
    motion = PlateMotion(rate, wow=tuple((order, wow * size, at) for order, size, at in WOW))
    design = paper_design(mpu6050().with_noise(noise), motion)
    about = np.radians([heading_deg])
    lean = np.radians(tilt_deg) * np.concatenate([np.cos(about), np.sin(about)])
    table = replace(design.turntable, tilt_rad=(float(lean[0]), float(lean[1])))
    design = replace(design, turntable=table, sample_rate_hz=25.0)
    hidden = (Hidden("g_sensitivity", "gyroscope", PER_SI),) if hide else ()
    _, gyro, specs = pose_sets(simulate(design, seed, hidden))
    return gyro, specs[1]
