"""Whether a calibration states what it will err by where its poses cannot see an effect.

    python -m tests.bench.study_unseen --seeds 40

The published design with an MPU-6050, fresh evenings: 18 poses at rest, 18 on a plate at one speed,
with and without a g-sensitivity whose nine elements are drawn from a normal distribution of the
typical size. Ideal readings of the same unit under rates and gravity in random directions are
corrected, and the error of the magnitude held against the stated sd, the median over all directions
and that of its own direction.
"""

import argparse
from dataclasses import replace

import numpy as np

from calib.assess import assess
from calib.effects.catalogue import BASE
from calib.fit.model import Model
from calib.poses.conditions import Conditions
from calib.poses.imu_log import TRIADS, FloatArray
from tests.fitting import pose_sets
from tests.world.bench import Design
from tests.world.designs import SLOW, paper_design
from tests.world.hidden import Hidden
from tests.world.imu import G_STANDARD, MPU_SPREAD, another_unit, mpu6050
from tests.world.physics import triad_of
from tests.world.session import simulate

TYPICAL = np.deg2rad(0.1) / G_STANDARD  #: (rad/s)/(m/s²), of an MPU-6050
FRESH = 31_000  #: first seed
DIRECTIONS = 200  #: of rate and gravity in one session


def evening(seed: int, tilt_deg: float, rate_hz: float) -> tuple[Design, FloatArray]:
    """The design with a unit of its own, and a g-sensitivity for it, (rad/s)/(m/s²)."""
    rng = np.random.default_rng([FRESH + seed, 99])
    design = paper_design(another_unit(mpu6050(), MPU_SPREAD, rng))
    table = replace(design.turntable, tilt_rad=(np.deg2rad(tilt_deg), 0.0))
    size = TYPICAL * rng.standard_normal((3, 3))
    return replace(design, turntable=table, sample_rate_hz=rate_hz), size


def deviations(
    seed: int, hide: bool, tilt_deg: float, rate_hz: float
) -> dict[str, tuple[FloatArray, float]]:
    """Errors of ideal readings in sds, (2, n), and the stated median sd, SI, by triad.

    In the stated median, and in that of the nearest direction.
    """
    design, size = evening(seed, tilt_deg, rate_hz)
    hidden = (Hidden("g_sensitivity", "gyroscope", size),) if hide else ()
    *sets, specs = pose_sets(simulate(design, FRESH + seed, hidden))
    rng = np.random.default_rng([FRESH + seed, 98])
    unit = rng.standard_normal((2, DIRECTIONS, 3))
    unit /= np.linalg.norm(unit, axis=2, keepdims=True)
    force = design.site.gravity_m_s2 * unit[0]
    acts = {"accelerometer": force, "gyroscope": SLOW * unit[1]}
    found = {}
    for name, poses, spec in zip(TRIADS, sets, specs, strict=True):
        assessed = assess(poses, Model.of(BASE), spec)
        triad = triad_of(design, name)
        felt = triad.project(acts[name])
        if hide and name == "gyroscope":
            felt = felt + force @ size.T
        nominal = spec.nominal(spec.signed(felt * triad.gain + triad.offset))
        corrected = assessed.calibration.correct(Conditions.of_vectors(nominal))
        error = np.linalg.norm(corrected, axis=1) - np.linalg.norm(acts[name], axis=1)
        assert assessed.prediction is not None
        stated = assessed.prediction
        nearest = np.argmax(corrected @ stated.directions.T, axis=1)
        sds = np.stack([np.full_like(error, stated.sd_median), stated.sd[0, nearest]])
        found[name] = (error / sds, stated.sd_median)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--tilt", type=float, nargs="*", default=[0.3])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--rate-hz", type=float, default=50.0)
    asked = parser.parse_args()
    for tilt in asked.tilt:
        for hide in (True, False):
            sessions = [deviations(seed, hide, tilt, asked.rate_hz)
                        for seed in range(asked.first, asked.first + asked.seeds)]
            for name in TRIADS:
                z = np.hstack([each[name][0] for each in sessions])
                stated = np.median([each[name][1] for each in sessions])
                of_both = "; ".join(
                    f"in {kind} rms {np.sqrt(np.mean(one**2)):.2f}, within one "
                    f"{100 * np.mean(np.abs(one) < 1):.0f} %, two "
                    f"{100 * np.mean(np.abs(one) < 2):.0f} %"
                    for kind, one in zip(("median sds", "sds of the direction"), z, strict=True))
                print(f"tilt {tilt:g}°, {'hidden' if hide else 'nothing'}, {name}: stated "
                      f"{stated:.3g} SI; {of_both}", flush=True)


if __name__ == "__main__":
    main()
