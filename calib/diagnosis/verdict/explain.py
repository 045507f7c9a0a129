"""The diagnosis as a person would say it: every verdict with its text, standing and next step."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.diagnosis.hypotheses.courses import FROM_RUN_TO_RUN
from calib.diagnosis.hypotheses.listed import BIAS
from calib.diagnosis.next_measurement.advice import Advice
from calib.diagnosis.next_measurement.pose_blocks import CLIPS
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.search.refit import linear_loo_rms
from calib.diagnosis.verdict.case import Case
from calib.diagnosis.verdict.decision import Code, Verdict
from calib.diagnosis.verdict.explanation import Explanation, Step
from calib.diagnosis.verdict.kinds_of_noise import SHAPELESS
from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import (
    AT_REST,
    CORRECT,
    NOTHING_MISSING,
    NOTHING_MORE,
    OTHER_FILES,
    at_times,
    beyond_parts,
    covariate,
    curves,
    enumeration,
    kind_of_noise,
    minutes_of,
    missing,
    noise_in_the_model,
    odds_in_words,
    physics,
    rates_by_the_readings,
    readable,
    remedy_of_noise,
    step_of_noise,
    unsupported,
    what_separates,
)
from calib.effects.units import display_unit
from calib.fit.least_squares.result import Fit
from calib.fit.validation.prediction import Prediction
from calib.rounding import two_digits, with_sd

LEAST_FALL_PERCENT = 5.0
"""Fall of the leave-one-out error from which the nearest listed effect is worth trying: it
chooses words only, and no bench tunes it."""


def explain(
    fit: Fit,
    verdict: Verdict,
    ranking: Sequence[Candidate],
    p_value: float,
    advice: Advice | None,
    prediction: Prediction | None = None,
    beyond: Mapping[str, float] | None = None,
) -> Explanation:
    """The verdict in words, and what would explain most at ``beyond`` times what parts have."""
    said = SPOKEN[verdict.code](Case(fit, verdict, ranking, p_value, advice, prediction))
    if not beyond or verdict.explains:
        return said
    return replace(said, text=f"{said.text} {beyond_parts(beyond)}")


def _nothing(case: Case) -> Explanation:
    text = f"{NOTHING_MISSING}: {case.noise_explains}."
    if case.fit.poses.reference.is_null.all():
        return Explanation("open", AT_REST, f"{text} But {AT_REST}.", "record",
                           "Record the same poses on the turning plate")
    if case.advice is not None and case.prediction is not None:
        text += f" {unsupported(case.fit, case.prediction)}{_record(case).lstrip()}"
        return Explanation("open", "directions are missing among its poses", text, *_settle(case))
    return Explanation("good", "nothing is missing", text, "apply",
                       "Correct a log, or hand the calibration to another program")


def _effect(case: Case) -> Explanation:
    verdict = case.verdict
    best = next(c for c in case.ranking if c.name == verdict.name and c.kind == "listed")
    more = verdict.names[1:]
    text = missing(verdict.group or verdict.names[:1])
    for name in more:
        text += f"'{name}' is missing beside it: {physics(name)} "
    if case.rests_on_size:
        it = "Together they explain" if more else "It explains"
        text += f"{it} {100 * verdict.share:.0f} % of the misfit ({case.misfit}). "
    else:
        text += f"It shows by its shape: {case.misfit}. "
    if best.size.size:
        largest = int(np.argmax(np.abs(best.size)))
        which = f"The largest part of '{verdict.name}'" if more else "Its largest part"
        unit, factor = display_unit(best.unit, best.size)
        size = with_sd(factor * float(best.size[largest]), factor * float(best.sd[largest]))
        text += f"{which} is {size} {unit}. "
    if verdict.details:
        text += f"The bias steps {at_times(verdict.details)}. "
    lacked = [readable(name) for name in verdict.names]
    if len(verdict.group) > 1:
        alike = enumeration([readable(name) for name in verdict.group], "and")
        lacked[0] = f"one of {alike}, which look the same here{',' * (len(more) == 1)}"
    short = f"its model lacks {enumeration(lacked, 'and')}"
    if best.size.size and "scale" not in case.fit.model.names:
        text += "That is by the gain of the data sheet, which these poses do not measure. "
    text += curves(verdict.straight) + _beside(case)
    if len(verdict.group) == 1:
        return Explanation(
            "act", short, text.rstrip(), "add",
            "Add it; everything is refitted together and the error shown before and after")
    return Explanation("act", short, text.rstrip() + _record(case), *_settle(case))


def _alike(case: Case) -> str:
    """Aliases of the named effects; empty where there are none."""
    others = enumeration([readable(name) for name in case.verdict.group[1:]], "or")
    return others and (
        f"In these poses it looks the same as {others}: they cannot determine which it is. ")


def _with_odds(case: Case, each: Inclusion) -> str:
    what = readable(each.name, each.follows, each.errs)
    if each.kind == "bad_pose":
        what = "a bad pose" if len(each.details) < 2 else "bad poses"
        what += f", {enumeration(case.named(each.details), 'and')}"
    elif each.details:
        what += f" {at_times(each.details)}"
    if len(each.members) > 1:
        what = f"one of {enumeration([readable(name) for name in each.members], 'and')}"
    return f"{what} ({odds_in_words(each.probability)})"


def _beside(case: Case) -> str:
    """Effects that may be missing beside the named ones, or that something is."""
    verdict = case.verdict
    if verdict.beside:
        words = [_with_odds(case, each) for each in verdict.beside]
        return f"Perhaps there is also {enumeration(words, 'or')}. "
    if verdict.explains or verdict.code is Code.UNKNOWN or not case.rests_on_size:
        return ""
    rest = f"{100 * (1 - verdict.share):.0f}" if verdict.share <= 0.99 else "Less than 1"
    return f"{rest} % of the misfit remain, more than noise: something else is missing too. "


def _ambiguous(case: Case) -> Explanation:
    told = {name for each in case.verdict.beside for name in each.members}
    words = [_with_odds(case, each) for each in case.verdict.beside]
    words += [readable(key) for key in case.verdict.group if key not in told]
    text = (
        f"Something may be missing ({case.misfit}), and these data cannot determine what: "
        f"{enumeration(words, 'or')}."
    )
    short = "something may be missing, and these data cannot determine what"
    return Explanation("open", short, text + _record(case), *_settle(case))


def _unknown(case: Case) -> Explanation:
    verdict, errs = case.verdict, case.verdict.errs
    assert verdict.name is not None
    if verdict.name == "time_s":
        what = f"the {errs or 'error'} changes with time, neither linearly nor exponentially"
        step = verdict.details[:1] if errs == BIAS else ()
        at = f"; if it is a step, {at_times(step)}" if step else ""
        words = [_with_odds(case, each) for each in verdict.either]
        return _course(case, what, f"{': ' if words else ''}{enumeration(words, 'or')}{at}")
    form = verdict.details[:1] if errs else ()
    subject = covariate(verdict.name, errs)
    what = " ".join((f"the {errs or 'residual'} follows", subject, *form))
    if verdict.group:
        what += f", or as {enumeration([*map(readable, verdict.group[1:])], 'or')} does"
    return _course(case, what, "")


def _course(case: Case, what: str, which: str) -> Explanation:
    """An error of unlisted shape; ``which`` says what it may be, with odds."""
    beside = "" if which else _beside(case)
    logs = (f"Look for a stated rate that is off, for {OTHER_FILES} first. "
            if case.verdict.name == "spin_rad_s" else "")
    text = (
        f"Something is missing{'' if case.verdict.group else ' that no listed effect explains'}: "
        f"{what}{which} ({case.misfit}). "
        f"{_nearest(case)}{beside}{logs}"
        f"If you know its physics, write it as your own effect (`effects:` in the configuration)."
        f"{_record(case) if case.advice is not None else ''}"
    )
    short = what if case.verdict.group else f"{what}, as no listed effect does"
    return Explanation(
        "act", short, text, "discover",
        "Look for a formula of it, or write it as your own effect under `effects:` in the "
        "configuration if you know its physics",
    )


def _nearest(case: Case) -> str:
    """Gain by the nearest listed effect for an error of unlisted shape."""
    listed = [c for c in case.ranking if c.kind == "listed" and np.isfinite(c.loo_after)]
    nearest = min(listed, key=lambda c: c.loo_after, default=None)
    if nearest is None:
        return ""
    share = 100 * (1 - nearest.loo_after / linear_loo_rms(case.fit))
    return "" if not share >= LEAST_FALL_PERCENT else (
        f"The nearest listed one, '{nearest.name}', would take {share:.0f} % off the "
        f"leave-one-out error. "
    )


def _bad_pose(case: Case) -> Explanation:
    poses = case.verdict.details
    names = enumeration(case.named(poses), "and")
    if len(poses) == 1:
        what, verb = f"One pose does not agree with the others: {names}", "it"
        short = f"the pose {names} contradicts the others"
    else:
        what, verb = f"{len(poses)} poses do not agree with the others: {names}", "them"
        short = f"the poses {names} contradict the others"
    again = f"Record {verb} again ({minutes_of(len(poses))}), or exclude {verb}"
    text = f"{what} ({case.misfit}). {_beside(case)}{again}."
    return Explanation("act", short, text, "record", again)


def _noise(case: Case) -> Explanation:
    if case.verdict.name in case.fit.model.names:
        what, text = noise_in_the_model(case.fit, str(case.verdict.name))
        return Explanation("open", what, f"{text} ({case.misfit}).", "apply", CORRECT)
    factor = np.sqrt(case.fit.weight @ case.fit.rows.residual**2 / max(case.fit.dof, 1))
    instead = f"The sds of the parameters contain it. {_instead_of_noise(case)}"
    name = case.verdict.name
    from_run_to_run = FROM_RUN_TO_RUN in case.verdict.details
    step, following = step_of_noise(factor, from_run_to_run)
    if name == "bias_wander":
        text = (
            f"The bias wanders during the session, {case.verdict.details[0]} ({case.misfit}): "
            f"standard in low-cost sensors, and no calibration takes it away. The residual is "
            f"{two_digits(factor)} times what the poses' own noise leaves. "
            f"{_alike(case)}{instead}A faster session, or poses repeated throughout it, leaves "
            f"less of it."
        )
        return Explanation("open", "its bias wanders during the session", text, step, following)
    if name == "rate_scatter":
        rates = rates_by_the_readings(case.fit) if from_run_to_run else ""
        text = (f"The rate of the plate scatters {case.verdict.details[0]} ({case.misfit}){rates}. "
                f"{_alike(case)}{instead}Film the plate with each pose, so that each has its own.")
        if step == "add" and (case.advice is not None or from_run_to_run):
            step, following = "record", f"Film the plate with each pose ({CLIPS.minutes:.0f} min)"
        return Explanation("open", "the rate of the plate scatters", text, step, following)
    text = (
        f"The residual is {two_digits(factor)} times what the poses' own noise leaves, "
        f"without a shape that any effect has ({case.misfit}). "
        f"{kind_of_noise(case.verdict.group)}{instead}{remedy_of_noise(factor)}"
    )
    short = "the residual is larger than the noise, without any shape"
    if name is None:
        return Explanation("open", short, f"{text} {NOTHING_MORE}.", "apply", CORRECT)
    return Explanation("open", short, text, step, following)


def _instead_of_noise(case: Case) -> str:
    """Alternatives to the noise that is named, with odds."""
    lead = case.verdict.name or "noise"
    itself = {lead, *case.verdict.group, *(["noise"] if lead in SHAPELESS else [])}
    words = [_with_odds(case, each) for each in case.verdict.beside if each.name not in itself]
    return f"It may be {enumeration(words, 'or')} instead, or beside it. " if words else ""


def _settle(case: Case) -> tuple[Step, str]:
    """The next step where something is open, for programs and in words."""
    if case.advice is not None and case.advice.is_worth_it:
        return "record", f"Record {case.advice.timed}"
    if case.verdict.code == Code.EFFECT:
        return "add", ("Add it for all that look the same: the correction is valid under the "
                       "conditions of this session")
    return "apply", CORRECT


def _record(case: Case) -> str:
    """The end of a verdict that leaves something open: what to record next."""
    if case.advice is not None and case.advice.is_worth_it:
        return f" Record next: {case.advice.timed}."
    open_still = ("" if case.verdict.code == Code.EFFECT
                  else " The error to expect contains what is open.")
    if case.advice is not None:
        return (f" {NOTHING_MORE}: the best of its blocks of poses is {case.advice.timed}."
                f"{open_still}")
    if case.verdict.code == Code.EFFECT:
        separates = what_separates(case.verdict.group[0], case.fit.poses.triad)
        return (f" {NOTHING_MORE}: none of its blocks of poses tells them apart. Elsewhere that "
                f"would be: {separates}.")
    return f" {NOTHING_MORE}: none of its blocks of poses shows it.{open_still}"


SPOKEN: Mapping[Code, Callable[[Case], Explanation]] = {
    Code.NOTHING_MISSING: _nothing,
    Code.EFFECT: _effect,
    Code.AMBIGUOUS: _ambiguous,
    Code.UNKNOWN: _unknown,
    Code.BAD_POSE: _bad_pose,
    Code.NOISE: _noise,
}
