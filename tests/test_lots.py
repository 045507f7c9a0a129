"""Lots drawn all at once are evenings: the right model leaves nothing of them but noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE, find_effect
from calib.effects.column import column_effect
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import extend, fit_sets
from calib.fit.model import Model
from tests.lots import pose_sets_of
from tests.world.bench import HUMIDITY, Design
from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.imu import mpu6050
from tests.world.lot import Lot, LotPlan, draw_lot
from tests.world.turning_lot import draw_turning_lot


def turning_design() -> Design:
    return replace(paper_design(mpu6050()), columns={"humidity_pct": HUMIDITY})


def without_noise(lot: Lot) -> list[Fit]:
    sets = pose_sets_of(replace(lot, counts=lot.true_counts))
    return [fits.fitted.one(k) for fits in fit_sets(sets, Model.of(BASE)) if fits.fitted
            for k in range(len(fits.fitted))]


def test_gyroscopes_without_noise_are_their_nine_parameters() -> None:
    for one in without_noise(draw_turning_lot(turning_design(), LotPlan(20), 1)):
        assert one.chi2 < 1e-12


def test_noise_of_gyroscopes_is_what_they_state() -> None:
    plan = LotPlan(1000)
    sets = pose_sets_of(draw_turning_lot(turning_design(), plan, 2))
    stacks = list(fit_sets(sets, Model.of(BASE)))
    assert not any(fits.refusals for fits in stacks)
    p_value = np.concatenate([fits.fitted.p_value for fits in stacks if fits.fitted])
    assert 0.005 < (p_value < 0.01).mean() < 0.02  # three counting errors about one in 100
    assert 0.45 < (p_value < 0.5).mean() < 0.55


@pytest.mark.parametrize("name", [
    "quadratic", "cubic", "asymmetry", "temperature_bias", "temperature_scale", "bias_drift",
    "scale_drift", "hysteresis", "reference_drift", "column:humidity_pct",
])
def test_an_effect_hidden_in_gyroscopes_is_all_that_is_wrong(name: str) -> None:
    plan = LotPlan(4, hidden=name, own_sd=(20.0, 20.0))
    column = name.partition(":")[2]
    effect = column_effect(column) if column else find_effect(name)
    for one in without_noise(draw_turning_lot(turning_design(), plan, 3)):
        assert one.chi2 > 20
        assert extend(one, (effect,)).chi2 < 1e-3


def test_what_one_speed_cannot_show_leaves_nothing() -> None:
    plan = LotPlan(4, hidden="g_sensitivity", own_sd=(20.0, 20.0))
    for one in without_noise(draw_turning_lot(turning_design(), plan, 4)):
        assert one.chi2 < 0.1


def test_poses_at_rest_are_no_turning_lot() -> None:
    with pytest.raises(ValueError, match="one run on the turning plate"):
        draw_turning_lot(rich_design(), LotPlan(1), 5)


def test_a_chamber_warms_the_poses_of_its_run() -> None:
    lot = draw_lot(soak_design(), LotPlan(50), 6)
    room, warm, again = np.split(lot.columns["temperature_c"].mean(axis=0), 3)
    assert warm.min() - room.max() > 15
    assert warm.min() - again.max() > 12  # the sensor itself has warmed by some degrees
    assert lot.time_s[26] - lot.time_s[25] > 1200


def test_a_temperature_effect_shows_in_a_chamber() -> None:
    plan = LotPlan(4, hidden="temperature_bias", own_sd=(20.0, 20.0))
    for one in without_noise(draw_lot(soak_design(), plan, 7)):
        assert one.chi2 > 100
        assert extend(one, (find_effect("temperature_bias"),)).chi2 < 1e-3
