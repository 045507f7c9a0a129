"""Stated sds against the simulated bench, which knows the truth; the study has 500 sessions."""

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from tests.calib.fit.least_squares.coverage import draw
from tests.chance import spread_bounds
from tests.fitting import pose_sets
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate

PAPER = paper_design().scaled(sample_rate=0.3)
RICH = rich_design().scaled(sample_rate=0.1)


def test_estimates_of_both_triads_scatter_as_stated_and_both_solvers_agree() -> None:
    """12 evenings, each with another unit: 9 spreads and 108 deviations of either triad."""
    draws = [draw(PAPER, seed) for seed in range(12)]
    for triad in ("accelerometer", "gyroscope"):
        z = np.array([each.deviations[triad] for each in draws])
        low, high = spread_bounds(z.size, chance=1e-3)
        assert low < np.sqrt(np.mean(z**2)) < high
        assert np.sqrt(np.mean(z**2, axis=0)).max() < spread_bounds(len(z), chance=1e-3)[1]
        assert np.abs(z).max() < 4.5
    rates = np.concatenate([each.rates for each in draws])
    low, high = spread_bounds(rates.size)
    assert low < np.sqrt(np.mean(rates**2)) < high
    assert max(each.solvers_apart for each in draws) < 5e-9
    assert sum(each.refused for each in draws) <= 2


def test_the_sds_hold_with_several_runs_and_shared_rates() -> None:
    z = np.array([draw(RICH, seed).deviations["gyroscope"] for seed in range(6)])
    low, high = spread_bounds(z.size, chance=1e-3)
    assert low < np.sqrt(np.mean(z**2)) < high


@pytest.mark.parametrize("design", [PAPER, RICH], ids=["one setting", "four settings"])
def test_a_rate_that_drifts_leaves_open_what_it_was_when_the_clips_were_taken(
    design: Design,
) -> None:
    """All clips at one time, early to late: the gains are off by many of their sds of noise."""
    begin_s, *_ = (begin for run, begin in zip(design.runs, design.begins_s(), strict=True)
                   if run.motion is not None)
    end_s, z = design.begins_s()[-1] + design.runs[-1].length_s, []
    for seed, share in enumerate((0.05, 0.3, 0.5, 0.7, 0.95)):
        filmed = {"filmed_s": begin_s + share * (end_s - begin_s)}
        drift = Hidden("reference_drift", "gyroscope", np.array(-2e-6), filmed)
        session = simulate(design, seed, (drift,))
        _, poses, specs = pose_sets(session)
        found = calibrate_triad(fit(poses, Model.of((*BASE, "reference_drift"))), specs[1])
        off = found.parameters.scale_counts_per_unit - session.gyroscope.scale_counts_per_unit
        z.append(np.mean(off / found.parameters.sd[2]))
    assert 1.2 < max(z) < 1.9  # of a uniform distribution 1.73 at most
    assert 1.2 < -min(z) < 1.9
    assert abs(z[2]) < 0.5
