"""Formulas that look the same: they go with the effect that was written for one of them, and a step
in time may be one along a logged column."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import yaml

from calib.diagnosis.stand_ins import stand_ins
from calib.discovery.discover import Discovered
from calib.discovery.grammar import formulas
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from pipeline.config.schema import EffectSection
from pipeline.next_change import definition, effect_key, may_follow_a_column
from pipeline.stages.triads import TriadResult
from tests.calib.made_poses import noisy, rich_poses


def test_an_effect_stands_for_the_formulas_that_look_the_same() -> None:
    poses = noisy(rich_poses("gyroscope", 3), 3)
    one, other, *_ = [each for each in formulas(poses, ("temperature_c",))
                      if each.factor == "bias" and each.column == "temperature_c"]
    base = Model(tuple(EFFECTS[name] for name in BASE))
    found = Discovered(one, (other,), 9.0, 2.0, 1.0, fit(poses, base))
    section = EffectSection(**yaml.safe_load(definition("gyroscope", found)))
    assert section.alike == (other.expression,)
    effect = replace(one.effect, alike=section.alike)
    model = fit(poses, Model((*base.effects, effect)))
    assert {name: each.names for name, each in stand_ins(model, ()).items()} == {
        one.name: (other.expression,)}


def test_a_name_that_another_triad_has_gets_the_triad() -> None:
    poses = rich_poses("gyroscope", 3)
    one = next(each for each in formulas(poses, ("temperature_c",)) if each.column)
    found = Discovered(one, (), 9.0, 2.0, 1.0, fit(noisy(poses, 3), Model.of(BASE)))
    mine = EffectSection(**yaml.safe_load(definition("gyroscope", found)))
    theirs = mine.model_copy(update={"triad": "accelerometer"})
    assert effect_key("gyroscope", found, {}) == one.name
    assert effect_key("gyroscope", found, {one.name: mine}) == one.name
    assert effect_key("gyroscope", found, {one.name: theirs}) == f"{one.name}_gyroscope"


@pytest.mark.parametrize(("name", "columns", "may"), [
    ("bias_step", {"temperature_c": np.linspace(20, 30, 130)}, True),
    ("bias_step", {"temperature_c": np.full(130, 20.0), "heading": np.arange(130.0)}, False),
    ("bias_drift", {"temperature_c": np.linspace(20, 30, 130)}, False),
])
def test_a_step_in_time_is_compared_with_steps_along_what_was_logged(
    name: str, columns: dict[str, np.ndarray], may: bool
) -> None:
    poses = replace(rich_poses("gyroscope", 3), columns=columns)
    result = SimpleNamespace(diagnosis=SimpleNamespace(name=name),
                             calibration=SimpleNamespace(fit=SimpleNamespace(poses=poses)))
    assert may_follow_a_column(cast(TriadResult, result), None) is may
