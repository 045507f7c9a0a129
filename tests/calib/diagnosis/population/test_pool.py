"""Evidence of many sensors, and what the pool makes of it."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.population.evidence import Trial, evidence_of
from calib.diagnosis.population.lot import LotEvidence
from calib.diagnosis.population.pool import FALSE_ALARM, Pool, judge, pool
from calib.diagnosis.population.sums import sums_of
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet
from tests.lots import pose_sets_of
from tests.world.designs import paper_design, soak_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot

NINE = Model.of(BASE)


def pooled_singly(sets: list[PoseSet]) -> Pool:
    lot = LotEvidence.of((str(i), evidence_of(fit(each, NINE))) for i, each in enumerate(sets))
    assert lot is not None
    return pool(lambda _trials: [lot])


def blocks_of(
    sets: list[PoseSet], names: list[str] | None = None, wanted: Collection[str] = (),
    at_once: int = 500,
) -> Iterator[LotEvidence]:
    names = names or [str(i) for i in range(len(sets))]
    for first in range(0, len(sets), at_once):
        for fits in fit_sets(sets[first : first + at_once], NINE):
            assert fits.fitted is not None
            yield LotEvidence.from_stack([names[first + int(i)] for i in fits.index],
                                         evidence_of(fits.fitted, names=wanted))


def pool_of(sets: list[PoseSet], names: list[str] | None = None) -> Pool:
    lots = [*blocks_of(sets, names)]
    return pool(lambda _trials: lots)


def test_blocks_of_stacked_fits_pool_as_the_single_fits_do() -> None:
    plan = LotPlan(60, hidden="cubic", common_sd=1.0)
    sets = pose_sets_of(draw_lot(paper_design(mpu6050()), plan, 1))

    def blocks(trials: Sequence[Trial]) -> Iterator[LotEvidence]:
        return blocks_of(sets, wanted={trial.name for trial in trials}, at_once=13)

    whole, in_blocks = pooled_singly(sets), pool(blocks)
    assert in_blocks.sensors == whole.sensors
    assert [one.name for one in in_blocks.effects] == [one.name for one in whole.effects]
    assert [one.exponent for one in in_blocks.candidates] == pytest.approx(
        [one.exponent for one in whole.candidates], rel=1e-6, abs=1e-9)
    assert np.allclose(in_blocks.effects[0].size, whole.effects[0].size, rtol=1e-6)


def pooled(plan: LotPlan, seed: int = 1) -> Pool:
    return pool_of(pose_sets_of(draw_lot(paper_design(mpu6050()), plan, seed)))


def test_half_an_sd_in_each_of_a_hundred_sensors_is_found_in_the_pool_and_in_none_alone() -> None:
    plan = LotPlan(100, hidden="cubic", common_sd=0.5)
    sets = pose_sets_of(draw_lot(paper_design(mpu6050()), plan, 1))
    first = pool_of(sets).effects[0]
    assert first.name == "cubic"
    assert first.evidence.p_common < 1e-4
    assert first.only is None
    trial, lots = first.evidence.trial, [*blocks_of(sets[:20], at_once=1)]
    alone = [judge(trial, sums_of(lot, trial)) for lot in lots]
    assert min(each.p_value for each in alone if each) > 0.01 / len(lots[0].trials)


@pytest.mark.parametrize("bend_sd", [0.0, 1.0])
def test_a_line_in_the_temperature_is_no_curve_and_a_bend_is_one(bend_sd: float) -> None:
    """A curve contains the line, so that by itself it explains as much or a little more."""
    drawn = draw_lot(soak_design(), LotPlan(40, hidden="temperature_bias", common_sd=1.0), 3)
    sets = []
    for poses in pose_sets_of(drawn):
        warmth = poses.columns["temperature_c"]
        bend = ((warmth - warmth.mean()) / warmth.std()) ** 2
        error = 5 * bend_sd * poses.sd[0, 0] * bend[:, None] * [1.0, -0.8, 0.5]
        sets.append(replace(poses, reading=poses.reading + error, force=poses.reading + error))
    (effect,) = pool_of(sets).effects
    assert effect.name == ("temperature_bias_curve" if bend_sd else "temperature_bias")
    assert bend_sd or len([each for each in effect.sizes if each is not None]) == 3


def test_sizes_that_scatter_about_zero_are_found_by_their_spread() -> None:
    effect = pooled(LotPlan(100, hidden="hysteresis", spread_sd=1.0)).effects[0]
    assert effect.name == "hysteresis"
    assert effect.evidence.p_any < 1e-4
    assert all(each is not None and each.spread > 2 * each.spread_sd for each in effect.sizes)


def test_a_common_size_and_a_spread_about_it_are_told_apart() -> None:
    """Both have a mean, and p_common is far below p_any in either."""
    one_size, scattered = (
        pooled(LotPlan(60, hidden="cubic", common_sd=2.0, spread_sd=spread)).effects[0].evidence
        for spread in (0.0, 2.0))
    assert one_size.p_same > FALSE_ALARM > scattered.p_same


def test_one_sensor_that_shows_an_effect_is_named_and_not_the_lot() -> None:
    others = pose_sets_of(draw_lot(paper_design(mpu6050()), LotPlan(20), 6))
    (bent,) = pose_sets_of(draw_lot(
        paper_design(mpu6050()), LotPlan(1, hidden="cubic", common_sd=30.0), 7))
    names = [f"s{i}" for i in range(21)]
    (effect,) = pool_of([*others[:5], bent, *others[5:]], names).effects
    assert effect.name == "cubic"
    assert effect.only == "s5"


def test_nothing_is_named_where_nothing_is_missing() -> None:
    assert not any(pooled(LotPlan(60), seed).effects for seed in range(5))


def test_sds_that_are_wrong_by_a_factor_name_nothing() -> None:
    sets = pose_sets_of(draw_lot(paper_design(mpu6050()), LotPlan(100), 3))
    small = [each.take(range(18)) for each in sets]
    for each in small:
        each.sd[:] *= 0.8
    assert not pool_of(small).effects


def test_one_sensor_that_nothing_explains_does_not_speak_for_the_lot() -> None:
    sets = pose_sets_of(draw_lot(paper_design(mpu6050()), LotPlan(60), 4))
    broken = sets[7].take(range(18))
    broken.reading[[2, 5, 11]] *= [[1.01], [0.985], [1.02]]
    assert not pool_of([*sets[:7], broken, *sets[8:]]).effects


def test_evenings_of_one_sensor_count_as_one_sensor_in_its_sizes() -> None:
    plan = LotPlan(40, evenings=3, hidden="cubic", spread_sd=3.0)
    drawn = draw_lot(soak_design(), plan, 5)
    effect = pool_of(pose_sets_of(drawn), [f"s{unit}" for unit in drawn.unit]).effects[0]
    assert effect.name == "cubic"
    assert all(size is not None and size.sensors == 40 for size in effect.sizes)
    slope = np.polyfit(drawn.size[::3, 0], effect.size[:, 0], 1)[0]
    assert slope == pytest.approx(1.0, abs=0.1)


def test_a_large_lot_is_not_fooled_by_sds_that_each_session_estimates() -> None:
    """800 sessions of 400 sensors, the sd of each from 12.6 degrees of freedom."""
    drawn = draw_lot(paper_design(mpu6050()), LotPlan(400, evenings=2, noise_dof=0.7), 6)
    pooled_lot = pool_of(pose_sets_of(drawn, 0.7), [f"{unit}" for unit in drawn.unit])
    assert not pooled_lot.effects
