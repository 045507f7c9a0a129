"""Many diagnoses at once are those of one after the other, whatever is mixed."""

from collections import Counter

import numpy as np
import pytest

from calib.diagnosis.finding import Finding, find, find_many
from calib.diagnosis.search import together
from calib.effects.catalogue import BASE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.lots import pose_sets_of
from tests.set_trials import hand_design
from tests.trials import hidden_of, poses_of
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot

HIDDEN = (None, "quadratic", "warm_up", "hysteresis", "temperature_bias", "cross_quadratic")


def lot(design: Design, seed: int, each: int) -> list[Fit]:
    """Accelerometers of ``each`` evening, with nothing and with everything of ``HIDDEN``."""
    fits = []
    for name in HIDDEN:
        plan = LotPlan(each, hidden=name, own_sd=(5.0, 40.0))
        fits += [fit(p, Model.of(BASE)) for p in pose_sets_of(draw_lot(design, plan, seed))]
    return fits


def gyroscopes() -> list[Fit]:
    """Two of another design, with logged columns and rows of two kinds."""
    design = rich_design()
    fits = []
    for seed, names in ((91, ("g_sensitivity", "cubic")), (92, ())):
        hidden = hidden_of(names, "gyroscope", 8.0, design, seed)
        assert hidden is not None
        fits.append(fit(poses_of(design, seed, "gyroscope", hidden), Model.of(BASE)))
    return fits


def assert_same(one: Finding, other: Finding) -> None:
    """Within what weighing leaves open: its chi-square is exact to 1e-4."""
    assert one.verdict.code == other.verdict.code
    assert one.verdict.names == other.verdict.names
    assert one.verdict.group == other.verdict.group
    assert one.blind == other.blind
    assert [i.members for i in one.inclusion] == [i.members for i in other.inclusion]
    stated = [[i.probability for i in each.inclusion] for each in (one, other)]
    assert stated[0] == pytest.approx(stated[1], abs=1e-4)
    assert one.state.entries.keys() == other.state.entries.keys()


@pytest.fixture(scope="module")
def mixed() -> list[Fit]:
    """Three designs, in an order by chance."""
    fits = [*lot(paper_design(mpu6050()), 3, 3), *lot(hand_design(), 4, 2), *gyroscopes()]
    return [fits[i] for i in np.random.default_rng(5).permutation(len(fits))]


def test_many_findings_are_those_of_one_after_the_other(mixed: list[Fit]) -> None:
    many = find_many(mixed)
    assert len({found.verdict.code for found in many}) >= 3, Counter(f.verdict.code for f in many)
    for each, found in zip(mixed, many, strict=True):
        assert_same(find(each), found)


def test_however_many_stand_in_one_stack(
    mixed: list[Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    many = find_many(mixed[:12])
    monkeypatch.setattr(together, "AT_ONCE", 2)
    for one, other in zip(many, find_many(mixed[:12]), strict=True):
        assert_same(one, other)


def test_of_no_fits_there_are_no_findings() -> None:
    assert find_many([]) == []


def test_a_finding_in_a_crowd_is_that_of_its_own_session(mixed: list[Fit]) -> None:
    """A negative control: sessions with something hidden do not lend it to sound ones."""
    sound = lot(paper_design(mpu6050()), 6, 2)[:2]
    for one, other in zip(find_many(sound), find_many([*mixed, *sound])[-2:], strict=True):
        assert_same(one, other)
