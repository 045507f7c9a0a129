"""An evening with a sensor in a cube that stands on its six faces."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.world.designs import SLOW, paper_design, still_run, turning_run
from tests.world.imu import MPU_SPREAD, another_unit, mpu6050
from tests.world.plate import PlateMotion
from tests.world.session import Session, simulate

SD_DEG = 0.2  #: of every angle that it stands at
FACES = np.vstack([np.eye(3), -np.eye(3)])
FIRST = 71_000


@cache
def evening(seed: int, times: int = 1, sd_deg: float = SD_DEG) -> Session:
    """Six faces of a cube at rest and on the plate, each ``times`` over, and a unit of its own."""
    unit = another_unit(mpu6050(), MPU_SPREAD, np.random.default_rng([FIRST + seed, 1]))
    faces = np.tile(FACES, (times, 1))
    design = replace(
        paper_design(unit), jitter_deg=sd_deg,
        runs=(still_run(faces), turning_run("17rpm", PlateMotion(SLOW), faces)))
    return simulate(design, FIRST + seed)
