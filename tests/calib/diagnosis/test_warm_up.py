"""A warm-up of two time constants is asked for where the data show two, and only there.

A slow one is not taken apart into a faster one and a straight line.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from tests.calib.made_poses import some_conditions
from tests.set_trials import design_of, draw_set
from tests.trials import poses_of
from tests.world.designs import soak_design
from tests.world.sizes import draw_effect

SOAK = soak_design().scaled(sample_rate=0.25)


def added_until_nothing_is_missing(seed: int, taus_s: Sequence[float]) -> tuple[list[str], Fit]:
    """What the diagnosis of a simulated soak names, one after the other, and the last fit."""
    hidden = []
    for k, tau_s in enumerate(taus_s):
        one = draw_effect("warm_up", "accelerometer", 30.0, SOAK, seed + 1000 * k)
        hidden.append(replace(one, detail={**one.detail, "tau_s": tau_s}))
    poses, names = poses_of(SOAK, seed, "accelerometer", hidden), []
    for _ in range(4):
        last = fit(poses, Model.of((*BASE, *names)))
        said = diagnose(last)
        if said.verdict != "effect":
            assert said.verdict == "nothing_missing", said.text
            break
        names += said.names
    return names, last


def test_one_time_constant_is_one_name_and_two_are_two() -> None:
    assert added_until_nothing_is_missing(1, [])[0] == []
    names, one = added_until_nothing_is_missing(1, [1500.0])
    assert names == ["warm_up"]
    assert one.shapes["warm_up"] == pytest.approx(1500, rel=0.05)
    names, two = added_until_nothing_is_missing(1, [120.0, 1500.0])
    assert names == ["warm_up", "warm_up_2"]
    assert sorted(two.shapes.values()) == pytest.approx([120, 1500], rel=0.1)


@pytest.mark.parametrize("seed", [660403, 660422])
def test_no_drift_is_named_beside_a_slow_warm_up(seed: int) -> None:
    hand = design_of("hand", seed)
    hidden = draw_set(hand, seed, "accelerometer", 2, (5.0, 100.0))
    (slow,) = (one for one in hidden if one.name == "warm_up")
    said = diagnose(fit(poses_of(hand, seed, "accelerometer", hidden), Model.of(BASE)))
    assert slow.detail["tau_s"] > 700
    assert {*said.names} == {one.name for one in hidden}


def test_the_second_has_the_columns_of_the_first_at_its_own_time_constant() -> None:
    at, first, second = some_conditions("gyroscope"), *map(find_effect, ("warm_up", "warm_up_2"))
    assert second.evaluate(at, 90.0) == pytest.approx(first.evaluate(at, 90.0))
    assert second.evaluate(at)[:, 0, 0] == pytest.approx(np.exp(-at.time_s / 75.0))
    assert second.page.expressions == first.page.expressions
