"""Stated sds against the simulated bench, which knows the truth; the study has 500 sessions."""

import numpy as np

from tests.calib.fit.least_squares.coverage import draw
from tests.chance import spread_bounds
from tests.world.designs import paper_design, rich_design

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
