"""Sums formed once give the means of any stretch and the variance of every window."""

from itertools import pairwise

import numpy as np
import pytest

from calib.poses.samples.running_sums import RunningSums

VALUES = np.array([9.8, 0.1, -3.0]) + 1e-3 * np.random.default_rng(1).normal(size=(50_000, 3))
VALUES[20_000:, 0] -= 19.6  # the sensor is laid down on its other side


def test_means_are_those_of_the_stretches() -> None:
    edges = np.array([100, 130, 5000, 19_990, 45_000, 49_999])
    sums = RunningSums.of(VALUES)
    parts = [VALUES[a:b] for a, b in pairwise(edges)]
    means = sums.means(edges)
    assert means == pytest.approx(np.array([p.mean(axis=0) for p in parts]), abs=1e-9)
    assert np.array_equal(means, [sums.mean(a, b) for a, b in pairwise(edges)])


def test_the_variance_of_every_window_is_that_of_its_samples() -> None:
    variance = RunningSums.of(VALUES).window_variance(50)
    assert variance.shape == (len(VALUES) - 49,)
    for start in (0, 777, 19_975, len(VALUES) - 50):
        expected = VALUES[start : start + 50].var(axis=0).sum()
        assert variance[start] == pytest.approx(expected, rel=1e-3)
