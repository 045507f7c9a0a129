"""What poses see of an effect does not depend on where it is counted from."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.effects.variation import about_mean
from calib.poses.conditions import Conditions
from calib.poses.imu_log import Triad
from tests.calib.made_poses import pairs, some_conditions

COUNTED = [name for name, effect in EFFECTS.items()
           if effect.constant_is is not None and (effect.shape is None or effect.shape.is_fitted)]
"""Effects that are a bias or a gain where nothing varies; not those that have a place of their own,
the mean temperature or the time of a step."""


def at_another_origin(at: Conditions) -> Conditions:
    """The same conditions 11 °C warmer, an hour later, of a sensor with more noise."""
    warmer = {**at.columns, "temperature_c": at.columns["temperature_c"] + 11.0}
    return replace(at, columns=warmer, time_s=at.time_s + 3600.0,
                   since_middle_s=at.since_middle_s + 3600.0, vibration=at.vibration + 0.3)


def without_a_course(at: Conditions) -> Conditions:
    """The same attitudes at one time, in one temperature and with one vibration."""
    return replace(at, time_s=np.full(len(at), 311.7),
                   since_middle_s=np.full(len(at), 11.7), vibration=np.full((len(at), 3), 0.02),
                   columns={**at.columns, "temperature_c": np.full(len(at), 29.87)})


@pytest.mark.parametrize(("name", "triad"), pairs(COUNTED))
def test_how_an_effect_varies_does_not_depend_on_where_it_is_counted_from(
    name: str, triad: Triad
) -> None:
    effect, at = EFFECTS[name], some_conditions(triad)
    here, there = (about_mean(effect, BASE, each).evaluate(each)
                   for each in (at, at_another_origin(at)))
    # An hour later a warm-up has the same course, and less of it.
    factor = np.exp(3600.0 / effect.shape.starts[0]) if effect.shape is not None else 1.0
    assert factor * there == pytest.approx(here, abs=1e-9 * np.abs(here).max())
    assert about_mean(effect, ("misalignment",), at) is effect


@pytest.mark.parametrize(("name", "triad"), pairs(COUNTED))
def test_of_an_effect_in_conditions_that_do_not_vary_nothing_is_left(
    name: str, triad: Triad
) -> None:
    still = without_a_course(some_conditions(triad))
    assert not about_mean(EFFECTS[name], BASE, still).evaluate(still).any()
    assert EFFECTS[name].evaluate(still).any()


def test_what_is_a_bias_where_nothing_varies_is_counted_as_one() -> None:
    """Else the sampling noise of a variance would show it, with a bias a hundred times as large."""
    still = without_a_course(some_conditions("gyroscope"))
    for name, effect in EFFECTS.items():
        if name not in BASE and effect.acts_on == "sensor" and not (
                effect.drawn or effect.shape):
            with np.errstate(invalid="ignore"):  # a row may have no direction
                columns = effect.evaluate(still)
            is_bias = columns.any() and bool((columns == columns[0]).all())
            assert not is_bias or effect.constant_is == "bias", name


@pytest.mark.parametrize("name", COUNTED)
def test_the_part_that_does_not_vary_is_a_bias_or_a_gain(name: str) -> None:
    effect, at = EFFECTS[name], some_conditions("gyroscope")
    rest = effect.evaluate(at) - about_mean(effect, BASE, at).evaluate(at)
    if effect.acts_on == "reference":
        per = np.where(at.magnitude > 0, at.magnitude, 0.0)[:, None]
    else:
        per = EFFECTS[str(effect.constant_is)].evaluate(at)
    factor = (rest * per).sum() / (per * per).sum()
    assert rest == pytest.approx(factor * per, abs=1e-12 * np.abs(rest).max())
