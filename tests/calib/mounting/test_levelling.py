"""Promrit et al.'s equations and numbers, and where they slip."""

import doctest
import math
from types import ModuleType
from unittest.mock import ANY

import numpy as np
import pytest

from calib import earth
from calib.consistency import certificate
from calib.mounting import levelling as tilt
from calib.mounting.levelling import (
    ORDERS,
    Order,
    mounting_rotation,
    order_margins,
    roll_pitch,
    roll_pitch_jacobian,
    rotation_order,
)
from tests.calib.mounting.simulated_reading import G, vehicle_to_sensor

PUBLISHED = np.array([-0.2235, 0.4937, 0.8330])  # g, section V


def test_the_papers_reading_gives_its_order_and_its_angles() -> None:
    assert rotation_order(PUBLISHED) == "xyz"
    roll, pitch = np.degrees(roll_pitch(PUBLISHED, "xyz"))
    # The paper computed from unrounded readings; half a digit of G is 0.003°.
    assert roll == pytest.approx(30.6532, abs=0.003)
    assert pitch == pytest.approx(12.9997, abs=0.003)


def test_eq_6_holds_with_0_1375_where_the_paper_has_a_square_without_its_bracket() -> None:
    margins = order_margins(PUBLISHED)
    assert margins["xyz"] == pytest.approx(0.03168771, abs=1e-8)
    assert margins["yxz"] == pytest.approx(0.1375, abs=5e-5)
    x, _, z = PUBLISHED
    assert abs(math.sqrt(-(x**2) + z**2) - 1) == pytest.approx(0.197543, abs=1e-6)


def test_the_papers_roll_is_right_to_97_82_per_cent_not_99_978() -> None:
    assert 100 * (1 - abs(30.6532 - 30) / 30) == pytest.approx(97.82, abs=0.005)
    assert 100 * (1 - abs(12.9997 - 15) / 15) == pytest.approx(86.66, abs=0.005)


def test_eq_1_to_3_turn_the_axes_not_the_vector() -> None:
    quarter = math.pi / 2
    for rotation, axis, turned in (
        (mounting_rotation("xyz", 0.0, 0.0, quarter), [1, 0, 0], [0, -1, 0]),
        (mounting_rotation("xyz", quarter, 0.0), [0, 1, 0], [0, 0, -1]),
        (mounting_rotation("yxz", 0.0, quarter), [0, 0, 1], [-1, 0, 0]),
    ):
        assert rotation @ axis == pytest.approx(turned, abs=1e-15)


def test_with_yaw_zero_the_products_are_the_matrices_of_section_iv() -> None:
    f, t = 0.4, -0.7
    sf, cf, st, ct = math.sin(f), math.cos(f), math.sin(t), math.cos(t)
    xyz = [[ct, 0, -st], [sf * st, cf, sf * ct], [cf * st, -sf, cf * ct]]
    yxz = [[ct, st * sf, -st * cf], [0, cf, sf], [st, -ct * sf, ct * cf]]
    assert mounting_rotation("xyz", f, t) == pytest.approx(np.array(xyz))
    assert mounting_rotation("yxz", f, t) == pytest.approx(np.array(yxz))


@pytest.mark.parametrize("order", ORDERS)
def test_roll_and_pitch_come_back_from_every_direction_of_gravity(order: Order) -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        up = rng.standard_normal(3)
        up /= np.linalg.norm(up)
        back = mounting_rotation(order, *roll_pitch(up, order)) @ [0.0, 0.0, 1.0]
        assert back == pytest.approx(up, abs=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_the_angles_derivatives_are_the_numerical_ones(order: Order) -> None:
    g = np.array([-2.1, 4.3, -7.9])
    for j in range(3):
        h = 1e-6 * np.eye(3)[j]
        slope = (np.array(roll_pitch(g + h, order)) - roll_pitch(g - h, order)) / 2e-6
        assert roll_pitch_jacobian(g, order)[:, j] == pytest.approx(slope, abs=1e-9)


def test_eq_6_never_chooses_a_locked_order() -> None:
    up = np.random.default_rng(2).standard_normal((2000, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    for g in up:
        axis = 0 if rotation_order(g) == "xyz" else 1
        assert abs(g[axis]) <= math.sqrt(0.5) + 1e-12


def test_calibration_comes_before_rotation_whatever_the_paper_prints() -> None:
    """``K a = R (I + S + M) a + b`` is inverted as printed: the errors come out at angles."""
    rotation = vehicle_to_sensor("xyz", math.radians(30), math.radians(15))
    errors = np.diag([0.01, -0.01, 0.02])
    reading = (np.eye(3) + errors) @ rotation @ [0, 0, G]
    ours = rotation.T @ np.linalg.inv(np.eye(3) + errors) @ reading
    printed = np.linalg.inv(np.eye(3) + errors) @ rotation.T @ reading
    assert ours == pytest.approx([0, 0, G])
    assert np.linalg.norm(printed - ours) > 0.05  # m/s²


@pytest.mark.parametrize("module", [tilt, certificate, earth])
def test_the_examples_in_the_documentation_are_right(module: ModuleType) -> None:
    assert doctest.testmod(module) == doctest.TestResults(0, ANY)
