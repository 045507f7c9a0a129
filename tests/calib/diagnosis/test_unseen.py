"""What these poses cannot see moves the parameters by as much as the budget says."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from calib.assess import AssessedTriad, assess
from calib.diagnosis.absorbed import absorbed
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.unseen import together, typical_size, unseen_budget
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.attitudes import spread_directions
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.leaning_poses import gyro_poses
from tests.calib.made_poses import (
    FAST,
    GRAVITY,
    MODEL,
    SLOW,
    SPECS,
    made_poses,
    noisy,
    rich_poses,
    walk,
    with_noise,
)
from tests.calib.plate_poses import on_the_plate
from tests.fitting import pose_sets, spec_of
from tests.world.bench import Design
from tests.world.designs import paper_design
from tests.world.hidden import Hidden
from tests.world.imu import mpu6050
from tests.world.physics import triad_of
from tests.world.session import simulate

pytestmark = pytest.mark.usefixtures("bare_page")

ONE_SPEED = noisy(made_poses("gyroscope", (SLOW,)), 4)
"""Gravity is parallel to the plate's axis: g-sensitivity is scale and misalignment."""


def test_an_effect_that_cannot_be_seen_moves_the_parameters_as_computed() -> None:
    rng = np.random.default_rng(5)
    truth = 1e-5 * rng.standard_normal((3, 3))
    base = fit(ONE_SPEED, MODEL)
    bent = replace(ONE_SPEED, reading=ONE_SPEED.reading + ONE_SPEED.force @ truth.T)
    shift = fit(bent, MODEL).theta - base.theta
    linear = absorbed(calibrate_triad(base, SPECS["gyroscope"]), EFFECTS["g_sensitivity"])
    assert linear @ truth.ravel() == pytest.approx(shift, abs=0.05 * np.abs(shift).max())


def test_what_the_poses_see_is_not_in_the_budget_and_what_they_do_not_is() -> None:
    one = calibrate_triad(fit(ONE_SPEED, MODEL), SPECS["gyroscope"])
    blind = diagnose(one.fit).blind
    budget = unseen_budget(one, blind, "MPU-6050")
    assert "g_sensitivity" in budget
    relative = budget["g_sensitivity"][2] / one.parameters.scale_counts_per_unit
    assert relative == pytest.approx(np.radians(0.1) / SLOW, rel=0.2)  # 0.1 °/s of 100 °/s
    assert (together(budget) >= budget["g_sensitivity"]).all()
    better = unseen_budget(one, blind, "MTi")["g_sensitivity"]
    assert better == pytest.approx(budget["g_sensitivity"] * 0.003 / 0.1)
    both = noisy(made_poses("gyroscope", (SLOW, FAST, -SLOW, 0.0)), 4)
    seen = calibrate_triad(fit(both, MODEL), SPECS["gyroscope"])
    assert "g_sensitivity" not in unseen_budget(seen, diagnose(seen.fit).blind, "MPU-6050")


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if e.belongs_to == "sensor"])
def test_every_effect_of_a_sensor_has_a_number_or_says_why_not(name: str) -> None:
    effect = EFFECTS[name]
    for part, size in effect.page.typical.items():
        numbers = [typical_size(effect, part, triad) for triad in TRIADS if triad in effect.triads]
        assert any(number is not None and number > 0 for number in numbers) or size.note


def assessed_at(part: str, poses: PoseSet = ONE_SPEED) -> AssessedTriad:
    return assess(poses, MODEL, SPECS["gyroscope"], part=part)


