"""Several things missing at once, what no catalogue has, and what may not be named.

``python -m tests.bench.study_diagnosis sets`` counts the same on many sessions.
"""

from dataclasses import fields, replace

import numpy as np
import pytest

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses.columns import causes, is_cause
from calib.diagnosis.verdict.wording import odds_in_words
from calib.effects.catalogue import BASE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import Triad
from tests.calib.made_poses import base_theta, noisy, read_through, rich_poses, with_noise
from tests.hidden_formulas import SEEN, UNSEEN, hide
from tests.hidden_formulas import poses_of as outside_poses
from tests.set_trials import design_of, disturbed, scored
from tests.trials import hidden_of, poses_of


def base_of(
    design_name: str, triad: Triad, names: tuple[str, ...], size: float, seed: int
) -> Fit:
    design = design_of(design_name, seed)
    hidden = hidden_of(names, triad, size, design, seed)
    assert hidden is not None
    return fit(poses_of(design, seed, triad, hidden), Model.of(BASE))


def said(
    design_name: str, triad: Triad, names: tuple[str, ...], size: float, seed: int
) -> Diagnosis:
    return diagnose(base_of(design_name, triad, names, size, seed))


# --- several at once ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "names",
    [("g_sensitivity", "cubic", "temperature_bias"), ("quadratic", "hysteresis", "scale_drift"),
     ("bias_drift", "cross_quadratic", "g_squared_sensitivity")],
)
@pytest.mark.parametrize("size", [5.0, 70.0])
def test_three_effects_are_named_at_once(names: tuple[str, ...], size: float) -> None:
    """At 5 sd one of the three may be offered only."""
    found = scored(31, find(base_of("rich", "gyroscope", names, size, 31)), names)
    assert set(found.offered) == set(names), found.text
    assert found.wrong == ()
    assert len(found.named) >= 3 - (size == 5.0)


@pytest.mark.parametrize("seed", [41, 43])
def test_two_effects_of_an_accelerometer_in_26_poses_are_named_or_offered(seed: int) -> None:
    names = ("quadratic", "hysteresis")
    found = scored(seed, find(base_of("hand", "accelerometer", names, 30.0, seed)), names)
    assert set(found.offered) == set(names), found.text
    assert found.wrong == ()


@pytest.mark.parametrize(("name", "size"), [
    ("vibration_rectification", 1000.0), ("cross_quadratic", 300.0)])
def test_a_scattering_plate_takes_no_strong_effect_s_place(name: str, size: float) -> None:
    """A rate of its own for every pose would hide any error: 300 to 1000 sd are 1 % of a rate."""
    found = said("rich", "gyroscope", (name,), size, 7101)
    assert found.names == (name,), found.text
    assert "rate_scatter" not in {each.name for each in found.inclusion}


def test_what_looks_the_same_does_so_at_every_strength() -> None:
    """With one speed two quadratic effects are one class, up to sizes that no part has."""
    for size in (10.0, 30.0, 100.0):
        found = said("paper", "gyroscope", ("quadratic",), size, 7102)
        assert {"quadratic", "g_squared_sensitivity"} <= {*found.group}, found.text
        assert found.verdict == "effect"


@pytest.mark.parametrize("size", [5.0, 30.0, 100.0, 300.0])
@pytest.mark.parametrize("design", ["soak", "hand"])
def test_more_signal_never_means_less_verdict(design: str, size: float) -> None:
    """At 300 sd it takes 84 % of an axis's gain at 1 g; more than all turns the response back."""
    found = said(design, "accelerometer", ("cubic",), size, 57)
    assert found.verdict == "effect"
    assert found.names == ("cubic",)
    assert "of the misfit remain" not in found.text


# --- what no catalogue has ------------------------------------------------------------------------


@pytest.mark.parametrize("design", ["rich", "soak"])
def test_a_bias_that_wanders_is_given_no_sure_name(design: str) -> None:
    """At 2 sd a name may be as wrong as it says: none is stated with nine in ten."""
    triad: Triad = "gyroscope" if design == "rich" else "accelerometer"
    for seed in (61, 62):
        found = said(design, triad, ("wander",), 2.0, seed)
        assert found.verdict != "effect" or found.inclusion[0].probability < 0.9, found.text


