"""A stack of many sets is their single fits, and one that is refused leaves it alone."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.least_squares.stack_fits import WEIGHING
from calib.fit.model import Model
from calib.fit.rows.problem import Precision
from calib.poses.pose_set import PoseSet
from tests.lots import pose_sets_of
from tests.trials import DESIGNS, drawn, poses_of
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot


@cache
def evenings(count: int, *hidden: str) -> tuple[PoseSet, ...]:
    """Gyroscopes on the turning plate and at rest, each with its noise and the same effects."""
    design = replace(DESIGNS["rich"](), sample_rate_hz=20.0)
    effects = [drawn(name, "gyroscope", 20.0, design, 5) for name in hidden]
    known = [effect for effect in effects if effect is not None]
    return tuple(poses_of(design, seed, "gyroscope", known) for seed in range(count))


def stacked(sets: Sequence[PoseSet], model: Model, robust: bool = False) -> dict[int, Fit]:
    return {int(i): fits.fitted.one(k) for fits in fit_sets(sets, model, robust=robust)
            if fits.fitted for k, i in enumerate(fits.index)}


def assert_same(many: Fit, single: Fit) -> None:
    sd = np.sqrt(np.diag(single.cov))
    assert np.abs((many.theta - single.theta) / sd).max() < 1e-12
    assert np.allclose(many.cov, single.cov, rtol=1e-9, atol=1e-12 * np.outer(sd, sd).max())
    assert many.chi2 == pytest.approx(single.chi2, rel=1e-12)
    assert (many.iterations, many.dof) == (single.iterations, single.dof)
    assert many.basis.shape == single.basis.shape
    assert dict(many.shapes) == pytest.approx(dict(single.shapes), rel=1e-9)


@pytest.mark.parametrize(("names", "robust"), [
    ((), False), ((), True), (("quadratic", "g_sensitivity"), False), (("cross_quadratic",), True),
    (("reference_offset",), False), (("reference_drift",), False),
    (("warm_up",), False), (("hysteresis",), False),
])
def test_a_stack_is_its_single_fits(names: tuple[str, ...], robust: bool) -> None:
    sets, model = evenings(4, "quadratic", "warm_up"), Model.of((*BASE, *names))
    many = stacked(sets, model, robust)
    assert list(many) == list(range(4))
    for k, poses in enumerate(sets):
        single = fit(poses, model, robust=robust)
        if model.effects[-1].shape is None:
            assert_same(many[k], single)
        else:  # a minimum in a bent valley is as exact as the last step
            assert many[k].chi2 == pytest.approx(single.chi2, rel=1e-12)


def test_sets_of_several_shapes_each_have_their_stack() -> None:
    lot = pose_sets_of(draw_lot(paper_design(mpu6050()), LotPlan(6), 3))
    sets = [*lot[:3], lot[3].take(range(14)), lot[4].take(range(14)), lot[5]]
    many, model = stacked(sets, Model.of(BASE)), Model.of(BASE)
    assert sorted(many) == list(range(6))
    for k, poses in enumerate(sets):
        assert_same(many[k], fit(poses, model))


def test_fits_that_are_only_compared_stop_early_and_none_is_refused_for_it() -> None:
    sets, model = evenings(4, "quadratic", "warm_up"), Model.of(BASE)
    (coarse,) = fit_sets(sets, model, precision=WEIGHING)
    (stopped,) = fit_sets(sets, model, precision=Precision(1, 1e-7))
    assert coarse.fitted is not None
    assert stopped.fitted is not None
    exact = [stacked(sets, model)[k] for k in range(4)]
    assert coarse.fitted.chi2 == pytest.approx([one.chi2 for one in exact], rel=1e-4)
    assert coarse.fitted.iterations.sum() < sum(one.iterations for one in exact)
    assert list(stopped.index) == [0, 1, 2, 3]


def test_a_set_that_is_refused_leaves_the_others_alone() -> None:
    """Each refusal in the words that the set alone is refused with."""
    sets, model = [*evenings(4, "quadratic", "warm_up")], Model.of((*BASE, "quadratic"))
    flat, far = sets[1], sets[3]
    size = np.linalg.norm(flat.reading, axis=1, keepdims=True)
    near = flat.reading[0] / size[0] + 0.1 * flat.reading / size  # one face determines no model
    near *= size / np.linalg.norm(near, axis=1, keepdims=True)
    sets[1] = replace(flat, reading=near)
    factor = np.where(np.arange(len(far)) % 2, 50.0, 1.0)
    sets[3] = replace(far, reading=far.reading * factor[:, None])
    refusals = {k: error for fits in fit_sets(sets, model) for k, error in fits.refusals.items()}
    many = stacked(sets, model)
    assert 1 in refusals
    assert set(refusals) | set(many) == set(range(4))
    for k, poses in enumerate(sets):
        if k in refusals:
            with pytest.raises(CalibrationError) as alone:
                fit(poses, model)
            assert str(alone.value) == str(refusals[k])
        else:
            assert_same(many[k], fit(poses, model))
