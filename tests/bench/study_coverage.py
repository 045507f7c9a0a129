"""Whether the stated sds are honest: simulated sessions by the hundred, counted.

    python -m tests.bench.study_coverage paper --seeds 500
    python -m tests.bench.study_coverage rich --seeds 100

Every session is a fresh evening with another unit of the sensor: gains, offsets and axes drawn.
Printed is the spread of (estimate - truth)/sd of every parameter of both triads and of the stated
rate, and the largest difference between the two solvers: in rad, and relative for biases and
scales. A spread of 500 draws is itself known to 3 %.
"""

import argparse
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import FitFailed
from calib.fit.angrisano import fit_paper
from calib.fit.calibration import TriadParameters, calibrate_triad
from calib.fit.model import Model
from calib.fit.solver import fit
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray
from calib.poses.pose_set import PoseSet
from tests.bench.trials import DESIGNS
from tests.fitting import pose_sets
from tests.world.bench import Design
from tests.world.imu import MPU_SPREAD, MTI_SPREAD, another_unit
from tests.world.session import simulate

GROUPS = ("misalignment_rad", "bias_counts", "scale_counts_per_unit")


@dataclass(frozen=True, eq=False)
class Draw:
    """One session: (estimate - truth)/sd by triad (9,), of the rates, and the solvers' distance.

    ``refused`` counts the triads that the paper's iteration did not reach from the data sheet.
    """

    deviations: dict[str, FloatArray]
    rates: FloatArray
    solvers_apart: float
    refused: int


def another_evening(design: Design, seed: int) -> Design:
    """The same experiment with another unit of the same sensor."""
    spread = MTI_SPREAD if "MTi" in design.sensor.name else MPU_SPREAD
    unit = another_unit(design.sensor, spread, np.random.default_rng([seed, 50]))
    return replace(design, sensor=unit)


def by_paper(poses: PoseSet, spec: TriadSpec) -> TriadParameters | None:
    """The paper's iteration from the data sheet; None where that is too far away."""
    try:
        with np.errstate(all="ignore"):  # an iteration that diverges overflows before it ends
            return calibrate_triad(fit_paper(poses, Model.of(BASE), spec), spec).parameters
    except FitFailed:
        return None


def draw(design: Design, seed: int) -> Draw:
    """Simulate, calibrate with both solvers, and compare with the truth."""
    session = simulate(another_evening(design, seed), seed)
    *pose_set_of, specs = pose_sets(session)
    deviations, apart, refused = {}, 0.0, 0
    model = Model.of(BASE)
    for triad, poses, spec in zip(TRIADS, pose_set_of, specs, strict=True):
        found = calibrate_triad(fit(poses, model), spec).parameters
        paper = by_paper(poses, spec)
        refused += paper is None
        truth = getattr(session, triad)
        z = []
        for group, sd in zip(GROUPS, found.sd, strict=True):
            value = getattr(found, group)
            z.append((value - getattr(truth, group)) / sd)
            if paper is not None:
                other = getattr(paper, group)
                size = 1.0 if group == "misalignment_rad" else np.abs(value).max()
                apart = max(apart, float(np.abs(value - other).max() / size))
        deviations[triad] = np.concatenate(z)
    rates = [
        (rate.rate_rad_s - rate.true_rad_s) / rate.sd_rad_s for rate in session.rates.values()
    ]
    return Draw(deviations, np.array(rates), apart, refused)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("design", choices=[name for name in DESIGNS if name != "soak"])
    parser.add_argument("--seeds", type=int, default=500)
    asked = parser.parse_args()
    design = DESIGNS[asked.design]()
    found = [draw(design, seed) for seed in range(asked.seeds)]
    print(f"{asked.design}, {asked.seeds} sessions: spread (and mean) of (estimate - truth)/sd")
    for triad in TRIADS:
        z = np.array([each.deviations[triad] for each in found])
        for i, group in enumerate(GROUPS):
            part = z[:, 3 * i : 3 * i + 3]
            values = "  ".join(
                f"{axis} {np.sqrt(np.mean(v**2)):.3f} ({v.mean():+.3f})"
                for axis, v in zip("xyz", part.T, strict=True)
            )
            print(f"  {triad:14s} {group:22s} {values}")
    rates = np.concatenate([each.rates for each in found])
    print(f"  stated rate: {np.sqrt(np.mean(rates**2)):.3f} ({rates.mean():+.3f})")
    apart = max(each.solvers_apart for each in found)
    refused = sum(each.refused for each in found)
    print(f"  solvers apart by {apart:.1e} at most; the paper's iteration did not "
          f"converge from the data sheet in {refused} of {2 * len(found)} fits")


if __name__ == "__main__":
    main()
