"""What a gyroscope at rest reads, by the largest cluster of the means of stops."""

import tracemalloc

import numpy as np

from pipeline.guess.pool import common_mean

BIAS, PLATE = np.array([0.03, -0.04, 0.06]), np.array([0.0, 0.1, 3.5])


def test_poses_of_one_attitude_on_the_plate_are_no_rest() -> None:
    np.testing.assert_allclose(common_mean(np.array([BIAS + PLATE] * 8 + [BIAS] * 8)), BIAS)


def test_rests_alike_are_nearer_than_a_tenth_of_what_both_directions_differ_by() -> None:
    """The plate turns both ways: half of what they differ by is the rate."""
    rests = np.linspace(-0.15, 0.15, 9)[:, None] * PLATE
    turns = np.array([PLATE, -PLATE] * 8)
    np.testing.assert_allclose(common_mean(np.concatenate([turns, BIAS + rests])), BIAS)


def test_few_stops_alike_have_no_common_mean() -> None:
    apart = np.arange(5)[:, None] * PLATE
    assert common_mean(np.concatenate([apart, [BIAS + PLATE] * 4])) is None


def test_a_night_at_rest_takes_memory_in_proportion_to_its_length() -> None:
    """Distances of all pairs of 5,000 stops are 600 MB."""
    means = BIAS + np.random.default_rng(0).normal(0, 0.1 * abs(BIAS).max(), (5_000, 3))
    tracemalloc.start()
    try:
        mean = common_mean(means)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 20 * means.nbytes
    np.testing.assert_allclose(mean, BIAS, atol=0.002)
