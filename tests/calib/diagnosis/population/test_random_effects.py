"""A common size and a spread of sizes, against what was drawn."""

import numpy as np
import pytest

from calib.diagnosis.population.random_effects import random_effects


def drawn(n: int, spread: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    sd = rng.uniform(0.5, 2.0, n)
    return 3.0 + spread * rng.standard_normal(n) + sd * rng.standard_normal(n), sd**2


@pytest.mark.parametrize("spread", [0.0, 0.5, 4.0])
def test_the_mean_comes_out_within_its_sd(spread: float) -> None:
    rng = np.random.default_rng(1)
    fits = [random_effects(*drawn(40, spread, rng)) for _ in range(200)]
    pull = np.array([(each.mean - 3.0) / each.mean_sd for each in fits])
    assert abs(pull.mean()) < 3.3 / np.sqrt(200)
    assert (0.85 if spread else 0.7) < pull.std() < 1.12  # never narrowed: careful without spread


@pytest.mark.parametrize("spread", [1.0, 4.0])
def test_the_spread_comes_out_without_what_the_sds_add(spread: float) -> None:
    rng = np.random.default_rng(2)
    fits = [random_effects(*drawn(60, spread, rng)) for _ in range(200)]
    square = np.array([each.spread**2 for each in fits])
    assert square.mean() == pytest.approx(spread**2, abs=3.3 * square.std() / np.sqrt(200))
    assert all(each.p_same < 0.01 for each in fits if spread == 4.0)


def test_equal_sds_have_the_closed_form_of_analysis_of_variance() -> None:
    value = np.array([1.0, 2.0, 4.0, 7.0, 11.0])
    fit = random_effects(value, np.full(5, 2.0))
    assert fit.mean == pytest.approx(5.0)
    assert fit.spread**2 == pytest.approx(value.var(ddof=1) - 2.0)


def test_alike_sensors_have_no_spread_and_their_mean_is_the_weighted_one() -> None:
    fit = random_effects(np.array([1.0, 1.1]), np.array([1.0, 0.25]))
    assert (fit.spread, fit.sensors) == (0.0, 2)
    assert fit.mean == pytest.approx((1.0 + 4 * 1.1) / 5)
    assert fit.mean_sd == pytest.approx(1 / np.sqrt(5))


def test_one_sensor_has_its_own_value_and_no_spread() -> None:
    fit = random_effects(np.array([2.0]), np.array([0.09]))
    assert (fit.mean, fit.mean_sd, fit.spread, fit.p_same) == (2.0, pytest.approx(0.3), 0.0, 1.0)
