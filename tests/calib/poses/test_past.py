"""What the past makes of a column is what a body does, integrated step by step."""

import numpy as np
import pytest

from calib.effects.expression import BadExpression, read_expression
from calib.effects.units import coefficient_unit
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.past import across_gap, behind, past_columns, total


def integrated(values: FloatArray, time_s: FloatArray, tau_s: float) -> FloatArray:
    body, course = values[0], [values[0]]
    for k in range(len(values) - 1):
        fine = np.linspace(0, 1, 2001)
        step = (time_s[k + 1] - time_s[k]) / 2000
        drive = values[k] + (values[k + 1] - values[k]) * 0.5 * (fine[1:] + fine[:-1])
        for each_drive in drive:
            body += step / tau_s * (each_drive - body)
        course.append(body)
    return np.array(course)


@pytest.mark.parametrize("tau_s", [7.0, 60.0, 4000.0])
def test_a_lag_follows_its_column_in_the_order_of_time(tau_s: float) -> None:
    random = np.random.default_rng(3)
    time_s = np.cumsum(random.uniform(5, 50, 20))
    values = random.normal(size=20)
    right = integrated(values, time_s, tau_s)
    assert behind(values, time_s, tau_s) == pytest.approx(right, abs=2e-3)
    mixed = random.permutation(20)
    assert behind(values[mixed], time_s[mixed], tau_s) == pytest.approx(right[mixed], abs=2e-3)


def test_two_rows_at_one_time_and_an_unknown_time() -> None:
    twice = behind(np.array([1.0, 3.0, 3.0]), np.array([0.0, 0.0, 1e9]), 5.0)
    assert twice == pytest.approx([1.0, 1.0, 3.0])
    assert np.isnan(behind(np.ones(2), np.array([0.0, np.nan]), 5.0)).all()


def test_play_rests_until_the_gap_is_crossed_and_a_total_is_an_integral() -> None:
    """Both sample by sample along a straight line between the rows, in mixed order."""
    random = np.random.default_rng(4)
    time_s = np.cumsum(random.uniform(5, 50, 20))
    values = random.normal(size=20)
    state, held, drawn, summed = values[0], [values[0]], 0.0, [0.0]
    for k in range(19):
        for value in np.linspace(values[k], values[k + 1], 500):
            if value > state + 0.4:
                state = value - 0.4
            elif value < state - 0.4:
                state = value + 0.4
        held.append(state)
        fine = np.linspace(values[k], values[k + 1], 501)
        drawn += (time_s[k + 1] - time_s[k]) * float(0.5 * (fine[1:] + fine[:-1]).mean())
        summed.append(drawn)
    mixed = random.permutation(20)
    assert across_gap(values[mixed], time_s[mixed], 0.4) == pytest.approx(np.array(held)[mixed])
    assert total(values[mixed], time_s[mixed]) == pytest.approx(np.array(summed)[mixed])
    unknown = np.array([0.0, np.nan])
    assert np.isnan(across_gap(np.ones(2), unknown, 1.0)).all()
    assert np.isnan(total(np.ones(2), unknown)).all()


def test_an_expression_has_a_lag_where_its_column_is_there() -> None:
    expression = read_expression("lag(tx_power_w, 200)**2 * others")
    assert expression.columns == ("tx_power_w",)
    assert coefficient_unit(expression, "gyroscope") == "1/(rad/s)/W²"
    time_s, power = np.arange(4) * 100.0, np.array([0.0, 2.0, 2.0, 0.0])
    vector = np.array([[1.0, 2.0, 3.0]] * 4)
    columns = {"tx_power_w": power}
    columns |= past_columns(columns, time_s, expression.pasts)
    lag = behind(power, time_s, 200.0)
    at = Conditions.of_vectors(vector, columns)
    assert expression(at) == pytest.approx(lag[:, None] ** 2 * [6.0, 3.0, 2.0])
    assert np.isnan(expression(Conditions.of_vectors(vector, {"tx_power_w": power}))).all()


@pytest.mark.parametrize(("text", "unit"), [
    ("lag(tx_power_w**2 + 3, 60)", "(rad/s)/W²"), ("play(supply_v, 0.1)", "(rad/s)/V"),
    ("total(tx_power_w)", "(rad/s)/W/s"),
])
def test_the_past_of_an_expression_has_its_unit(text: str, unit: str) -> None:
    expression = read_expression(text)
    assert coefficient_unit(expression, "gyroscope") == unit
    random = np.random.default_rng(5)
    columns, time_s = {name: random.uniform(1, 2, 6) for name in expression.columns}, np.arange(6.0)
    columns |= past_columns(columns, time_s, expression.pasts)
    at = Conditions.of_vectors(np.ones((6, 3)), columns)
    assert np.isfinite(expression(at)).all()
    assert np.ptp(expression(at)[:, 0]) > 0


@pytest.mark.parametrize("text", [
    "lag(time_s, 3)", "lag(power, -2)", "lag(power)", "lag(2, 3)", "total(power, 2)", "total()",
    "play(power)", "lag(lag(power, 2), 3)", "total(s * power)", "lag(run('a'), 2)",
])
def test_what_the_past_cannot_make_is_refused(text: str) -> None:
    with pytest.raises(BadExpression, match=r"lag\(x, SECONDS\)"):
        read_expression(text)
