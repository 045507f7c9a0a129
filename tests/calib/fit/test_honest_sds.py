"""Stated sds against the simulated bench, which knows the truth; the study has 500 sessions."""

import numpy as np
import pytest

from tests.calib.fit.coverage import draw
from tests.world.designs import paper_design, rich_design

PAPER = paper_design().scaled(sample_rate=0.3)
RICH = rich_design().scaled(sample_rate=0.1)


def test_estimates_of_both_triads_scatter_as_stated_and_both_solvers_agree() -> None:
    """24 evenings, each with another unit: 216 deviations, the spread of all known to 7 %."""
    draws = [draw(PAPER, seed) for seed in range(24)]
    for triad in ("accelerometer", "gyroscope"):
        z = np.array([each.deviations[triad] for each in draws])
        assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.2)
        assert np.sqrt(np.mean(z**2, axis=0)).max() < 1.6
        assert np.abs(z).max() < 4.5
    rates = np.concatenate([each.rates for each in draws])
    assert np.sqrt(np.mean(rates**2)) == pytest.approx(1.0, abs=0.5)
    assert max(each.solvers_apart for each in draws) < 5e-9
    assert sum(each.refused for each in draws) <= 4


def test_the_sds_hold_with_several_runs_and_shared_rates() -> None:
    z = np.array([draw(RICH, seed).deviations["gyroscope"] for seed in range(12)])
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.3)
