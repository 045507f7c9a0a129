"""How well the mounting of a sensor is found: simulated calibrations, mountings and drives.

    python -m tests.bench.study_installation sphere --trials 500
    python -m tests.bench.study_installation yaw --trials 200

``sphere`` draws mountings over all orientations, in both rotation orders and in the order of
eq. (6), with the paper's evening of calibration (18 poses of 8 s) and a still log of each length:
errors in degrees and the share of 1.96-sd intervals that hold the truth. ``yaw`` adds drives.
"""

import argparse
import math

import numpy as np
from scipy.spatial.transform import Rotation

from calib.mounting.levelling import ORDERS
from calib.mounting.mounting import MountingLogs, mounting_from_logs
from tests.calib.mounting.simulated_reading import (
    TRIAD,
    G,
    Mounted,
    angles_off,
    calibration,
    drive,
    vehicle_to_sensor,
)
from tests.world.imu import mti

MOUNTINGS_PER_CALIBRATION = 5
NEAR_LOCK = 0.95  # next to the lock of a forced order an angle means little


def sphere(trials: int) -> None:
    """Roll and pitch: noise of the sensor, seconds of log, order."""
    print(" noise  log s  order    rms °    max °     sd °   95 %")
    for noise, seconds in ((0.1, 30.0), (1.0, 30.0), (1.0, 12.0), (1.0, 3.0)):
        triad = mti().with_noise(noise).accelerometer
        for order in (*ORDERS, None):
            errors, scores, sds = [], [], []
            rng = np.random.default_rng(1)
            while len(errors) < trials:
                seed = len(errors)
                rotation = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
                if order is not None and abs(rotation[ORDERS.index(order), 2]) > NEAR_LOCK:
                    continue
                evening = calibration(seed // MOUNTINGS_PER_CALIBRATION, noise)
                log = Mounted(triad, rotation).still(seconds, seed)
                found = mounting_from_logs(MountingLogs([log]), evening, G, order=order)
                errors.append(angles_off(found, rotation))
                scores.append(errors[-1] / found.sd_rad)
                sds.append(found.sd_rad)
            off = np.degrees(errors)
            print(
                f"{noise:6g} {seconds:6g} {order or 'eq. 6':>6} {off.std():8.4f} "
                f"{np.abs(off).max():8.4f} {np.degrees(np.mean(sds)):8.4f} "
                f"{100 * np.mean(np.abs(scores) < 1.96):6.1f}"
            )


def yaw(trials: int) -> None:
    """Yaw from drives of each length."""
    print(" drive s    rms °    max °     sd °   95 %")
    for seconds in (30.0, 60.0, 180.0):
        errors, sds = [], []
        for seed in range(trials):
            rng = np.random.default_rng([2, seed])
            roll, pitch, angle = rng.uniform([-3.1, -1.4, -3.1], [3.1, 1.4, 3.1])
            mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", roll, pitch, angle))
            found = mounting_from_logs(
                MountingLogs(
                    [mounted.still(12, seed)], drive=[mounted.log(drive(seconds, seed), seed)]
                ),
                calibration(seed // MOUNTINGS_PER_CALIBRATION),
                G,
                order="xyz",
            )
            assert found.yaw is not None
            errors.append(math.remainder(found.yaw.yaw_rad - angle, 2 * math.pi))
            sds.append(found.yaw.sd_rad)
        off, sd = np.degrees(errors), np.degrees(sds)
        print(
            f"{seconds:8g} {off.std():8.3f} {np.abs(off).max():8.3f} {sd.mean():8.3f} "
            f"{100 * np.mean(np.abs(off / sd) < 1.96):6.1f}"
        )


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    questions = {"sphere": sphere, "yaw": yaw}
    parser.add_argument("question", choices=questions)
    parser.add_argument("--trials", type=int, default=200)
    asked = parser.parse_args()
    questions[asked.question](asked.trials)


if __name__ == "__main__":
    main()
