"""Poses of an accelerometer that turns with the plate, simulated sample by sample."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from calib.poses.attitudes import natural_directions
from calib.poses.pose_set import PoseSet, pose_set
from calib.poses.runs.reference_runs import gravity_run
from tests.fitting import averaged, specs_of
from tests.world.bench import Design, Run, Turntable
from tests.world.imu import mpu6050
from tests.world.plate import PlateMotion
from tests.world.session import simulate

CHIP_M = (0.06, 0.03, -0.02)
RPM = np.pi / 30


@lru_cache
def on_the_plate(seed: int, rpm: tuple[float, ...]) -> PoseSet:
    """An accelerometer 70 mm off the spindle, at rest and on the turning plate."""
    sensor = replace(mpu6050(), chip_m=np.array(CHIP_M))
    runs = tuple(
        Run(f"{each:g}", PlateMotion(each * RPM) if each else None, natural_directions(),
            seconds=20.0, in_accelerometer_section=True, lead_s=60.0)
        for each in rpm
    )  # fmt: skip
    table = Turntable(offset_m=(0.0, 0.0), placement_sd_m=0.0, tilt_rad=(0.0, 0.0))
    design = Design(title="lever", sensor=sensor, runs=runs, turntable=table, jitter_deg=2.0,
                    sample_rate_hz=50.0)  # fmt: skip
    session = simulate(design, seed)
    gravity = session.design.site.gravity_m_s2
    return pose_set("accelerometer", [
        gravity_run(run.run.name, averaged(run, specs_of(sensor), each * RPM), gravity, 0.0)
        for run, each in zip(session.runs, rpm, strict=True)
    ], 0.0)  # fmt: skip
