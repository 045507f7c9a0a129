"""Users' expressions: what they mean, and that nothing else runs."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.effects.effect import per_axis
from calib.effects.expression import BadExpression, read_expression
from calib.effects.user_defined import (
    fault_of_user_effect,
    read_only,
    shape_between,
    user_effect,
)
from calib.errors import CalibrationError, Undetermined
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
    "p": lambda: AT.previous,
    "tanh(py) + vibration": lambda: np.tanh(AT.previous[:, [1]])
    + AT.vibration.sum(axis=1)[:, None],
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
    shapes = {"axis": (12, 3, 3), "common": (12, 3, 1), "matrix": (12, 3, 9), "reference": (12, 1)}
    for per, shape in shapes.items():
        effect = user_effect("damp", value, per, "{u}", None)  # type: ignore[arg-type]
        assert effect.evaluate(AT).shape == shape
        assert fault_of_user_effect(effect, AT) is None
    per_axis = user_effect("damp", value, "axis", "{u}", None).evaluate(AT)
    assert per_axis == pytest.approx(HUMID[:, :, None] * np.eye(3))


def test_an_effect_on_the_reference_leaves_a_stopped_plate_alone() -> None:
    effect = user_effect("damp", read_expression("2"), "reference", "rad/s", "gyroscope")
    assert effect.evaluate(AT)[:, 0] == pytest.approx(2.0 * (AT.magnitude > 0))


def test_a_function_that_looks_at_other_poses_is_found_out() -> None:
    def centred(at: Conditions) -> FloatArray:
        return np.asarray(at.vector - at.vector.mean(axis=0))

    says = fault_of_user_effect(user_effect("mine", centred, "axis", "{u}", None), AT)
    assert says is not None
    assert "each must depend on itself only" in says


def test_a_function_of_the_wrong_shape_is_found_out() -> None:
    def sized(at: Conditions) -> FloatArray:
        return np.ones((len(at.time_s), 2))

    effect = user_effect("mine", sized, "common", "{u}", None)
    with pytest.raises(Undetermined, match=r"effects.mine: .*\(12, 2\), \(12, 3\) is expected"):
        fault_of_user_effect(effect, AT)


def test_a_function_that_fails_is_named_with_what_it_raised() -> None:
    def failing(at: Conditions) -> FloatArray:
        raise KeyError("humidity")

    effect = user_effect("mine", failing, "axis", "{u}", None)
    with pytest.raises(Undetermined, match=r"effects.mine: .* raised KeyError: 'humidity'"):
        effect.evaluate(AT)


def test_a_function_cannot_change_what_it_is_given() -> None:
    def writing(at: Conditions) -> FloatArray:
        at.vector[:] = 0
        return at.vector

    before = AT.vector.copy()
    with pytest.raises(Undetermined, match=r"raised ValueError: .* is read-only"):
        user_effect("mine", writing, "axis", "{u}", None).evaluate(AT)
    assert np.array_equal(AT.vector, before)
    copies = read_only(AT)
    assert not any(values.flags.writeable for values in copies.columns.values())
    assert not np.shares_memory(copies.force, AT.force)


# --- what effects may be made of -----------------------------------------------------------------


def test_a_matrix_has_a_parameter_for_each_axis_and_each_component() -> None:
    effect = user_effect("g", read_expression("f"), "matrix", "{u}", "gyroscope")
    columns = effect.evaluate(AT)
    theta = np.arange(9.0)
    expected = AT.force @ theta.reshape(3, 3).T
    assert columns @ theta == pytest.approx(expected)
    assert effect.parameters[1] == "xy"


def test_a_shape_parameter_is_tried_between_its_bounds() -> None:
    shape = shape_between("tau", "s", 30, 7200)
    effect = user_effect("settle", read_expression("exp(-time_s/tau)", ("tau",)), "axis", "{u}",
                         None, shape)
    assert effect.evaluate(AT, 300.0) == pytest.approx(
        per_axis(np.tile(np.exp(-AT.time_s / 300)[:, None], 3)))
    assert all(30 < start < 7200 for start in shape.starts)
    assert effect.belongs_to == "session"
    for low, high in ((7200, 30), (0, 1), (5, 5)):
        with pytest.raises(CalibrationError, match="two positive bounds"):
            shape_between("tau", "s", low, high)


@pytest.mark.parametrize(("shapes", "says"), [
    (("tau",), "the shape parameter 'tau' is not used"),
    (("time_s",), "means something else already"),
])
def test_a_shape_parameter_must_be_used_and_have_a_name_of_its_own(
    shapes: tuple[str, ...], says: str
) -> None:
    with pytest.raises(BadExpression, match=says):
        read_expression("exp(-time_s/60)", shapes)


def test_a_run_is_one_in_its_poses_and_nothing_elsewhere() -> None:
    at = replace(AT, columns={**AT.columns, "run:fast": np.repeat([0.0, 1.0], 6)})
    values = read_expression("run('fast')")(at)
    assert values == pytest.approx(np.repeat([0.0, 1.0], 6)[:, None] * np.ones(3))
    assert not read_expression("run('slow')")(at).any()
    effect = user_effect("shake", read_expression("run('fast')"), "axis", "{u}", None)
    assert effect.belongs_to == "bench"


def test_the_accelerometer_s_force_is_what_it_measures() -> None:
    nothing = replace(AT, force=np.full_like(AT.force, np.nan))
    effect = user_effect("bent", read_expression("f**2"), "axis", "{u}", "accelerometer")
    assert effect.evaluate(nothing) == pytest.approx(per_axis(AT.vector**2))
    assert effect.needs == ()
    of_gyro = user_effect("bent", read_expression("f**2"), "axis", "{u}", "gyroscope")
    assert of_gyro.needs == ("force",)


def test_a_logarithm_of_nothing_is_found_out() -> None:
    effect = user_effect("m", read_expression("log(0*s)"), "axis", "{u}", None)
    says = fault_of_user_effect(effect, AT)
    assert says is not None
    assert "is not a number in 12 of 12 poses" in says


@pytest.mark.parametrize("raised", [
    "class Own(BaseException):\n    pass\nraise Own('mine')", "raise StopIteration",
    "raise SystemError",
    "import sys\nsys.exit(7)", "raise GeneratorExit", "assert False",
])
def test_whatever_a_function_raises_is_its_own_fault(raised: str) -> None:
    body = "\n    ".join(raised.split("\n"))
    scope: dict[str, Callable[..., FloatArray]] = {}
    exec(f"def damp(at):\n    {body}\n", scope)  # as the user's file is run
    effect = user_effect("damp", scope["damp"], "axis", "1", "gyroscope", None)
    with pytest.raises(Undetermined, match=r"effects\.damp: the Python function raised"):
        effect.evaluate(Conditions.of_vectors(np.ones((4, 3))))


def test_an_interrupt_is_no_fault_of_a_function() -> None:
    def stopped(_at: Conditions) -> FloatArray:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        user_effect("damp", stopped, "axis", "1", "gyroscope", None).evaluate(
            Conditions.of_vectors(np.ones((4, 3))))
