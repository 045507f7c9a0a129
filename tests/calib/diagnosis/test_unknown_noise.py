"""Pose means without sds: an effect far above whatever noise they have is named, less is not.

Sds that are too large are called so.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

from calib.assess import AssessedTriad, assess
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.fitting import spec_of
from tests.lots import pose_sets_of
from tests.set_trials import hand_design
from tests.trials import poses_of
from tests.world.designs import rich_design
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


@pytest.mark.parametrize(("times", "remark"), [(1.0, False), (3.0, True)])
def test_sds_that_the_residual_is_too_small_for_are_called_too_large(
    times: float, remark: bool
) -> None:
    poses = poses_of(rich_design().scaled(sample_rate=0.25), 0, "gyroscope", ())
    found = diagnose(fit(replace(poses, sd=times * poses.sd), Model.of(BASE)))
    assert found.verdict == "nothing_missing"
    stated = re.search(r"the poses scatter ([\d.]+) times less than their sds", found.text)
    assert bool(stated) == remark
    if stated:
        assert float(stated[1]) == pytest.approx(times, rel=0.25)
