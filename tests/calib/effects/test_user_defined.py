"""Users' expressions: what they mean, and that nothing else runs."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.effects.user_defined import BadExpression, check_own, own_effect, read_expression
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from tests.calib.made_poses import some_conditions

AT = some_conditions("gyroscope")
HUMID = AT.columns["humidity_pct"][:, None]
MEANT: dict[str, Callable[[], FloatArray]] = {
    "1": lambda: np.ones((12, 3)),
    "s": lambda: AT.vector,
    "x": lambda: AT.vector[:, [0]],
    "z*y": lambda: AT.vector[:, [2]] * AT.vector[:, [1]],
    "f": lambda: AT.force,
    "fz - fx": lambda: AT.force[:, [2]] - AT.force[:, [0]],
    "humidity_pct": lambda: HUMID,
    "-(humidity_pct - 45)**2 / 10": lambda: -((HUMID - 45) ** 2) / 10,
    "sin(2*pi*time_s/600)": lambda: np.sin(2 * np.pi * AT.time_s[:, None] / 600),
    "s*abs(s) + sign(spin_rad_s)": lambda: AT.vector * np.abs(AT.vector)
    + np.sign(AT.spin_rad_s[:, None]),
    "exp(-time_s/300)*s": lambda: np.exp(-AT.time_s[:, None] / 300) * AT.vector,
    "time_s**-2 + magnitude": lambda: AT.time_s[:, None] ** -2.0 + AT.magnitude[:, None],
    "+2e-3": lambda: np.full((12, 3), 2e-3),
}


@pytest.mark.parametrize("text", MEANT)
def test_an_expression_means_what_it_says(text: str) -> None:
    expected = np.broadcast_to(MEANT[text](), (12, 3))
    assert read_expression(text)(AT) == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        "s.__class__",
        "s[0]",
        "open('x')",
        "eval(s)",
        "[s for s in s]",
        "lambda: s",
        "s if s else s",
        "s < 1",
        "s and s",
        "'s'",
        "True",
        "sin(s, s)",
        "sin(x=s)",
        "s // 2",
        "s % 2",
        "s << 2",
        "(s := 1)",
        "1j",
    ],
)
def test_nothing_else_is_let_through(text: str) -> None:
    with pytest.raises(BadExpression, match="not allowed"):
        read_expression(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is not an expression"),
        ("s +", "is not an expression"),
        ("s**time_s", "an exponent must be a number"),
        ("s**1e9", "is larger than 8"),
        ("1+" * 300 + "1", "characters long"),
    ],
)
def test_what_cannot_be_read_says_why(text: str, says: str) -> None:
    with pytest.raises(BadExpression, match=says):
        read_expression(text)


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=40))
def test_any_text_is_read_or_refused(text: str) -> None:
    with suppress(BadExpression):
        read_expression(text)


def test_one_parameter_per_axis_or_one_in_common_or_one_on_the_reference() -> None:
    value = read_expression("humidity_pct")
    shapes = {"axis": (12, 3, 3), "common": (12, 3, 1), "reference": (12, 1)}
    for per, shape in shapes.items():
        effect = own_effect("damp", value, per, "{u}", None)  # type: ignore[arg-type]
        assert effect.evaluate(AT).shape == shape
        assert check_own(effect, AT) is None
    per_axis = own_effect("damp", value, "axis", "{u}", None).evaluate(AT)
    assert per_axis == pytest.approx(HUMID[:, :, None] * np.eye(3))


def test_an_effect_on_the_reference_leaves_a_stopped_plate_alone() -> None:
    effect = own_effect("damp", read_expression("2"), "reference", "rad/s", "gyroscope")
    assert effect.evaluate(AT)[:, 0] == pytest.approx(2.0 * (AT.magnitude > 0))


def test_a_function_that_looks_at_other_poses_is_found_out() -> None:
    def centred(at: Conditions) -> FloatArray:
        return np.asarray(at.vector - at.vector.mean(axis=0))

    says = check_own(own_effect("mine", centred, "axis", "{u}", None), AT)
    assert says is not None
    assert "each must depend on itself only" in says


def test_a_function_of_the_wrong_shape_is_found_out() -> None:
    def sized(at: Conditions) -> FloatArray:
        return np.ones((len(at.time_s), 2))

    effect = own_effect("mine", sized, "common", "{u}", None)
    says = check_own(effect, AT)
    assert says is not None
    assert "(12, 3, 1) is expected" in says


def test_a_logarithm_of_nothing_is_found_out() -> None:
    says = check_own(own_effect("m", read_expression("log(0*s)"), "axis", "{u}", None), AT)
    assert says is not None
    assert "is not a number in 12 of 12 poses" in says
