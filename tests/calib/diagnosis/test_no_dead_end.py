"""What a verdict ends in: an effect to add, a measurement with its minutes, or the search for one.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pytest

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses.courses import FROM_RUN_TO_RUN
from calib.diagnosis.next_measurement.advice import Advice
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.verdict.decision import Code, Verdict
from calib.diagnosis.verdict.explain import SPOKEN, explain
from calib.diagnosis.verdict.explanation import Step
from calib.diagnosis.verdict.ranking import rank
from calib.discovery.discover import discover
from calib.effects.catalogue import BASE, find_effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.validation.leave_one_out import compare
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import made_poses, noisy, rich_poses, walk
from tests.trials import poses_of
from tests.world.designs import soak_design
from tests.world.sizes import draw_effect

pytestmark = pytest.mark.usefixtures("bare_page")


def sound(seed: int) -> PoseSet:
    return noisy(rich_poses("gyroscope", seed), seed)


def stepped(seed: int, sds: float) -> PoseSet:
    poses = sound(seed)
    after = poses.time_s >= np.sort(poses.time_s)[50]
    return replace(poses, reading=poses.reading + sds * np.outer(after, poses.sd[0] * [1, -1, 0.5]))


def scattered(seed: int, sds: float) -> PoseSet:
    poses, random = sound(seed), np.random.default_rng([seed, 3])
    return replace(poses, reading=poses.reading + sds * poses.sd * random.normal(
        size=poses.sd.shape))


def wandering(seed: int, sds: float) -> PoseSet:
    poses, random = sound(seed), np.random.default_rng([seed, 4])
    return replace(poses, reading=poses.reading + sds * poses.sd * walk(poses.time_s, random))


def spoilt(seed: int, sds: float) -> PoseSet:
    poses = sound(seed)
    reading = poses.reading.copy()
    reading[7] += sds * poses.sd[7] * np.sign(reading[7])
    return replace(poses, reading=reading)


def fitted(poses: PoseSet) -> tuple[Fit, Diagnosis]:
    base = fit(poses, Model.of(BASE))
    return base, diagnose(base)


@cache
def fitted_to(
    make: Callable[[int, float], PoseSet], seed: int, sds: float
) -> tuple[Fit, Diagnosis]:
    return fitted(make(seed, sds))


def test_there_is_no_step_that_only_repeats() -> None:
    assert {*get_args(Step)} == {"apply", "add", "record", "discover"}


@pytest.mark.parametrize(("make", "code", "name", "step"), [
    (stepped, "effect", "bias_step", "add"),
    (scattered, "noise", "extra_noise", "add"),
    (wandering, "noise", "bias_wander", "add"),
])
def test_what_has_no_formula_has_a_name_that_can_be_added(
    make: Callable[[int, float], PoseSet], code: str, name: str, step: str
) -> None:
    right, settled = 0, 0
    for seed in (2, 3):
        base, said = fitted_to(make, seed, 3.0)
        right += (said.verdict, said.name) == (code, name)
        if said.name != name:
            continue
        assert said.explanation.step == step, said.text
        assert said.addable == (name,)
        after = fit(base.poses, Model.of((*BASE, name)))
        assert after.p_value > 1e-3
        if name != "extra_noise":  # it predicts no pose
            assert compare(after).loo_rms < 0.9 * compare(base).loo_rms
        then = diagnose(after)
        if name == "extra_noise":  # no explanation
            assert (then.explanation.standing, then.explanation.step, then.addable) == (
                "open", "apply", ())
            assert re.search(r"noise is [\d.]+ times .*nothing explains it", then.text)
        settled += then.verdict == ("noise" if name == "extra_noise" else "nothing_missing")
    assert right == 2
    assert settled == 2


def test_a_formula_is_sought_before_a_residual_far_above_the_noise_is_called_noise() -> None:
    """A converter that errs by a wave of many periods over its range has no smooth shape."""
    poses = sound(3)
    wave = np.sin(2 * np.pi * poses.reading / np.abs(poses.reading).max() * 2.7 + 0.4)
    for sds, step in ((4.0, "record"), (30.0, "discover")):
        base, said = fitted(replace(poses, reading=poses.reading + sds * poses.sd * wave))
        assert (said.verdict, said.explanation.step) == ("noise", step), said.text
    assert said.addable == ()
    formula = discover(base)
    assert formula is not None
    assert "a wave in its reading" in formula.formula.words
    assert formula.left_out_after < 0.2 * formula.left_out_before


def test_a_bias_that_steps_and_comes_back_is_two_steps_and_no_wander() -> None:
    """Either step alone explains little; the pair is weighed all the same."""
    poses = stepped(2, 20.0)
    back = poses.time_s >= np.sort(poses.time_s)[72]
    read = poses.reading - 20 * np.outer(back, poses.sd[0] * [1, -1, 0.5])
    verdict = find(fit(replace(poses, reading=read), Model.of(BASE))).verdict
    assert (verdict.code, verdict.name, len(verdict.details)) == ("effect", "bias_step", 2)


def test_what_follows_the_rate_may_be_a_stated_rate_that_is_off() -> None:
    base = fit(sound(1), Model.of(BASE))
    for name, said in (("spin_rad_s", True), ("supply_v", False)):
        text = explain(base, Verdict(Code.UNKNOWN, name), [], 1e-9, None).text
        assert ("Look for a stated rate that is off" in text) is said


def test_a_second_step_has_the_name_of_the_second_where_the_first_was_just_added() -> None:
    """Hypotheses that know no more than when poses were taken are kept, by what the model has."""
    poses = stepped(2, 20.0)
    for names, next_one in (((), "bias_step"), (("bias_step",), "bias_step_2")):
        known = find(fit(poses, Model.of((*BASE, *names)))).posterior.first
        assert {name for name in known if name.startswith("bias_step")} == {next_one}


def test_noise_of_one_run_is_named_with_it_and_its_size_is_fitted() -> None:
    sizes = []
    for seed in range(3):
        poses, random = sound(seed), np.random.default_rng([seed, 9])
        there = np.array([run == "run 4" for run in poses.run])[:, None]
        noise = 2 * poses.sd * random.normal(size=poses.sd.shape) * there
        base, said = fitted(replace(poses, reading=poses.reading + noise))
        assert said.name == "extra_noise:run 4", said.text
        assert "in the run 'run 4' alone" in said.text
        after = fit(base.poses, Model.of((*BASE, "extra_noise:run 4")))
        assert after.p_value > 1e-3
        sizes.append(float(after.theta[after.model.slices()["extra_noise:run 4"]][0]))
        then = diagnose(after)
        assert (then.verdict, then.name) == ("noise", "extra_noise:run 4")
    assert 1.5 < np.mean(sizes) < 2.5
    with pytest.raises(CalibrationError, match="which are of 'run 0', 'run 1'"):
        fit(base.poses, Model.of((*BASE, "extra_noise:fast")))


def test_noise_of_few_poses_is_told_from_a_wander_by_the_order_of_time() -> None:
    """26 hand-laid poses: one of any correlation time is noise as well, the slow ones are not."""
    said: dict[str, list[str | None]] = {"noise": [], "wander": []}
    for seed in range(6):
        random = np.random.default_rng([seed, 8])
        poses = noisy(made_poses("accelerometer", (0.0,), corners=True, seed=seed), seed)
        for kind, course in (("noise", random.normal(size=poses.sd.shape)),
                             ("wander", walk(poses.time_s, random))):
            spoilt_ones = replace(poses, reading=poses.reading + 5 * poses.sd * course)
            said[kind].append(diagnose(fit(spoilt_ones, Model.of(BASE))).name)
    assert said["noise"].count("extra_noise") >= 4
    assert said["noise"].count("bias_wander") <= 1
    assert said["wander"].count("extra_noise") <= 1


def test_a_step_is_named_with_its_time_and_a_second_one_beside_it() -> None:
    poses = stepped(1, 8.0)
    time = np.sort(poses.time_s)
    back = poses.time_s >= time[95]
    twice = replace(poses, reading=poses.reading - 8 * np.outer(back, poses.sd[0] * [1, -1, 0.5]))
    base, said = fitted(twice)
    assert said.name == "bias_step"
    assert "The bias steps at" in said.text
    both = fit(base.poses, Model.of((*BASE, "bias_step", "bias_step_2")))
    assert both.p_value > 1e-3
    for at_s, k in zip(sorted(both.shapes.values()), (50, 95), strict=True):
        assert time[k - 2] < at_s < time[k + 1]
    assert find_effect("bias_step_2").physics == find_effect("bias_step").physics


@pytest.mark.parametrize("seed", [302, 309])
def test_a_step_in_a_pause_of_a_long_session_is_named_with_its_time(seed: int) -> None:
    """78 poses are more than the times that are tried evenly; in both it steps after pose 26."""
    design = soak_design().scaled(sample_rate=0.25)
    hidden = draw_effect("jump", "accelerometer", 5.0, design, seed)
    poses = poses_of(design, seed, "accelerometer", [hidden])
    time_s, at_s = np.sort(poses.time_s), float(hidden.detail["time_s"])
    assert (time_s < at_s).sum() == 26
    said = diagnose(fit(poses, Model.of(BASE)))
    assert said.names == ("bias_step",)
    assert f"at {0.5 * (time_s[25] + time_s[26]):.1f} s" in said.text


MINUTES = re.compile(r"\(\d+ min\b")
CHANCE = re.compile(r"\(\d+ min, after which \d+ % of simulated sessions name it\)")
NOTHING_MORE = "Nothing more can be known of it from this sensor on this bench"
ADVICE = Advice("speed", "the same poses at another speed", 10.0, chance=0.9)
SEVERAL = Inclusion("quadratic", ("quadratic", "asymmetry"), 0.6, "listed")
ENDS: Mapping[Code, Sequence[tuple[Verdict, Step, Step]]] = {
    Code.NOTHING_MISSING: [(Verdict(Code.NOTHING_MISSING, explains=True), "apply", "apply")],
    Code.EFFECT: [
        (Verdict(Code.EFFECT, "cubic", ("cubic",), ("cubic",), share=1.0), "add", "add"),
        (Verdict(Code.EFFECT, "cubic", ("cubic",), ("cubic", "quadratic"), share=1.0),
         "add", "record"),
    ],
    Code.AMBIGUOUS: [(Verdict(Code.AMBIGUOUS, group=SEVERAL.members, beside=(SEVERAL,)),
                      "apply", "record")],
    Code.UNKNOWN: [(Verdict(Code.UNKNOWN, name), "discover", "discover")
                   for name in ("time_s", "attitude")],
    Code.BAD_POSE: [(Verdict(Code.BAD_POSE, "pose 3", details=("pose 3", "pose 9")),
                     "record", "record")],
    Code.NOISE: [
        (Verdict(Code.NOISE, "extra_noise", group=("extra_noise",)), "add", "add"),
        (Verdict(Code.NOISE, "bias_wander", group=("bias_wander", "bias_drift"),
                 details=("correlated over about 300 s",)), "add", "add"),
        (Verdict(Code.NOISE, "rate_scatter", details=(FROM_RUN_TO_RUN,)), "record", "record"),
        (Verdict(Code.NOISE), "apply", "apply"),
    ],
}
"""Every verdict that a fit can have, in its forms, and its step without a block to record and with.
"""


def test_every_verdict_ends_in_a_step_and_what_is_recorded_in_minutes() -> None:
    assert {*ENDS} == {*SPOKEN} == {*Code} - {Code.REFUSED}  # that one is an error with its words
    base = fit(sound(1), Model.of(BASE))
    ranking = rank(find(base).posterior)
    for code, forms in ENDS.items():
        for verdict, without, with_a_block in forms:
            for advice, step in ((None, without), (ADVICE, with_a_block)):
                if code is Code.NOTHING_MISSING and advice is not None:
                    continue
                said = explain(base, verdict, ranking, 1e-9, advice)
                assert said.step == step, code
                assert said.following
                assert step != "record" or MINUTES.search(said.following), said.following
                open_still = code is Code.AMBIGUOUS or len(verdict.group) > 1 or (
                    code is Code.NOISE and verdict.name is None)
                if open_still and verdict.name != "bias_wander":
                    leads = CHANCE if step == "record" else re.compile(NOTHING_MORE)
                    assert leads.search(said.text), said.text


@pytest.mark.parametrize(("share", "rest"), [(0.9, "10 %"), (0.9999, "Less than 1 %")])
def test_a_rest_that_is_more_than_noise_is_no_zero(share: float, rest: str) -> None:
    base = fit(sound(1), Model.of(BASE))
    verdict = Verdict(Code.EFFECT, "cubic", ("cubic",), ("cubic",), share=share)
    said = explain(base, verdict, rank(find(base).posterior), 1e-9, None)
    assert f"{rest} of the misfit remain, more than noise" in said.text


def two_courses(seed: int, sds: float) -> PoseSet:
    """A step and a wander of like size."""
    step, wander = stepped(seed, sds), wandering(seed, sds)
    return replace(step, reading=step.reading + wander.reading - sound(seed).reading)


@pytest.mark.parametrize("make", [stepped, scattered, wandering, spoilt, two_courses])
def test_no_verdict_on_a_session_ends_in_poses_without_a_chance(
    make: Callable[[int, float], PoseSet]
) -> None:
    """Weak and strong: what is open is to be recorded with its chance, or can no more be known."""
    for seed, sds in ((0, 0.5), (1, 1.0), (2, 2.0), (3, 3.0)):
        _, said = fitted_to(make, seed, sds)
        step, text = said.explanation.step, said.text
        if said.verdict == "ambiguous" or (said.verdict == "effect" and len(said.group) > 1):
            assert CHANCE.search(text) if step == "record" else NOTHING_MORE in text, text
        elif said.verdict == "nothing_missing":
            assert step in ("apply", "record")
        else:
            assert step in ("add", "discover") or said.verdict == "bad_pose" or (
                said.name == "rate_scatter") or NOTHING_MORE in text, text


def test_what_is_to_be_recorded_says_how_long_it_takes() -> None:
    _, said = fitted(spoilt(2, 40.0))
    assert said.verdict == "bad_pose"
    assert said.explanation.step == "record"
    assert "(1 min)" in said.explanation.following
