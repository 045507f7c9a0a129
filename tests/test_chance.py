"""The bounds by chance: the values written beside them, and noise that passes them as stated."""

import doctest

import numpy as np

from tests import chance
from tests.chance import fewest_hits, largest_left_out_rms, largest_rms, spread_bounds

DRAWS = 4000
ROWS, PARAMETERS = 40, 8


def test_the_examples_hold() -> None:
    assert doctest.testmod(chance).failed == 0


def test_noise_passes_each_bound_as_often_as_is_stated() -> None:
    """At 5 %, counted over 4000 draws of a regression with 40 rows: ±1 % is three sds."""
    rng = np.random.default_rng(1)
    design = np.linalg.qr(rng.standard_normal((ROWS, PARAMETERS)))[0]
    noise = rng.standard_normal((DRAWS, ROWS))
    low, high = spread_bounds(ROWS, 0.05)
    rms = np.sqrt((noise**2).mean(axis=1))
    assert abs(np.mean((rms < low) | (rms > high)) - 0.05) < 0.01
    residual = noise - noise @ design @ design.T
    rms = np.sqrt((residual**2).mean(axis=1))
    assert abs(np.mean(rms > largest_rms(ROWS, PARAMETERS, 0.05)) - 0.05) < 0.01
    left_out = residual / (1 - (design**2).sum(axis=1))
    rms = np.sqrt((left_out**2).mean(axis=1))
    assert np.mean(rms > largest_left_out_rms(ROWS, PARAMETERS, 0.05)) < 0.10
    hits = (np.abs(noise) < 1.96).sum(axis=1)
    assert np.mean(hits < fewest_hits(ROWS, 0.95, 0.05)) <= 0.05 + 0.01