def test_what_the_next_log_errs_by_contains_what_the_poses_are_blind_to() -> None:
    low_cost, factory = assessed_at("MPU-6050"), assessed_at("MTi")
    assert low_cost.prediction is not None
    assert factory.prediction is not None
    # n·G (f - g n) over random directions of gravity: the square root of two for every element
    expected = np.sqrt(2) * np.radians(0.1)
    assert low_cost.prediction.by_unseen["g_sensitivity"] == pytest.approx(expected, rel=0.05)
    assert low_cost.prediction.sd_median == pytest.approx(expected, rel=0.05)
    assert low_cost.prediction.by_poses == factory.prediction.by_poses
    assert factory.prediction.by_unseen["g_sensitivity"] == pytest.approx(0.03 * expected, rel=0.05)


def test_nothing_missing_is_said_with_what_the_poses_are_blind_to() -> None:
    said = assessed_at("MPU-6050").diagnosis
    assert said.verdict == "nothing_missing"
    assert said.text.startswith("Nothing is missing among what these poses can see: ")
    assert "They are blind to g_sensitivity, typically 0.1 °/s per g." in said.text
    assert (said.explanation.standing, said.explanation.step) == ("open", "record")
    assert said.advice is not None


def test_a_gyroscope_logged_alone_is_as_blind() -> None:
    alone = replace(ONE_SPEED, force=np.full_like(ONE_SPEED.force, np.nan))
    logged, unlogged = assessed_at("MPU-6050").prediction, assessed_at("MPU-6050", alone).prediction
    assert logged is not None
    assert unlogged is not None
    assert unlogged.sd_median == pytest.approx(logged.sd_median, rel=1e-2)


def test_what_a_slight_tilt_hardly_shows_still_counts() -> None:
    poses, spec = gyro_poses(2.0, hide=False)
    slight = assess(poses, MODEL, spec)
    assert "g_sensitivity" not in slight.diagnosis.blind
    assert "nearly blind to g_sensitivity" in slight.diagnosis.text
    assert slight.prediction is not None
    assert np.degrees(slight.prediction.sd_median) > 0.05
    more = assess(gyro_poses(20.0, hide=False)[0], MODEL, spec)
    assert more.prediction is not None
    assert not more.prediction.unseen


@pytest.mark.parametrize("sensed", [
    lambda f: 14 * np.tanh(f / 14), lambda f: f - 2e-6 * f**5, lambda f: 20 * np.arctan(f / 20)],
    ids=["tanh", "fifth", "arctan"])
def test_a_cubic_that_18_poses_do_not_tell_from_what_it_stands_for_errs_as_stated(
    sensed: Callable[[FloatArray], FloatArray]
) -> None:
    poses = made_poses("accelerometer", (0.0,), seed=4, jitter_deg=1.0)
    poses = with_noise(replace(poses, reading=sensed(poses.reading), sd=poses.sd / 5),
                       np.random.default_rng(4))
    found = assess(poses, Model.of((*BASE, "cubic")), SPECS["accelerometer"])
    elsewhere = found.calibration.correct(
        Conditions.of_vectors(sensed(GRAVITY * spread_directions(300)), {}))
    off = np.sqrt(np.mean((np.linalg.norm(elsewhere, axis=1) - GRAVITY) ** 2))
    assert found.prediction is not None
    assert 0.5 < off / np.sqrt(np.mean(found.prediction.sd**2)) < 1.5
    assert "Another function of what an axis senses" in found.diagnosis.text


def test_a_misfit_of_something_else_makes_no_unseen_effect_larger_than_is_typical() -> None:
    poses, spec = gyro_poses(0.4, hide=False)
    slower = 1 - 0.01 * poses.time_s / np.ptp(poses.time_s)
    found = assess(replace(poses, reading=poses.reading * slower[:, None]), MODEL, spec)
    assert found.diagnosis.verdict == "effect"
    assert found.prediction is not None
    at_most = 1.5 * np.sqrt(2) * np.radians(0.1)
    assert found.prediction.by_unseen["g_sensitivity"] < at_most


