"""One simulated session and how far its estimates are from the truth, in their stated sds.

The study counts hundreds of them (tests/bench/study_coverage.py), a test some dozen.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import FitFailed
from calib.fit.least_squares.angrisano import fit_paper
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import TriadParameters
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray
from calib.poses.pose_set import PoseSet
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
