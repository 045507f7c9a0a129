"""What a verdict says of an error without a name: whether the bias errs, the gain, or an axis."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.diagnosis.verdict.decision import Code, Verdict
from calib.diagnosis.verdict.explain import explain
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import noisy, rich_poses

UNLIKE = np.array([1.0, -0.8, 0.5])  #: what the axes have of an error


def diagnosed(poses: PoseSet, error: FloatArray) -> Diagnosis:
    """The verdict where readings err by ``error`` (n, 3) in sds."""
    read = poses.reading + poses.sd[0, 0] * error
    return diagnose(fit(replace(poses, reading=read), Model.of(BASE)))


def in_time(poses: PoseSet) -> FloatArray:
    """A course that comes and goes, (n, 1)."""
    return np.sin(5 * (poses.time_s - poses.time_s.min())[:, None] / np.ptp(poses.time_s))


def late(poses: PoseSet) -> FloatArray:
    """One in the second half of the session, (n, 1)."""
    return 1.0 * (poses.time_s > np.median(poses.time_s))[:, None]


def of_axes(poses: PoseSet) -> FloatArray:
    """What the axes sense, over the largest, (n, 3)."""
    return np.asarray(poses.reading / np.abs(poses.reading).max())


@pytest.mark.parametrize(("error", "said"), [
    (lambda p: 15 * in_time(p) * UNLIKE, "the bias changes with time"),
    (lambda p: 40 * in_time(p) * UNLIKE * of_axes(p), "the gain changes with time"),
    (lambda p: 40 * late(p) * UNLIKE * of_axes(p), "the gain changes with time"),
], ids=["bias", "gain", "gain that steps"])
def test_what_changes_with_time_is_the_bias_or_the_gain(
    error: Callable[[PoseSet], FloatArray], said: str
) -> None:
    poses = noisy(rich_poses("accelerometer", 4), 4)
    verdict = diagnosed(poses, error(poses))
    assert verdict.verdict == "unknown"
    assert said in verdict.text
    assert said in verdict.explanation.short
    other = "gain" if "bias" in said else "bias"
    assert f"the {other} changes" not in verdict.text
    assert {each.errs for each in verdict.inclusion if each.follows == "time_s"} == {
        "gain" if "gain" in said else "bias"}


def test_what_is_beside_a_course_is_not_what_the_course_may_be() -> None:
    """A pose that was knocked, beside a gain that changes, was told as what that change is."""
    poses = noisy(rich_poses("accelerometer", 4), 4)
    error = 40 * in_time(poses) * UNLIKE * of_axes(poses)
    error[9] += 60
    text = diagnosed(poses, error).text
    assert "the gain changes with time, neither linearly nor exponentially (chi²/dof" in text
    assert f"Perhaps there is also a bad pose, {poses.label[9]}" in text


@pytest.mark.parametrize(("verdict", "words"), [
    (Verdict(Code.UNKNOWN, "time_s", details=("31.0 s",), errs="bias"), "step, at 31.0 s"),
    (Verdict(Code.UNKNOWN, "time_s", details=("31.0 s",), errs="gain"), "neither linearly"),
    (Verdict(Code.UNKNOWN, "humidity_pct", details=("in a curve",), errs="gain"),
     "the gain follows the logged column humidity_pct in a curve"),
    (Verdict(Code.UNKNOWN, "humidity_pct", details=("in a curve",)),
     "the residual follows the logged column humidity_pct ("),
])
def test_a_form_and_a_step_are_told_of_what_has_them(verdict: Verdict, words: str) -> None:
    """A step is one of the bias, and a form is told where the rows tell what has it."""
    base = fit(noisy(rich_poses("accelerometer", 4), 4), Model.of(BASE))
    text = explain(base, verdict, [], 1e-9, None).text
    assert words in text
    assert ("step" in text) is ("step" in words)


@pytest.mark.parametrize(("error", "said"), [
    (lambda p: -300 * np.sign(p.reading) * np.clip(np.abs(p.reading) - 2.6, 0, None),
     "the error of each axis follows what it senses"),
    (lambda p: 0.5 * UNLIKE * p.force[:, [1, 2, 0]] * p.force[:, [2, 0, 1]],
     "the bias follows products of the specific force"),
], ids=["saturation", "products of forces"])
def test_what_follows_the_attitude_is_told(
    error: Callable[[PoseSet], FloatArray], said: str
) -> None:
    poses = noisy(rich_poses("gyroscope", 4), 4)
    verdict = diagnosed(poses, error(poses))
    assert (verdict.verdict, verdict.name) == ("unknown", "attitude")
    assert said in verdict.text


def before(poses: PoseSet) -> FloatArray:
    """What the axes sensed in the pose before, over the largest, (n, 3)."""
    order = np.argsort(poses.time_s)
    sensed = np.zeros_like(poses.reading)
    sensed[order[1:]] = of_axes(poses)[order[:-1]]
    return sensed


def warmth(poses: PoseSet) -> FloatArray:
    """The logged temperature about its mean, over half of its range, (n, 1)."""
    values = poses.columns["temperature_c"][:, None]
    return np.asarray(2 * (values - values.mean()) / np.ptp(values))


@pytest.mark.parametrize(("error", "name"), [
    (lambda p: 200 * warmth(p) * UNLIKE * of_axes(p) ** 3, "temperature_c"),
    (lambda p: 60 * warmth(p) * UNLIKE * np.roll(of_axes(p), 1, axis=1), "temperature_c"),
    (lambda p: 60 * UNLIKE * np.tanh(4 * np.roll(of_axes(p), 1, axis=1)), "attitude"),
    (lambda p: 30 * UNLIKE * np.tanh(3 * (of_axes(p) - before(p))), "previous"),
], ids=["cubic by warmth", "cross gain by warmth", "cross axis", "backlash"])
def test_an_error_of_two_things_is_an_unknown_function(
    error: Callable[[PoseSet], FloatArray], name: str
) -> None:
    """They were told as noise without any shape, or as the listed effect that is part of them."""
    poses = noisy(rich_poses("gyroscope", 7), 7)
    verdict = diagnosed(poses, error(poses))
    assert (verdict.verdict, verdict.name) == ("unknown", name)


def test_a_function_of_the_reading_is_no_name_beside_one_of_the_reading_and_time() -> None:
    """Another gain for positive readings that grows with time: it was named, as if it stood."""
    poses = noisy(rich_poses("gyroscope", 7), 7)
    time = (poses.time_s - poses.time_s.min()) / np.ptp(poses.time_s)
    verdict = diagnosed(poses, 100 * time[:, None] ** 2 * UNLIKE * np.abs(of_axes(poses)))
    assert (verdict.verdict, verdict.name) == ("unknown", "time_s")


def test_a_warm_up_is_no_name_beside_another_function_of_time() -> None:
    """A swing that fades: its first term was named, and a function of time beside it."""
    poses = noisy(rich_poses("gyroscope", 7), 7)
    time = (poses.time_s - poses.time_s.min()) / np.ptp(poses.time_s)
    verdict = diagnosed(poses, 60 * (np.exp(-3 * time) * np.sin(9 * time))[:, None] * UNLIKE)
    assert (verdict.verdict, verdict.name) == ("unknown", "time_s")


def test_a_drift_of_the_gain_is_no_name_beside_another_function_of_time() -> None:
    """A nonlinearity that grows with time: its first term was named, and a function beside it."""
    poses = noisy(rich_poses("gyroscope", 6), 6)
    time = (poses.time_s - poses.time_s.mean()) / poses.time_s.std()
    verdict = diagnosed(poses, 400 * time[:, None] * UNLIKE * of_axes(poses) ** 3)
    assert (verdict.verdict, verdict.name) == ("unknown", "time_s")