def test_what_is_seen_but_not_settled_counts_by_how_likely_it_is() -> None:
    """The poses know it to half its size, and nothing is named: its error is ten times theirs."""
    poses, spec = gyro_poses(4.5, seed=3)
    unsettled = assess(poses, MODEL, spec)
    assert unsettled.diagnosis.verdict == "nothing_missing"
    assert unsettled.prediction is not None
    assert unsettled.prediction.sd_median > 8 * unsettled.prediction.by_poses
    sound = assess(gyro_poses(4.5, hide=False, seed=3)[0], MODEL, spec)
    assert sound.prediction is not None
    assert sound.prediction.sd_median < 3 * sound.prediction.by_poses


def test_the_tilted_run_is_priced_beside_the_others() -> None:
    poses, spec = gyro_poses(0.4, hide=False)
    said = assess(poses, MODEL, spec).diagnosis
    assert "Record next: the same poses with the plate stopped (10 min). As good: " in said.text
    assert "5 cm under one side of the record player, which makes 9° of tilt (11 min)" in (
        said.text)


def of_plate(rpm: tuple[float, ...]) -> tuple[AssessedTriad, float]:
    """An accelerometer 70 mm off the spindle, and by how much it errs in poses at rest, m/s²."""
    accelerometer = mpu6050().accelerometer
    found = assess(on_the_plate(1, rpm), MODEL, spec_of(accelerometer, accelerometer.full_scale))
    rest = on_the_plate(1, (0.0,))
    corrected = found.calibration.correct(rest.conditions(rest.reading))
    error = np.linalg.norm(corrected, axis=1) - rest.reference.magnitude
    return found, float(np.sqrt(np.mean(error**2)))


def test_a_lever_on_the_turning_plate_is_in_the_verdict_and_in_the_error_to_expect() -> None:
    found, error = of_plate((100 / 3,))
    assert found.prediction is not None
    assert error > 10 * found.prediction.by_poses  # the scale is off by that, with a small residual
    assert found.prediction.sd_median == pytest.approx(error, rel=0.5)
    assert (found.diagnosis.verdict, found.diagnosis.group) == ("ambiguous", ("lever_arm",))
    assert "every centimetre off the spindle adds up to 0.1" in found.diagnosis.text
    slow, error = of_plate((50 / 3,))
    assert slow.prediction is not None
    assert slow.prediction.sd_median == pytest.approx(error, rel=0.5)
    assert "lever_arm" in slow.diagnosis.text


def test_a_stopped_plate_and_a_lever_in_the_model_leave_no_lever_open() -> None:
    assert of_plate((0.0,))[0].diagnosis.explanation.standing == "good"
    accelerometer = mpu6050().accelerometer
    spec = spec_of(accelerometer, accelerometer.full_scale)
    fitted = assess(on_the_plate(1, (0.0, 100 / 3)), Model.of([*BASE, "lever_arm"]), spec)
    assert fitted.diagnosis.verdict == "nothing_missing"
    assert fitted.prediction is not None
    assert "lever_arm" not in fitted.prediction.by_unseen


@pytest.mark.parametrize(("column", "verdict"), [
    ("temperature_c", "effect"), ("humidity_pct", "effect"), ("humidity_squared", "unknown"),
    ("slow_course", "unknown")])
def test_a_missing_course_counts_in_what_the_next_log_errs_by(column: str, verdict: str) -> None:
    """Under the typical conditions of the session it is zero, and the next log has others."""
    poses = noisy(rich_poses("accelerometer"), 3)
    humidity = poses.columns["humidity_pct"]
    course = {"humidity_squared": (humidity - humidity.mean())**2,
              "slow_course": np.sin(poses.time_s / 250.0)}.get(column)
    course = poses.columns[column] if course is None else course
    unit = (course - course.mean()) / course.std()
    hidden = 20 * poses.sd[0, 0] * np.array([1.0, -0.8, 0.6])
    poses = replace(poses, reading=poses.reading + unit[:, None] * hidden)
    assessed = assess(poses, MODEL, SPECS["accelerometer"])
    assert (assessed.diagnosis.verdict, assessed.prediction is not None) == (verdict, True)
    on_a_length = np.linalg.norm(hidden) / np.sqrt(3)  # rms over the sphere
    assert 0.7 < assessed.prediction.sd_median / on_a_length < 1.6


