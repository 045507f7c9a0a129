"""A formula is recovered, judged on poses that took no part, and none is found where none is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.table_at import table_at
from calib.discovery.discover import discover
from calib.discovery.grammar import formulas
from calib.discovery.screen import FormulaScreen
from calib.discovery.together import discover_each
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.past import behind, with_pasts
from calib.poses.pose_set import PoseSet
from tests import third_formulas, trials
from tests.calib.made_poses import noisy, rich_poses
from tests.hidden_formulas import SEEN, hide, poses_of, recovered
from tests.set_trials import design_of
from tests.third_formulas import with_bench_columns


@pytest.mark.parametrize(("name", "design"), [
    ("bias ~ power²", "rich"), ("gain ~ humidity", "rich"), ("|s| ~ humidity", "hand"),
    ("bias ~ tanh of power", "hand"),
])
def test_what_was_hidden_is_recovered(name: str, design: str) -> None:
    assert recovered(SEEN[name], design, 20.0, 3)[0]


def dead_band(s: FloatArray) -> FloatArray:
    """Error of an axis that answers nothing until it senses 0.004 rad/s, and that much less."""
    return np.where(np.abs(s) < 0.004, -s, -0.004 * np.sign(s))


def soft_limit(s: FloatArray) -> FloatArray:
    """Error of an axis that answers by 3 % less beyond 2.6 rad/s."""
    return np.where(np.abs(s) > 2.6, -0.03 * np.sign(s) * (np.abs(s) - 2.6), 0.0)


@pytest.mark.parametrize(("response", "words"), [
    (dead_band, "its reading as far as 0."), (soft_limit, "its reading as far as 2."),
])
def test_the_response_of_an_axis_has_its_limit(
    response: Callable[[FloatArray], FloatArray], words: str
) -> None:
    true = rich_poses("gyroscope", 8)
    poses = noisy(replace(true, reading=true.reading + response(true.reading)), 8)
    found = discover(fit(poses, Model.of(BASE)))
    assert found is not None
    assert found.listed is None
    assert words in found.formula.words
    assert found.left_out_after < 1.3 < 2 < found.left_out_before


@pytest.mark.parametrize("design", ["rich", "hand"])
def test_there_is_no_formula_in_noise(design: str) -> None:
    for seed in range(20, 22):
        assert discover(fit(poses_of(design, seed)[0], Model.of(BASE))) is None


def test_what_no_column_drives_has_no_formula() -> None:
    """Errors drawn anew in every pose, three times the noise."""
    for seed in range(2):
        poses, _ = poses_of("rich", seed)
        noise = np.random.default_rng([seed, 7]).normal(size=poses.sd.shape)

        spoilt = replace(poses, reading=poses.reading + 3 * poses.sd * noise)
        assert discover(fit(spoilt, Model.of(BASE))) is None


@pytest.mark.parametrize(("name", "triad"), [
    ("g_sensitivity", "gyroscope"), ("temperature_bias", "accelerometer"),
    ("temperature_bias", "gyroscope"), ("quadratic", "accelerometer"),
])
def test_a_listed_effect_that_does_as_well_is_named_instead(name: str, triad: Triad) -> None:
    true = rich_poses(triad, 6)
    effect = find_effect(name)
    columns = effect.evaluate(true.conditions(true.reading))
    errors = columns @ np.random.default_rng(6).normal(size=columns.shape[2])
    errors = errors - errors.mean(axis=0)
    size = np.sqrt(np.mean((errors / true.sd) ** 2))
    poses = noisy(replace(true, reading=true.reading + 20 / size * errors), 6)
    found = discover(fit(poses, Model.of(BASE)))
    assert found is not None
    assert found.listed == name
    assert found.left_out_listed < 1.05 * found.left_out_after


def with_lag(triad: Triad, poses: int, size: float) -> PoseSet:
    """Poses while a room warms by 14 K, with a bias that follows its temperature 240 s late."""
    true = rich_poses(triad, 5).take(np.arange(0, poses, 3 if triad == "accelerometer" else 1))
    temperature = 34 - 14 * np.exp(-(true.time_s - true.time_s.min()) / 900.0)
    lag = behind(temperature, true.time_s, 240.0)
    error = (lag - lag.mean()) / np.ptp(lag) * size * true.sd.mean()
    return noisy(replace(true, reading=true.reading + error[:, None] * np.array([4.0, -2.0, 3.0]),
                         columns={**true.columns, "temperature_c": temperature}), 5)


def test_a_triad_follows_what_the_other_does_where_its_poses_leave_it_open() -> None:
    fits = [fit(with_lag("accelerometer", 78, 4.0), Model.of(BASE)),
            fit(with_lag("gyroscope", 130, 10.0), Model.of(BASE))]
    alone = discover(fits[0])
    assert alone is not None
    assert alone.formula.words == "the bias of each axis follows temperature_c"
    together = discover_each(fits)
    assert [one.formula.expression for one in together if one] == ["lag(temperature_c, 240)"] * 2
    assert together[0] is not None
    assert len(together[0].alike) > 10


def test_a_step_where_a_column_passes_a_value_is_taken_from_the_other_triad() -> None:
    """The accelerometer has 26 poses at a temperature that only rises: they show no formula."""
    pair = []
    for triad, every in (("accelerometer", 3), ("gyroscope", 1)):
        true = rich_poses(triad, 7)
        true = true.take(np.arange(0, len(true), every))
        warmth = np.linspace(20, 30, len(true)) if every > 1 else (
            25 + 5 * np.sin(np.linspace(0, 20, len(true))))
        error = 8 * true.sd.mean() * (warmth > 26.5)[:, None] * np.array([1.0, -0.5, 0.7])
        pair.append(fit(noisy(replace(true, reading=true.reading + error, columns={
            **true.columns, "temperature_c": warmth}), 7), Model.of(BASE)))
    assert discover(pair[0]) is None
    together = discover_each(pair)
    assert together[1] is not None
    assert together[1].formula.words.startswith("the bias of each axis follows a step where temp")
    assert [one.formula.function for one in together if one] == [together[1].formula.function] * 2


def test_a_formula_says_what_errs_and_what_it_follows() -> None:
    poses, true = poses_of("rich", 5)
    spoilt = hide(SEEN["bias ~ power²"], poses, true, 20.0, 5)
    found = discover(fit(spoilt, Model.of(BASE)))
    assert found is not None
    assert found.formula.words == "the bias of each axis follows the square of tx_power_w"
    assert found.formula.expression == "tx_power_w**2"
    assert found.formula.effect.unit == "(rad/s)/W²"
    assert found.listed is None
    assert found.left_out_after < 1.2 < 5 < found.left_out_before


def test_a_gain_that_follows_the_force_along_its_axis_is_no_function_of_the_clock() -> None:
    true = rich_poses("gyroscope", 8)
    hidden = 5e-5 * true.reading * true.force * np.array([1.0, -0.8, 0.7])
    found = discover(fit(noisy(replace(true, reading=true.reading + hidden), 8), Model.of(BASE)))
    assert found is not None
    assert found.formula.expression == "s * f"
    assert found.left_out_after < 1.3 < 2 < found.left_out_before


def test_every_formula_is_an_effect_of_its_own() -> None:
    poses, _ = poses_of("hand", 5, more=with_bench_columns)
    every = formulas(poses, tuple(poses.columns))
    assert len(every) > 5000
    assert len({each.name for each in every}) == len(every)
    for one in every[::97]:
        known = with_pasts(poses, one.effect.pasts)
        assert np.isfinite(one.effect.evaluate(known.conditions(known.reading))).all()
        assert one.words.startswith(("the ", "an error"))


def test_the_screen_is_the_table_of_hypotheses() -> None:
    """Densities by arrays are those of the effects one by one, lags included."""
    poses, true = poses_of("hand", 6)
    base = fit(hide(SEEN["bias ~ power²"], poses, true, 5.0, 6), Model.of(BASE))
    some = formulas(poses, tuple(poses.columns))[::211]
    pasts = [past for each in some for past in each.effect.pasts]
    with_them = fit(with_pasts(base.poses, pasts), Model.of(BASE))
    table = table_at(with_them, [Hypothesis(each.name, "listed", 0.0, each.effect)
                                 for each in some])
    assert FormulaScreen(base).log_densities(some) == pytest.approx(table.singles()[0], rel=1e-6)


@pytest.mark.parametrize("name", ["bias ~ direction of the temperature's change",
                                  "bias ~ power / fan", "bias ~ twice the mains"])
def test_what_a_bench_does_is_recovered(name: str) -> None:
    right, words = recovered(third_formulas.SEEN[name], "hand", 20.0, 3, more=with_bench_columns)
    assert right, words


def test_a_bias_that_wanders_has_no_formula() -> None:
    """It steps by chance, and a step predicts four fifths of the poses better."""
    design = design_of("hand", 41001)
    hidden = trials.hidden_of(["wander"], "accelerometer", 5.0, design, 41001)
    assert hidden is not None
    poses = trials.poses_of(design, 41001, "accelerometer", hidden)
    assert discover(fit(poses, Model.of(BASE))) is None
