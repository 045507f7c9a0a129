"""Effects added to many fits at once are those added to one after the other."""

from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.hypotheses.listed import held
from calib.diagnosis.hypotheses.unlisted import bad_pose_hypotheses, step_hypotheses
from calib.effects.catalogue import BASE, find_effect
from calib.errors import CalibrationError
from calib.fit.batch import extend_many as stacked
from calib.fit.batch.extend_many import Extension, extend_many
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import extend, fit
from calib.fit.model import Model
from calib.fit.rows.problem import Precision
from tests.lots import pose_sets_of
from tests.trials import hidden_of, poses_of
from tests.world.designs import paper_design, rich_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot


def accelerometers(hidden: str, size: float, count: int = 6) -> list[Fit]:
    plan = LotPlan(count, hidden=hidden, own_sd=(size, 2 * size))
    sets = pose_sets_of(draw_lot(paper_design(mpu6050()), plan, 11))
    return [fit(poses, Model.of(BASE)) for poses in sets]


def gyroscopes(*hidden: str) -> list[Fit]:
    """Rows of two kinds, and common errors of the rates."""
    design = rich_design()
    fits = []
    for seed in (12, 13, 14):
        effects = hidden_of(hidden, "gyroscope", 8.0, design, seed)
        assert effects is not None
        fits.append(fit(poses_of(design, seed, "gyroscope", effects), Model.of(BASE)))
    return fits


def asked(bases: list[Fit], *names: str) -> list[Extension]:
    return [Extension(base, tuple(find_effect(name) for name in names)) for base in bases]


@pytest.fixture
def none_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails where a set leaves its stack."""
    monkeypatch.setattr(stacked, "_alone", lambda each: pytest.fail(f"{each.effects} alone"))


def assert_same(requests: list[Extension]) -> None:
    """Within what WEIGHING leaves open, 1e-4 of chi-square and 1e-2 of a row's sd."""
    for each, joint in zip(requests, extend_many(requests), strict=True):
        alone = extend(each.base, each.effects)
        assert joint is not None
        assert joint.model.names == alone.model.names
        assert joint.dof == alone.dof
        assert joint.chi2 == pytest.approx(alone.chi2, abs=1e-6, rel=1e-6)
        sd = np.sqrt(np.diag(alone.cov))
        assert np.abs(joint.theta - alone.theta).max() <= 1e-4 * sd.max() + 1e-9
        assert (np.abs(joint.theta - alone.theta) <= 1e-3 * sd + 1e-12).all()
        assert np.sqrt(np.diag(joint.cov)) == pytest.approx(sd, rel=2e-3)
        assert joint.rows.residual == pytest.approx(alone.rows.residual, abs=1e-4)
        for name, value in alone.shapes.items():
            assert joint.shapes[name] == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize("names", [
    ("quadratic",), ("temperature_bias", "cubic"), ("bias_drift",),
])
@pytest.mark.usefixtures("none_alone")
def test_effects_on_what_the_axes_feel(names: tuple[str, ...]) -> None:
    assert_same(asked(accelerometers(names[0], 6.0), *names))


@pytest.mark.parametrize("name", ["warm_up", "hysteresis", "cross_quadratic"])
def test_effects_with_a_shape_with_a_memory_and_of_which_the_poses_see_a_part(name: str) -> None:
    assert_same(asked(accelerometers(name, 6.0), name))


@pytest.mark.parametrize("names", [
    ("g_sensitivity",), ("reference_drift",), ("g_squared_sensitivity", "quadratic"),
    ("earth_rate",),
])
@pytest.mark.usefixtures("none_alone")
def test_rows_at_rest_common_errors_and_effects_on_the_reference(names: tuple[str, ...]) -> None:
    assert_same(asked(gyroscopes("g_sensitivity"), *names))


@pytest.mark.usefixtures("none_alone")
def test_poses_of_its_own_that_each_set_marks() -> None:
    """Bad poses and steps, at other places in every set, beside a listed effect."""
    requests = []
    for k, base in enumerate(accelerometers("cubic", 6.0)):
        marks = (bad_pose_hypotheses(base)[2 * k], step_hypotheses(base)[k])
        effects = [held(mark, k) for mark in marks]
        requests.append(Extension(base, (effects[0], find_effect("cubic"), effects[1])))
    assert len({each.shape for each in requests}) == 1
    assert_same(requests)


def test_what_poses_do_not_determine_is_none_as_alone() -> None:
    bases = accelerometers("quadratic", 6.0, 3)
    requests = asked(bases, "quadratic", "asymmetry")
    for each in requests:
        with pytest.raises(CalibrationError):
            extend(each.base, each.effects)
    assert extend_many(requests) == [None] * 3


def test_what_does_not_go_straight_goes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a single step allowed no set comes to rest in the stack."""
    requests = asked(accelerometers("cubic", 40.0, 3), "cubic")
    monkeypatch.setattr(stacked, "WEIGHING", Precision(1, step_sd=1e-9, idle_sd=1e-9))
    went: list[Extension] = []
    alone = stacked._alone
    monkeypatch.setattr(stacked, "_alone", lambda each: went.append(each) or alone(each))
    joints = extend_many(requests)
    assert went == requests
    for each, joint in zip(requests, joints, strict=True):
        assert joint is not None
        assert joint.chi2 == extend(each.base, each.effects).chi2


def test_what_no_stack_can_hold_has_no_shape() -> None:
    (base,) = accelerometers("quadratic", 6.0, 1)
    (listed,) = asked([base], "quadratic")
    assert listed.shape is not None
    lever = Extension(base, (find_effect("lever_arm"),))
    own = Extension(base, (replace(find_effect("quadratic"), columns=lambda at: at.vector),))
    robust = Extension(replace(base, weight=0.5 * base.weight), listed.effects)
    assert [each.shape for each in (lever, own, robust)] == [None] * 3