@pytest.mark.parametrize("noise", ["bias_wander", "extra_noise", "pose_scatter"])
def test_noise_from_pose_to_pose_goes_on_in_the_next_log(noise: str) -> None:
    """Also where the model has it: no correction takes it away."""
    poses = noisy(rich_poses("accelerometer"), 3)
    hidden = 10 * poses.sd[0, 0]
    random = np.random.default_rng(1)
    drawn = (walk(poses.time_s, random) if noise == "bias_wander"
             else random.standard_normal(poses.reading.shape))
    poses = replace(poses, reading=poses.reading + hidden * drawn)
    for model in (MODEL, MODEL + find_effect(noise)):
        assessed = assess(poses, model, SPECS["accelerometer"])
        assert assessed.prediction is not None
        assert 0.5 < assessed.prediction.sd_median / hidden < 2


def test_a_bias_by_products_of_the_specific_force_follows_the_attitude() -> None:
    """No listed effect has them, and the poses on the stopped plate show nothing else of it."""
    poses = noisy(rich_poses("gyroscope"), 3)
    product = poses.force[:, [1, 2, 0]] * poses.force[:, [2, 0, 1]]
    hidden = 12 * poses.sd[0, 0] / product.std() * np.array([1.0, -0.7, 0.5])
    poses = replace(poses, reading=poses.reading + hidden * product)
    said = diagnose(fit(poses, MODEL))
    assert (said.verdict, said.explanation.step) == ("unknown", "discover")
    assert "the bias follows products of the specific force" in said.text


def simulated(seed: int, hidden: tuple[Hidden, ...] = ()) -> tuple[
        Design, Sequence[PoseSet], tuple[TriadSpec, TriadSpec]]:
    """The published design with an MPU-6050, its poses and its data sheets."""
    design = replace(paper_design(mpu6050()), sample_rate_hz=25.0, jitter_deg=3.0)
    *sets, specs = pose_sets(simulate(design, seed, hidden))
    return design, sets, specs


def test_scatter_that_leaves_all_open_is_stated_as_large_as_it_is() -> None:
    """18 poses do not tell scatter from effects, but any of these errs by as much."""
    design, (poses, _), (spec, _) = simulated(3)
    triad, gravity = triad_of(design, "accelerometer"), design.site.gravity_m_s2
    ratios = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        scatter = 0.036 * rng.standard_normal((318, 3))
        assessed = assess(replace(poses, reading=poses.reading + scatter[:18]), MODEL, spec)
        force = gravity * spread_directions(300)
        reading = spec.nominal(spec.signed(triad.project(force) * triad.gain + triad.offset))
        corrected = assessed.calibration.correct(Conditions.of_vectors(reading + scatter[18:]))
        error = np.linalg.norm(corrected, axis=1) - gravity
        assert assessed.prediction is not None
        ratios.append(assessed.prediction.sd_median / np.sqrt(np.mean(error**2)))
    assert min(ratios) > 0.6
    assert max(ratios) < 1.8


def test_a_warm_up_is_extrapolated_by_its_own_time_constant() -> None:
    """Ten minutes after it was switched on it is 0.45 °/s and falls to a third in four minutes."""
    size = np.radians([5.0, -4.0, 3.0])
    _, (_, poses), (_, spec) = simulated(
        5, (Hidden("warm_up", "gyroscope", size, {"tau_s": 250.0}),))
    assessed = assess(poses, MODEL, spec)
    assert assessed.diagnosis.names == ("warm_up",)
    assert assessed.prediction is not None
    assert 0.05 < np.degrees(assessed.prediction.sd_median) < 0.4
