"""What keeps a verdict from a wrong name: left-out poses, errors of formulas, starts of shapes."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses.courses import by_clock
from calib.diagnosis.hypotheses.listed import listed_hypotheses
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import Effect
from calib.effects.user_defined import shape_between, user_effect
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from calib.fit.validation.leave_one_out import Comparison
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import base_theta, noisy, read_through, rich_poses, with_noise
from tests.fitting import pose_sets, tilted_pose_sets
from tests.lots import pose_sets_of
from tests.world.bench import Design, wedge_directions
from tests.world.designs import FAST, SLOW, paper_design, still_run, tilted_design, turning_run
from tests.world.imu import Sensor, mpu6050
from tests.world.lot import LotPlan, draw_lot
from tests.world.plate import PlateMotion
from tests.world.session import Session, simulate


def test_what_predicts_left_out_poses_worse_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sure cubic, and the same where its refit would not lower the leave-one-out error."""
    true = rich_poses("gyroscope", 8)
    read = true.reading - 1e-3 * true.reading**3 * [1.0, 0.7, -0.4]
    base = fit(noisy(replace(true, reading=read), 8), Model.of(BASE))
    assert find(base).verdict.names == ("cubic",)
    monkeypatch.setattr(Comparison, "predicts_better_than", lambda *_: False)
    found = find(base)
    assert found.posterior.any_of(["cubic"]) > 0.99
    assert (found.verdict.code, found.verdict.names) == ("ambiguous", ())


def test_a_wander_in_the_place_of_a_drift_does_not_count_for_its_name() -> None:
    """A drift of one sd: that something changes with time is sure, that it is no wander is not."""
    poses = noisy(rich_poses("accelerometer", 12), 12)
    time = (poses.time_s - poses.time_s.mean()) / poses.time_s.std()
    read = poses.reading + poses.sd[0, 0] * time[:, None] * [0.6, 1.0, -0.8]
    found = find(fit(replace(poses, reading=read), Model.of(BASE)))
    (course,) = found.posterior.classes
    assert "bias_wander" in course.members
    assert course.probability > CONSTANTS.sure
    assert (found.verdict.code, found.verdict.names) == ("ambiguous", ())


def test_what_leaves_a_misfit_has_a_name_by_twenty_to_one_only() -> None:
    """Small pushes that a magnet lets go: a curve in the temperature is likely too, and no refit
    has it; by nine to one the memory is no other function of the pose before."""
    plan = LotPlan(25, hidden="hysteresis", own_sd=(15.0, 40.0))
    poses = pose_sets_of(draw_lot(paper_design(mpu6050()), plan, 421))[14]
    found = find(fit(poses, Model.of(BASE)))
    sure = {each.name for each in found.posterior.classes if each.probability > CONSTANTS.sure}
    assert {"hysteresis"} < sure
    assert found.verdict.code == "ambiguous"
    assert "hysteresis" in found.verdict.group


def test_a_shape_that_no_effect_has_is_no_noise_beside_an_effect_that_is_slight() -> None:
    """60 sds of products of the specific force, 3 sds of the temperature: a name of the latter does
    not stand out of what the former leaves, and the former is a shape all the same."""
    poses = noisy(rich_poses("gyroscope", 3), 3)
    product = poses.force[:, [1, 2, 0]] * poses.force[:, [2, 0, 1]]
    warmth = poses.columns["temperature_c"] - poses.columns["temperature_c"].mean()
    strong = 60 / product.std() * product * [1.0, -0.7, 0.5]
    slight = 3 / warmth.std() * warmth[:, None] * [0.6, 1.0, -0.8]
    read = poses.reading + poses.sd[0, 0] * (strong + slight)
    verdict = find(fit(replace(poses, reading=read), Model.of(BASE))).verdict
    assert (verdict.code, verdict.name) == ("unknown", "attitude")
    assert "temperature_bias" in {name for each in verdict.beside for name in each.members}


@pytest.mark.parametrize(("error", "code", "name"), [
    (lambda s: np.where(np.abs(s) > 2.6, -0.03 * np.sign(s) * (np.abs(s) - 2.6), 0.0),
     "unknown", "attitude"),
    (lambda s: np.where(np.abs(s) < 0.004, -s, -0.004 * np.sign(s)), "unknown", "attitude"),
    (lambda s: -1e-3 * s**3 * [1.0, 0.7, -0.4], "effect", "cubic"),
])
def test_the_first_term_of_another_shape_is_no_name(
    error: Callable[[FloatArray], FloatArray], code: str, name: str
) -> None:
    """A saturation was a cubic, a dead band an offset of the reference, with the rest beside it."""
    true = rich_poses("gyroscope", 8)
    poses = noisy(replace(true, reading=true.reading + error(true.reading)), 8)
    verdict = find(fit(poses, Model.of(BASE))).verdict
    assert (verdict.code, verdict.name) == (code, name)


def with_dead_band(deg_s: float) -> Sensor:
    """A low-cost unit whose gyroscope does not answer to so much."""
    sensor = mpu6050()
    return replace(sensor, gyroscope=replace(sensor.gyroscope, dead_band=np.radians(deg_s)))


def hand_laid(sensor: Sensor, speeds: Sequence[float]) -> Design:
    """18 poses at rest and at each speed."""
    wedge = wedge_directions()
    runs = [turning_run(f"run {i}", PlateMotion(rate), wedge) for i, rate in enumerate(speeds)]
    return replace(paper_design(sensor), runs=(still_run(wedge), *runs), jitter_deg=3.0)