def test_a_bias_wanders_in_every_log_where_each_has_a_clock_of_its_own() -> None:
    """Without the times within the logs the same sessions are noise of no kind, or left open."""
    design = design_of("rich", 0)
    for seed in (65, 66):
        hidden = hidden_of(("wander",), "gyroscope", 5.0, design, seed)
        assert hidden is not None
        poses = poses_of(design, seed, "gyroscope", hidden)
        apart = replace(poses, time_s=np.full(len(poses), np.nan))
        found = diagnose(fit(apart, Model.of(BASE)))
        assert (found.verdict, found.name) == ("noise", "bias_wander"), found.text
        unknown = diagnose(fit(replace(apart, run_time_s=None), Model.of(BASE)))
        assert "bias_wander" not in {c.name for c in unknown.ranking}


def test_kinds_of_noise_are_one_verdict_that_says_what_else_it_may_be() -> None:
    """A bias that wanders by one sd, and sds stated too small by a quarter."""

    def found(seed: int) -> Diagnosis:
        design = design_of("rich", seed)
        hidden = hidden_of(("wander",), "gyroscope", 1.0, design, seed)
        assert hidden is not None
        poses = poses_of(design, seed, "gyroscope", hidden)
        return diagnose(fit(replace(poses, sd=poses.sd / 1.3), Model.of(BASE)))

    several = found(95)
    assert several.verdict == "noise"
    assert several.inclusion[0].name == "bias_wander"
    assert several.text.index("It is 'extra_noise'") < several.text.index(
        "'pose_scatter' and 'bias_wander' look the same")
    assert "It may be " not in several.text
    assert "more noise" not in several.text  # nothing else than the name says already
    course = found(98)
    assert "bias_wander" in course.group
    assert "bias wanders" in course.text or "'bias_wander'" in course.text


def test_a_memory_that_hysteresis_does_not_explain_is_another_function_of_the_pose_before() -> None:
    """The nearest width leaves eleven times the noise of twenty."""
    found = said("rich", "gyroscope", ("memory",), 20.0, 71)
    assert (found.verdict, found.name) == ("unknown", "previous")


def test_a_curve_in_temperature_is_laid_to_temperature() -> None:
    found = said("rich", "gyroscope", ("temperature_squared",), 20.0, 72)
    assert found.names == ("temperature_bias_curve",)


@pytest.mark.parametrize("disturbance", ["coarse", "correlated"])
def test_noise_of_another_kind_is_given_no_name(disturbance: str) -> None:
    for seed in (81, 82):
        design = disturbed(design_of("soak", seed), disturbance)
        found = diagnose(fit(poses_of(design, seed, "accelerometer", ()), Model.of(BASE)))
        assert found.verdict != "effect", found.text


@pytest.mark.parametrize(("bad", "gain"), [
    ((5, 70), 1.01), ((2, 4, 19), 1.03), ((59, 62, 68), 0.95)])
def test_bad_poses_are_named_together(bad: tuple[int, ...], gain: float) -> None:
    poses = noisy(rich_poses("gyroscope"), 4)
    reading = poses.reading.copy()
    for k in bad:
        reading[k] *= gain
    found = diagnose(fit(replace(poses, reading=reading), Model.of(BASE)))
    assert found.verdict == "bad_pose"
    assert set(found.group) == {poses.label[k] for k in bad}


# --- candidates -----------------------------------------------------------------------------------


def test_what_the_base_lacks_is_named() -> None:
    poses = noisy(rich_poses("accelerometer"), 3)
    model = Model.of(BASE)
    leaning = with_noise(read_through(poses, model, base_theta(model, "accelerometer")),
                         np.random.default_rng(1))
    found = diagnose(fit(leaning, Model.of(("bias", "scale"))))
    assert found.verdict == "effect"
    assert "misalignment" in found.names


def test_a_lever_arm_is_found_although_its_derivative_vanishes_at_zero() -> None:
    model = Model.of((*BASE, "lever_arm"))
    theta = base_theta(model, "accelerometer")
    theta[9:] = (0.06, 0.03, -0.02)
    poses = with_noise(read_through(rich_poses("accelerometer"), model, theta),
                       np.random.default_rng(2))
    found = diagnose(fit(poses, Model.of(BASE)))
    assert found.verdict == "effect"
    assert found.names == ("lever_arm",)
    (arm,) = (c for c in found.ranking if c.name == "lever_arm")
    assert (np.abs(np.abs(arm.size) - np.abs(theta[9:])) < 4 * arm.sd).all()
    assert arm.sd.max() < 0.01


