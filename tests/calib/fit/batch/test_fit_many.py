"""Many fits at once are the fits one at a time: numbers, iterations and refusals."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.batch.fit_many import ManyFits, fit_many
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet
from calib.poses.reference import constant_reference
from tests.fitting import pose_sets
from tests.lots import pose_sets_of
from tests.world.designs import paper_design, rich_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot
from tests.world.session import simulate

NINE = Model.of(BASE)
SAME_SD = 1e-9


def lot(sensors: int, seed: int = 1) -> list[PoseSet]:
    return pose_sets_of(draw_lot(paper_design(mpu6050()), LotPlan(sensors), seed))


def assert_each_is(one: Fit | None, alone: Fit) -> None:
    """The fit taken out of its stack has the rows of the fit alone."""
    assert one is not None
    np.testing.assert_allclose(one.rows.residual, alone.rows.residual, atol=1e-7)
    np.testing.assert_allclose(one.rows.vector, alone.rows.vector, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.cov, alone.cov, rtol=1e-6, atol=1e-9 * alone.cov.max())
    np.testing.assert_allclose(one.sensed, alone.sensed, rtol=1e-9, atol=1e-12)
    assert (one.dof, one.eta.shape) == (alone.dof, alone.eta.shape)


def assert_same(many: ManyFits, sets: Sequence[PoseSet]) -> None:
    """Each of ``sets`` by itself: its numbers, or its refusal in the same words."""
    each = many.each(sets)
    for i, poses in enumerate(sets):
        if i in many.refusals:
            with pytest.raises(type(many.refusals[i]), match=re.escape(str(many.refusals[i]))):
                fit(poses, many.model)
            assert np.isnan(many.theta[i]).all()
            assert each[i] is None
            continue
        alone = fit(poses, many.model)
        assert_each_is(each[i], alone)
        sd = np.sqrt(np.diag(alone.cov))
        assert np.abs((many.theta[i] - alone.theta) / sd).max() < SAME_SD
        np.testing.assert_allclose(many.sd[i], sd, rtol=1e-9)
        np.testing.assert_allclose(many.chi2[i], alone.chi2, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(many.p_value[i], alone.p_value, rtol=1e-7)
        assert (many.dof[i], many.iterations[i]) == (alone.dof, alone.iterations)


def test_a_lot_of_accelerometers_is_fitted_as_one_at_a_time_and_none_alone() -> None:
    sets = lot(30)
    many = fit_many(sets, NINE)
    assert not many.alone
    assert_same(many, sets)


def test_sets_of_different_numbers_of_poses_go_together() -> None:
    sets = [poses.take(range(18 - i % 6)) for i, poses in enumerate(lot(12))]
    assert_same(fit_many(sets, NINE), sets)


def test_gyroscopes_with_common_errors_and_rest_go_together_with_accelerometers() -> None:
    design = rich_design().scaled(sample_rate=0.06)
    sets = [each for seed in range(2) for each in pose_sets(simulate(design, seed))[:2]]
    shuffled = sets[1].take(np.random.default_rng(1).permutation(len(sets[1])))
    many = fit_many([*sets, shuffled], NINE)
    assert not many.alone
    assert_same(many, [*sets, shuffled])
    shift = many.stacks[1].common_shift
    alone = fit(sets[many.stacks[1].index[0]], NINE).common_shift
    np.testing.assert_allclose(shift[0], alone, rtol=1e-7, atol=1e-9 * np.abs(alone).max())


@pytest.mark.parametrize("names", [("bias",), ("scale", "bias"), ("misalignment", "scale")])
def test_smaller_models_and_models_in_another_order(names: tuple[str, ...]) -> None:
    sets = lot(5)
    assert_same(fit_many(sets, Model.of(names)), sets)


def test_refusals_are_those_of_one_at_a_time_and_the_others_stay() -> None:
    sets = lot(8)
    half = [i for i, label in enumerate(sets[1].label) if sets[1].reading[i, 2] > -3]
    sets[1] = sets[1].take(half[:11])
    sets[2] = sets[2].take(range(9))
    sets[3] = replace(sets[3], reading=3 * sets[3].reading)
    sets[4] = replace(sets[4], reading=np.tile(sets[4].reading[:3], (6, 1)))
    sets[5] = replace(sets[5], reading=np.where([1, 1, 0], sets[5].reading, 0.0))
    many = fit_many(sets, NINE)
    assert {2, 4, 5} <= set(many.refusals)
    assert_same(many, sets)


def test_rest_alone_shows_no_gain_and_carries_a_bias() -> None:
    at_rest = [replace(poses, triad="gyroscope", reading=0.01 + 0 * poses.reading + poses.sd,
                       reference=constant_reference(18, 0.0, [])) for poses in lot(3)]
    refused = fit_many(at_rest, NINE)
    assert all(isinstance(each, Undetermined) for each in refused.refusals.values())
    assert_same(refused, at_rest)
    assert_same(fit_many(at_rest, Model.of(["bias"])), at_rest)


def test_a_set_that_full_steps_do_not_bring_to_rest_is_fitted_by_itself() -> None:
    sets = lot(4)
    rng = np.random.default_rng(3)
    sets[2] = replace(sets[2], reading=sets[2].reading * rng.uniform(0.2, 2.5, (18, 1)))
    assert_same(fit_many(sets, NINE), sets)


def test_speeds_that_no_nine_poses_share_start_from_the_data_sheet() -> None:
    sets = lot(3)
    share = np.repeat([1.0, 1.3, 1.7], 6)
    sets = [replace(poses, reading=poses.reading * share[:, None],
                    reference=replace(poses.reference, magnitude=9.80267 * share))
            for poses in sets]
    assert_same(fit_many(sets, NINE), sets)


def test_effects_on_the_sensor_are_not_for_the_stack() -> None:
    with pytest.raises(ValueError, match="quadratic"):
        fit_many(lot(1), Model.of([*BASE, "quadratic"]))


def test_stated_sds_hold_over_a_lot() -> None:
    """(estimate - truth) / sd of the biases over 400 sensors has the spread 1."""
    design = paper_design(mpu6050())
    noisy = draw_lot(design, LotPlan(400), 2)
    quiet = draw_lot(design, LotPlan(400), 2)
    exact = replace(quiet, counts=quiet.true_counts)
    apart = fit_many(pose_sets_of(noisy), NINE), fit_many(pose_sets_of(exact), NINE)
    pull = (apart[0].theta - apart[1].theta) / apart[0].sd
    assert np.abs(pull.std(axis=0) - 1).max() < 0.13  # 400 sensors: 3.7 sds of a spread
