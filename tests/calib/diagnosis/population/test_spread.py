"""Spread over a lot, sensors unlike it, and whether parameters come back on another evening."""

import numpy as np
import pytest

from calib.diagnosis.population.spread import repeatability, spread_of, weighed_together

RNG = np.random.default_rng(4)


def test_the_spread_of_a_lot_is_that_of_the_sensors_without_their_sds() -> None:
    sd = np.full(400, 2.0)
    spread = spread_of("scale_x", 5 + 3 * RNG.standard_normal(400) + sd * RNG.standard_normal(400),
                       sd)
    assert spread is not None
    assert spread.of_lot.spread == pytest.approx(3.0, abs=0.5)
    assert spread.of_lot.mean == pytest.approx(5.0, abs=0.7)
    assert not spread.unlike.any()


def test_sensors_unlike_the_lot_are_found_and_do_not_widen_it() -> None:
    value = RNG.standard_normal(50)
    value[[3, 9]] = 12.0, -15.0
    spread = spread_of("bias_x", value, np.full(50, 0.1))
    assert spread is not None
    assert list(np.flatnonzero(spread.unlike)) == [3, 9]
    assert spread.of_lot.sensors == 48
    assert spread.of_lot.spread < 1.5


def test_a_lot_of_normal_spread_has_no_unlike_sensors() -> None:
    rng = np.random.default_rng(6)
    alarms = sum(bool(spread.unlike.any()) for _ in range(200)
                 if (spread := spread_of("x", rng.standard_normal(100), np.full(100, 0.3))))
    assert alarms <= 12  # 2 expected of a known spread; that of 100 sensors is known to 8 %


def test_few_sensors_are_unlike_nothing() -> None:
    spread = spread_of("x", np.array([0.0, 0.1, 50.0]), np.full(3, 0.1))
    assert spread is not None
    assert not spread.unlike.any()


def test_what_nobody_states_has_no_spread() -> None:
    assert spread_of("x", np.full(3, np.nan), np.full(3, np.nan)) is None


def test_evenings_are_weighed_together_by_their_sds() -> None:
    mean, sd = weighed_together(np.array([1.0, 3.0, np.nan, 7.0]), np.array([1.0, 1.0, 1.0, 2.0]),
                                np.array([0, 0, 1, 2]), 3)
    np.testing.assert_allclose(mean, [2.0, np.nan, 7.0])
    np.testing.assert_allclose(sd, [np.sqrt(0.5), np.nan, 2.0])


def evenings(factor: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Three evenings of a hundred sensors that scatter by ``factor`` stated sds."""
    sensor = np.repeat(np.arange(100), 3)
    sd = RNG.uniform(0.5, 1.5, 300)
    scatter = factor * sd * RNG.standard_normal(300)
    return 10 * RNG.standard_normal(100)[sensor] + scatter, sd, sensor


def known(drawn: tuple[np.ndarray, np.ndarray, np.ndarray]) -> tuple[np.ndarray, ...]:
    """With sds that are known as if from very many samples."""
    value, sd, sensor = drawn
    return value, sd, np.full(len(value), 1e6), sensor


def test_sds_estimated_from_few_samples_are_no_scatter() -> None:
    """Two evenings of 20,000 sensors, each sd from 12 degrees of freedom."""
    rng = np.random.default_rng(8)
    sensor = np.repeat(np.arange(20_000), 2)
    sd = np.sqrt(rng.chisquare(12, 40_000) / 12)
    compared = repeatability("x", rng.standard_normal(40_000), sd, np.full(40_000, 12.0), sensor,
                             20_000)
    assert compared.birge == pytest.approx(1.0, abs=0.025)


def test_sds_that_hold_from_evening_to_evening_have_a_birge_ratio_of_one() -> None:
    compared = repeatability("bias_x", *known(evenings(1.0)), 100)
    assert compared.dof == 200
    assert compared.birge == pytest.approx(1.0, abs=0.17)
    assert compared.p_value > 1e-3
    assert compared.moved.sum() <= 1


def test_a_parameter_that_moves_by_three_sds_has_a_birge_ratio_of_three() -> None:
    compared = repeatability("bias_x", *known(evenings(3.0)), 100)
    assert compared.birge == pytest.approx(3.0, abs=0.5)
    assert compared.p_value < 1e-20


def test_the_sensor_that_moved_is_told() -> None:
    value, sd, sensor = evenings(1.0)
    value[3 * 41] += 20.0
    compared = repeatability("bias_x", *known((value, sd, sensor)), 100)
    assert 41 in np.flatnonzero(compared.moved)


def test_one_evening_each_repeats_nothing() -> None:
    compared = repeatability("x", np.arange(5.0), np.ones(5), np.full(5, 36.0), np.arange(5), 5)
    assert compared.dof == 0
    assert np.isnan([compared.birge, compared.p_value]).all()
    assert np.isnan(compared.of_sensor).all()
