"""Laws of the diagnosis: what says nothing of the sensor changes no verdict and no probability."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calib.diagnosis.finding import Finding, find
from calib.effects.catalogue import BASE
from calib.errors import FitFailed
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import TEMPERATURE
from calib.poses.pose_set import PoseSet
from tests.calib.leaning_poses import gyro_poses
from tests.lots import pose_sets_of
from tests.set_trials import hand_design
from tests.world.bench import Design
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot


def low_cost() -> Design:
    return paper_design(mpu6050())


def with_column(seed: int, zero: float, unit: float, size: float = 12.0) -> PoseSet:
    """18 poses whose bias follows a logged column by ``size`` sds, the column ``zero`` ± ``unit``.
    """
    poses = pose_sets_of(draw_lot(low_cost(), LotPlan(1), seed))[0]
    varying = np.random.default_rng(seed).standard_normal(len(poses))
    error = size * varying[:, None] * poses.sd * [0.8, -1.0, 0.6]
    columns = {**poses.columns, "pressure": zero + unit * varying}
    return replace(poses, reading=poses.reading + error, columns=columns)


def finding_of(poses: PoseSet) -> Finding:
    return find(fit(poses, Model.of(BASE)))


@cache
def small_lot(
    design: Callable[[], Design], hidden: str | None, sds: float, seed: int
) -> list[tuple[PoseSet, Finding]]:
    """Two sessions with an effect of so many sds, and what is found in them as they are."""
    lot = draw_lot(design(), LotPlan(2, hidden=hidden, own_sd=(sds, sds)), seed)
    return [(poses, finding_of(poses)) for poses in pose_sets_of(lot)]


@pytest.mark.parametrize(("zero", "unit"), [(3.3, 0.01), (1013.0, -0.5), (1e4, 1.0)])
def test_the_zero_and_the_unit_of_a_column_change_no_verdict(zero: float, unit: float) -> None:
    for seed in (401, 402, 403):
        one, other = finding_of(with_column(seed, 0.0, 0.1)), finding_of(
            with_column(seed, zero, unit))
        assert one.verdict.names == ("column:pressure",)
        assert other.verdict.names == one.verdict.names
        stated = [[i.probability for i in each.posterior.inclusion] for each in (one, other)]
        assert stated[1] == pytest.approx(stated[0], abs=2e-3)


@pytest.mark.parametrize("hidden", ["temperature_bias", "temperature_scale"])
@pytest.mark.parametrize("zero", [273.15, 2e4, -2e4])
def test_the_zero_of_the_temperature_changes_no_verdict(hidden: str, zero: float) -> None:
    """In kelvin, and 10,000 sds away: a gain by such a column was no fit, or a curve."""
    for poses, one in small_lot(low_cost, hidden, 20.0, 404):
        moved = {TEMPERATURE: poses.columns[TEMPERATURE] + zero}
        other = finding_of(replace(poses, columns=moved))
        assert (other.verdict.code, other.verdict.group) == (one.verdict.code, one.verdict.group)
        stated = [each.posterior.any_of(each.verdict.group) for each in (one, other)]
        assert stated[1] == pytest.approx(stated[0], abs=0.02)


@pytest.mark.parametrize("zero", [24.0, 297.0])
def test_a_temperature_that_stays_has_no_gain_on_a_leaning_plate_either(zero: float) -> None:
    """Waves of a gain were counted from 25 °C, those of the base not: the rest had a name."""
    poses, _ = gyro_poses(3.0, hide=False)
    steady = zero + 1e-3 * np.random.default_rng(1).standard_normal(len(poses))
    said = finding_of(replace(poses, columns={TEMPERATURE: steady})).verdict
    assert said.code == "nothing_missing"


def test_what_the_fit_holds_absorbs_nothing() -> None:
    """The poses see one combination of x·y·z: with the others projected out no residual was left,
    and nothing was missing at p = 5e-12."""
    plan = LotPlan(6, hidden="cubic", own_sd=(12.0, 12.0))
    model = Model.of((*BASE, "cross_quadratic"))
    judged = 0
    for poses in pose_sets_of(draw_lot(low_cost(), plan, 405)):
        try:
            base = fit(poses, model)
        except FitFailed:
            continue
        finding = find(base)
        assert finding.posterior.table.chi2 == pytest.approx(base.chi2, rel=0.05)
        if base.p_value < 1e-3:
            judged += 1
            assert finding.verdict.code != "nothing_missing"
    assert judged >= 2


def test_nothing_is_not_said_against_its_own_probability() -> None:
    nothing = 0
    for hidden in ("temperature_bias", "cubic", "bias_drift"):
        plan = LotPlan(4, hidden=hidden, own_sd=(2.0, 3.0))
        for poses in pose_sets_of(draw_lot(low_cost(), plan, 406)):
            finding = finding_of(poses)
            if finding.verdict.code == "nothing_missing":
                assert finding.posterior.nothing >= 0.5
                assert finding.posterior.p_value > 1e-3
                nothing += 1
    assert nothing


def turned(poses: PoseSet, axes: list[int], signs: list[float]) -> PoseSet:
    """The same session of a sensor whose axes have other names and senses."""
    return replace(
        poses, reading=poses.reading[:, axes] * signs, sd=poses.sd[:, axes],
        force=poses.force[:, axes] * signs, expected=poses.expected[:, axes] * signs,
        vibration=poses.vibration[:, axes],
    )


def in_another_order(poses: PoseSet) -> PoseSet:
    return poses.take(np.random.default_rng(7).permutation(len(poses)))


def with_columns_turned(poses: PoseSet) -> PoseSet:
    return replace(poses, columns={name: 300.0 - 7.0 * values
                                   for name, values in poses.columns.items()})


def with_axes_in_another_order(poses: PoseSet) -> PoseSet:
    return turned(poses, [1, 2, 0], [1.0, 1.0, 1.0])


def with_an_axis_turned(poses: PoseSet) -> PoseSet:
    return turned(poses, [0, 1, 2], [1.0, -1.0, 1.0])


@pytest.mark.parametrize(("law", "name"), [
    (in_another_order, None), (in_another_order, "hysteresis"),
    (in_another_order, "temperature_bias"), (with_columns_turned, None),
    (with_columns_turned, "temperature_bias"), (with_columns_turned, "warm_up"),
    (with_axes_in_another_order, "quadratic"), (with_axes_in_another_order, "hysteresis"),
    (with_an_axis_turned, "quadratic"), (with_an_axis_turned, "hysteresis"),
])
def test_what_only_names_things_changes_no_probability(
    law: Callable[[PoseSet], PoseSet], name: str | None
) -> None:
    for poses, one in small_lot(hand_design, name, 8.0, 407):
        other = finding_of(law(poses))
        assert other.verdict.code == one.verdict.code
        assert {*other.verdict.group} == {*one.verdict.group}
        stated = [{i.name: i.probability for i in each.posterior.inclusion}
                  for each in (one, other)]
        for each in stated[0].keys() & stated[1].keys():
            assert stated[1][each] == pytest.approx(stated[0][each], abs=0.02)