def test_columns_that_follow_the_attitude_cause_nothing_unless_they_are_named() -> None:
    poses = noisy(rich_poses("gyroscope"), 5)
    columns = {**poses.columns, "mag_x": poses.force[:, 0], "Roll": poses.force[:, 1],
               "supply_v": poses.force[:, 2]}
    poses = replace(poses, columns=columns)
    assert set(causes(poses)) == {"temperature_c", "humidity_pct", "supply_v"}
    assert causes(poses, ("mag_x",)) == ("mag_x",)
    assert not is_cause("quat_w", None)
    found = diagnose(fit(poses, Model.of(BASE)))
    assert not {c.name for c in found.ranking} & {"column:mag_x", "mag_x", "column:Roll", "Roll"}
    found = diagnose(fit(poses, Model.of(BASE)), covariates=("mag_x",))
    assert "column:mag_x" in {c.name for c in found.ranking} | set(found.blind)
    assert "temperature_bias" not in {c.name for c in found.ranking} | set(found.blind)
    assert set(found.aside) == set(poses.columns) - {"mag_x"}


@pytest.mark.parametrize(("column", "cause"), [
    ("alternator_a", True), ("laterite_dust", True), ("velour_k", True), ("mag_temp_c", True),
    ("alt_v", True), ("statusled_w", True), ("magX", False), ("OriInc_q0", False),
    ("Mat[1][1]", False), ("q_w", False), ("GPSAlt", False), ("gps_alt_m", False),
    ("SampleTimeFine", False), ("status", False), ("Roll", False),
])
def test_a_column_is_judged_by_the_whole_words_of_its_name(column: str, cause: bool) -> None:
    assert is_cause(column, None) is cause
    assert is_cause(column, (column,))


# --- what is reported -----------------------------------------------------------------------------


def test_nothing_missing_comes_with_an_upper_limit_for_every_effect_looked_for() -> None:
    found = diagnose(fit(noisy(rich_poses("gyroscope"), 6), Model.of(BASE)))
    assert found.verdict == "nothing_missing"
    looked_for = {c.name for c in found.ranking if c.kind == "listed"}
    assert {limit.name for limit in found.limits} == looked_for
    assert all(0 < limit.value < np.inf for limit in found.limits)


def test_an_open_verdict_prints_its_odds() -> None:
    found = said("paper", "gyroscope", ("cross_quadratic",), 5.0, 10)
    assert found.verdict == "ambiguous"
    assert f"{odds_in_words(found.inclusion[0].probability)})" in found.text


def test_inclusion_holds_the_named_class_first_and_no_probability_beyond_one() -> None:
    found = said("rich", "gyroscope", ("quadratic", "bias_drift"), 5.0, 8)
    assert set(found.names) == {"quadratic", "bias_drift"}
    assert all(CONSTANTS.least_listed <= i.probability <= 1 + 1e-9 for i in found.inclusion)
    assert {i.name for i in found.inclusion[:2]} == set(found.names)
    assert sum(p for _, p in found.sets) <= 1 + 1e-9


def test_every_constant_says_where_it_comes_from() -> None:
    for name, origin in ((f.name, f.metadata["origin"]) for f in fields(CONSTANTS)):
        assert origin.split(":")[0] in ("fact", "derived", "tuned"), name


def test_two_temperatures_do_not_tell_a_straight_line_from_a_curve() -> None:
    """Three soaks at two temperatures; in a room that wanders by 0.2 °C a curve is another."""
    curve = "Another function of the logged column temperature_c looks the same"
    for name in ("temperature_bias", "temperature_squared"):
        found = said("soak", "accelerometer", (name,), 20.0, 76)
        assert (found.verdict, found.names) == ("effect", ("temperature_bias",))
        assert curve in found.text
    found = said("hand", "accelerometer", ("temperature_bias",), 10.0, 77)
    assert (found.verdict, found.names) == ("effect", ("temperature_bias",))
    assert curve not in found.text


@pytest.mark.parametrize(("name", "follows"), [
    ("gain ~ supply²", "supply_v"), ("bias ~ sin(2π t / 1500 s)", "time_s")])
def test_what_follows_a_column_as_no_effect_does_gets_no_name(name: str, follows: str) -> None:
    """Steps, curves and a warm-up were named beside each other, each with 99 %."""
    sound, true = outside_poses("rich", 51000)
    found = find(fit(hide({**SEEN, **UNSEEN}[name], sound, true, 10.0, 51000), Model.of(BASE)))
    assert (found.verdict.code, found.verdict.name) == ("unknown", follows)
    assert max((each.probability for each in found.posterior.inclusion
                if each.kind == "listed"), default=0.0) < CONSTANTS.sure
