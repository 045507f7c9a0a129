"""How well the mounting of a sensor is found: simulated calibrations and mountings.

    python -m tests.bench.study_installation --trials 500

Mountings are drawn over all orientations, in both rotation orders and in the order of eq. (6),
with the paper's evening of calibration (18 poses of 8 s) and a still log of each length: errors in
degrees and the share of 1.96-sd intervals that hold the truth.
"""

import argparse

import numpy as np
from scipy.spatial.transform import Rotation

from calib.mounting.levelling import ORDERS
from calib.mounting.mounting import mounting_from_logs
from tests.calib.mounting.simulated_reading import (
    G,
    Mounted,
    angles_off,
    calibration,
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
                found = mounting_from_logs([log], evening, G, order=order)
                errors.append(angles_off(found, rotation))
                scores.append(errors[-1] / found.sd_rad)
                sds.append(found.sd_rad)
            off = np.degrees(errors)
            print(
                f"{noise:6g} {seconds:6g} {order or 'eq. 6':>6} {off.std():8.4f} "
                f"{np.abs(off).max():8.4f} {np.degrees(np.mean(sds)):8.4f} "
                f"{100 * np.mean(np.abs(scores) < 1.96):6.1f}"
            )


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=200)
    sphere(parser.parse_args().trials)


if __name__ == "__main__":
    main()
