"""Pose means without sds: an effect far above whatever noise they have is named, less is not."""

from dataclasses import replace

import numpy as np

from calib.assess import AssessedTriad, assess
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE
from calib.fit.model import Model
from tests.fitting import spec_of
from tests.lots import pose_sets_of
from tests.set_trials import hand_design
from tests.world.lot import LotPlan, draw_lot


def assessed_without_sds(plan: LotPlan, seed: int) -> list[AssessedTriad]:
    lot = draw_lot(hand_design(), plan, seed)
    spec = spec_of(lot.triad, lot.triad.full_scale)
    return [assess(replace(poses, sd=np.full_like(poses.sd, np.nan)), Model.of(BASE), spec)
            for poses in pose_sets_of(lot)]


def test_a_strong_effect_is_named_although_nobody_stated_the_noise() -> None:
    """26 poses; the residual falls to a thirtieth with it, which no other noise does."""
    plan = LotPlan(4, hidden="quadratic", own_sd=(30.0, 30.0))
    said = [each.diagnosis for each in assessed_without_sds(plan, 411)]
    named = [each for each in said if each.verdict == Code.EFFECT]
    assert len(named) >= 3
    assert all("quadratic" in each.group for each in named)
    assert all("have no sds" in each.text for each in named)


def test_without_sds_nothing_is_said_to_be_complete() -> None:
    said = [each.diagnosis for each in assessed_without_sds(LotPlan(8), 412)]
    assert {each.verdict for each in said} == {Code.REFUSED}