@pytest.mark.parametrize(("speeds", "band_deg_s", "seed"), [
    ((SLOW,), 0.3, 701), ((SLOW, FAST), 3.0, 703)], ids=["one speed", "two speeds"])
def test_a_dead_band_is_no_cubic_and_no_rate_that_scatters(
    speeds: Sequence[float], band_deg_s: float, seed: int
) -> None:
    """In hand-laid poses, sample by sample."""
    _, poses, _ = pose_sets(simulate(hand_laid(with_dead_band(band_deg_s), speeds), seed))
    verdict = find(fit(poses, Model.of(BASE))).verdict
    assert (verdict.code, verdict.name) == ("unknown", "attitude")
    assert "of its largest and no further, as with a dead band or a limit" in verdict.details[0]


@pytest.mark.parametrize(("design", "poses_of", "seed"), [
    (hand_laid(with_dead_band(3.0), [SLOW]), pose_sets, 703),
    (tilted_design(10.0, with_dead_band(1.0)), tilted_pose_sets, 710),
], ids=["a curve that takes every row", "another function of the attitude"])
def test_what_an_unknown_cause_leaves_is_no_effect_beside_it(
    design: Design, seed: int,
    poses_of: Callable[[Session], tuple[PoseSet, PoseSet, tuple[TriadSpec, TriadSpec]]],
) -> None:
    """One was to be there beside a dead band with 87 and with 92 in 100."""
    poses = poses_of(simulate(design, seed))[1]
    verdict = find(fit(poses, Model.of(BASE))).verdict
    assert (verdict.code, verdict.name) == ("unknown", "attitude")
    assert [each.name for each in verdict.beside if each.kind == "listed"] == []


@pytest.mark.parametrize(("bend_sds", "code"), [(0.6, "effect"), (0.63, "unknown")])
def test_a_line_in_a_column_and_any_function_of_it_are_one_class(
    bend_sds: float, code: str
) -> None:
    """6 sds along a line and a slight bend, so that neither is sure; that one of them is, is sure.
    """
    poses = noisy(rich_poses("accelerometer", 4), 4)
    humidity = poses.columns["humidity_pct"]
    line = (humidity - humidity.mean()) / humidity.std()
    bend = (line**2 - 1) / np.std(line**2)
    error = 6 * line[:, None] * [0.6, 1.0, -0.8] + bend_sds * bend[:, None] * [1.0, -0.8, 0.5]
    said = diagnose(fit(replace(poses, reading=poses.reading + poses.sd[0, 0] * error),
                        Model.of(BASE)))
    assert said.verdict == code, said.text
    assert {*said.group} == {"column:humidity_pct", "~humidity_pct"}
    assert said.inclusion[0].probability > 0.95
    assert said.explanation.step == ("record" if code == "effect" else "discover")
    assert "something that follows" in said.text or "as 'column:humidity_pct' does" in said.text


@pytest.mark.parametrize("name", ["quadratic", "asymmetry"])
def test_a_formula_that_is_slightly_off_gets_no_second_name(name: str) -> None:
    """300 sds of an effect on the orthogonal axes, which the catalogue has on the sensitive ones.
    """
    bent = replace(find_effect(name), orthogonal=True)
    base = with_own(bent, rich_poses("gyroscope", 1), 300.0)
    assert find(base).verdict.names == (name,)


@pytest.mark.parametrize("knee_v", [3.1, 3.9, 4.5])
def test_a_shape_of_one_s_own_is_searched_over_its_range(knee_v: float) -> None:
    """A supply that sags below a knee: a straight line, a step or a settling are near it."""
    poses = rich_poses("accelerometer", 1)
    share = (poses.time_s - poses.time_s.min()) / np.ptp(poses.time_s)
    supply_v = 5.0 - 2.0 * share - 0.1 * np.sin(9 * share)
    poses = replace(poses, columns={**poses.columns, "supply_v": supply_v})
    effect = user_effect("brown_out", below_knee, "axis", "{u}", "accelerometer",
                         shape_between("knee", "V", 3.0, 30.0))
    found = find(with_own(effect, poses, 15.0, knee_v), [effect])
    assert found.verdict.names == ("brown_out",)


def below_knee(at: Conditions, knee_v: float) -> FloatArray:
    """How far the supply is below its knee, V, (n, 3)."""
    sag = np.maximum(0.0, knee_v - at.columns["supply_v"])
    return np.repeat(sag[:, None], 3, axis=1)


def with_own(effect: Effect, poses: PoseSet, size: float, shape: float | None = None) -> Fit:
    """A fit of the base to poses with ``effect`` of so many sds, root mean square."""
    model = Model.of(BASE) + effect
    theta = base_theta(model, poses.triad)
    along = np.array([1.0, -0.6, 0.3])
    error = effect.evaluate(poses.conditions(poses.reading), shape) @ along
    theta[9:] = size * np.median(poses.sd) / np.sqrt(np.mean(error**2)) * along
    shapes = None if shape is None else {effect.name: shape}
    read = with_noise(read_through(poses, model, theta, shapes), np.random.default_rng(1))
    return fit(read, Model.of(BASE))


def test_what_happened_once_is_a_function_of_nothing() -> None:
    """No unknown function of the attitude stands for a step, and no sentence says so."""
    model = fit(noisy(rich_poses("gyroscope", 3), 3), Model.of(BASE))
    placed = [each for each in (*listed_hypotheses(model)[0], *by_clock(model)) if each.is_placed]
    assert "bias_step" in {each.name for each in placed}
    assert {each.covariate for each in placed} == {""}
