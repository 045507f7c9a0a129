"""The unit of a coefficient: how the expression grows when what it is made of is stated finer."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.expression import read_expression
from calib.effects.units import coefficient_unit, column_unit, display_unit
from tests.calib.made_poses import rich_poses

FINER = 7.0


@pytest.mark.parametrize(("text", "unit", "grows"), [
    ("f", "(rad/s)/(m/s²)", {"force": 1}),
    ("s**2 * tx_power_w", "1/(rad/s)/W", {"vector": 2, "tx_power_w": 1}),
    ("f * tx_power_w**3", "(rad/s)/(m/s²)/W³", {"force": 1, "tx_power_w": 3}),
    ("abs(s) * sqrt(tx_power_w)", "1/W^0.5", {"vector": 1, "tx_power_w": 0.5}),
    ("spin_rad_s / tx_power_w", "W", {"spin_rad_s": 1, "tx_power_w": -1}),
    ("tanh(tx_power_w / tx_power_w) * time_s", "(rad/s)/s", {"time_s": 1}),
    ("fan_speed", "(rad/s)/unit of fan_speed", {"fan_speed": 1}),
])
def test_a_unit_has_the_powers_by_which_the_expression_grows(
    text: str, unit: str, grows: dict[str, float]
) -> None:
    poses = rich_poses("gyroscope")
    poses = replace(poses, columns={"tx_power_w": poses.time_s + 1, "fan_speed": poses.time_s + 2})
    expression = read_expression(text)
    assert coefficient_unit(expression, "gyroscope") == unit
    at = poses.conditions(poses.reading)
    for name, power in grows.items():
        if name in at.columns:
            then = replace(at, columns={**at.columns, name: FINER * at.columns[name]})
        else:
            then = replace(at, **{name: FINER * getattr(at, name)})
        assert expression(then) == pytest.approx(FINER**power * expression(at), rel=1e-9)


def test_what_is_added_or_has_no_unit_changes_none() -> None:
    of = {text: coefficient_unit(read_expression(text), "accelerometer") for text in (
        "(temperature_c - 28)**2", "(1 + sign(time_s - 60)) / 2", "exp(-time_s / 60) * s", "f",
        "2 * pi")}
    assert list(of.values()) == ["(m/s²)/K²", "m/s²", "1", "1", "m/s²"]


def test_a_letter_is_a_unit_only_behind_its_quantity() -> None:
    units = [column_unit(name) for name in ("tx_power_w", "quat_w", "supply_v", "w", "chan_a")]
    assert units == ["W", "unit of quat_w", "V", "unit of w", "unit of chan_a"]


def test_units_are_read_as_a_person_says_them() -> None:
    name, factor = display_unit("(rad/s)/(m/s²)/W²", [1.0])
    assert name == "°/s per g per W²"
    assert factor == pytest.approx(np.degrees(1) * 9.80665)
    assert display_unit("m/s² per unit of a/b", [1.0])[0] == "mm/s² per unit of a/b"
