"""The verdict on a search: is anything missing, what, and do these data determine it.

Three rules. Nothing is missing at a probability of one half and more, where the noise explains the
residual. An effect is named when its class without noise is missing at ``sure``, the refit with it
lowers the exact leave-one-out error, and it takes most of the misfit. Else all that is credible,
with its odds; what of it has no name by its kind: bad poses, a course that no effect has, noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.special import expit

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import (
    ANY_FUNCTION,
    ATTITUDE,
    BIAS,
    GAIN,
    OWN_AXIS,
    Hypothesis,
    held,
)
from calib.diagnosis.hypotheses.unlisted import seen_far_apart
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.refit import Refit, explained, refit
from calib.diagnosis.verdict.beside import beside
from calib.diagnosis.verdict.kinds_of_noise import (
    RATES,
    as_no_plate_scatters,
    kinds_in_a_class,
    kinds_of_noise,
    told_apart,
    unexplained_noise,
)
from calib.effects.catalogue import SECOND_WARM_UP, WARM_UP, find_effect
from calib.fit.noise_size import FORMULA_ERROR
from calib.fit.rows.model_terms import follows_vector
from calib.fit.validation.leave_one_out import compare
from calib.fit.validation.odd_poses import few_odd_poses
from calib.poses.imu_log import FloatArray


class Code(StrEnum):
    """What a verdict says, for programs."""

    NOTHING_MISSING = "nothing_missing"
    EFFECT = "effect"
    AMBIGUOUS = "ambiguous"
    UNKNOWN = "unknown"
    BAD_POSE = "bad_pose"
    NOISE = "noise"
    REFUSED = "refused"


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is missing.

    Parameters
    ----------
    code : Code
    name : str or None
        The effect, column, pose or kind of noise it speaks of.
    names : tuple of str
        All effects that are named, the largest first.
    group : tuple of str
        All that these poses cannot separate from ``name``, itself first, an unknown function by
        the name of its class; or all that an ambiguous verdict leaves open.
    details : tuple of str
        Poses, times or forms of what is not an effect.
    beside : tuple of Inclusion
        What may be missing beside what is named.
    share : float
        Part of the misfit that the leading set takes.
    explains : bool
        Whether the poses' own noise explains what is left.
    straight : tuple of str
        What a named effect is a function of, where another function of it would look the same.
    either : tuple of Inclusion
        All that an unknown course may be.
    errs : str
        What of the reading an unknown function is, where the rows tell.
    """

    code: Code
    name: str | None = None
    names: tuple[str, ...] = ()
    group: tuple[str, ...] = ()
    details: tuple[str, ...] = ()
    beside: tuple[Inclusion, ...] = ()
    share: float = 0.0
    explains: bool = False
    straight: tuple[str, ...] = ()
    either: tuple[Inclusion, ...] = ()
    errs: str = ""


def reach_verdict(posterior: Posterior) -> Verdict:
    """The verdict, by the first of the module's rules that holds."""
    if posterior.is_nothing:
        noise = unexplained_noise(posterior.base)
        return (Verdict(Code.NOTHING_MISSING, explains=True) if noise is None else
                Verdict(Code.NOISE, noise, group=(noise,), explains=True))
    base, is_known = posterior.base, bool(posterior.table.noise.is_known)
    share, explains = explained(base, posterior.lead.refit, is_known)
    named, joint = _named(posterior)
    steps = tuple(posterior.hypotheses[j].detail for j in posterior.lead.members
                  if _is_step(posterior.hypotheses[j]))
    if joint is not None:
        with_names = (share, explains) if explains else explained(base, joint, is_known)
        if not with_names[1] and 2 * with_names[0] < 1:
            return _unlisted(posterior, share, explains) or _noise(
                posterior, kinds_of_noise(posterior.base))
        share, explains = with_names
        first = named[0]
        return Verdict(
            Code.EFFECT, first.name, tuple(each.name for each in named), first.members,
            details=steps if any(_is_step(posterior.first[each.name]) for each in named) else (),
            beside=beside(posterior, named), share=share, explains=explains,
            straight=tuple(dict.fromkeys(
                subject for each in named if seen_far_apart(
                    base, subject := posterior.first[each.name].covariate))),
        )
    likely = _open(posterior)
    return _unlisted(posterior, share, explains) or Verdict(
        Code.AMBIGUOUS,
        group=tuple(dict.fromkeys(name for each in likely for name in each.members)),
        beside=likely, share=share, explains=explains,
    )


def _is_step(h: Hypothesis) -> bool:
    """Whether it is a step of the bias at a time of its own."""
    return h.kind == "listed" and h.is_placed


def _named(posterior: Posterior) -> tuple[list[Inclusion], Refit | None]:
    """The classes that can be named, the largest signal first, and the refit with their names.

    A wander in the place of one is noise, which no effect takes off, and does not count for a name.
    Beside the largest nothing is said of one that explains less than a formula may be off by, or
    than most of what is left without it. Where the leave-one-out error does not fall with all of
    them, or they leave a misfit and are not believed by twenty to one, the least likely goes.
    """
    noise = {h.name for h in posterior.hypotheses if h.kind == "drawn"}
    likely = {each.name: posterior.any_of({*each.members} - noise) for each in posterior.classes}
    sure = [each for each in posterior.classes
            if each.kind == "listed" and likely[each.name] >= CONSTANTS.sure]
    sure.sort(key=lambda each: -each.probability)
    before = compare(posterior.base) if sure else None
    while sure:
        joint = refit_of(posterior, [each.name for each in sure])
        least = CONSTANTS.sure if joint and joint.explains else expit(CONSTANTS.told_apart)
        if (joint and before and min(likely[each.name] for each in sure) >= least
                and compare(joint.fit).predicts_better_than(before)):
            size = {each.name: float(np.linalg.norm(_signal_rows(posterior, joint, each.name)))
                    for each in sure}
            least = FORMULA_ERROR * max(size.values())
            if not joint.explains:  # a formula is off by what is left, and more looks like another
                rest = np.sqrt(joint.fit.weight @ joint.fit.rows.residual**2)
                whole = [each for each in sure if rest <= FORMULA_ERROR * size[each.name]
                         or not _is_part(posterior, each, joint)]
                if len(whole) < len(sure):
                    sure = whole
                    continue
                least = max(least, rest * np.sqrt(CONSTANTS.sure / (1 - CONSTANTS.sure)))
            kept = [each for each in sure if size[each.name] >= least] or [
                max(sure, key=lambda each: size[each.name])]
            return sorted(kept, key=lambda each: -size[each.name]), joint
        sure.pop()
    return [], None


def _is_part(posterior: Posterior, each: Inclusion, joint: Refit) -> bool:
    """Whether it is part of an unknown function beside it in the leading set, and no name.

    The sum of two functions of what an axis senses is one function of it, of which the effect is
    a term, also where it follows a column besides; so is a bias, or a gain, that follows time in a
    line beside one that does in a bend.
    """
    h = posterior.first[each.name]
    if h.effect is None:
        return False
    of_vector = follows_vector(h.effect, posterior.base.equations.at_start)
    beside = {name: posterior.what_errs(name) for name in posterior.names(posterior.lead)
              if name.startswith(ANY_FUNCTION)}
    same = beside.get(ANY_FUNCTION + h.covariate)
    if same in (None, BIAS if of_vector else GAIN) and not (
            of_vector and OWN_AXIS in beside.values()):
        return False
    if h.name != WARM_UP:
        return True
    both = refit(joint.fit, [find_effect(SECOND_WARM_UP)])  # which is listed beside the first alone
    return both is None or not both.explains


def refit_of(posterior: Posterior, names: Sequence[str]) -> Refit | None:
    """The refit with the members ``names`` of the leading set; None where the rows have none."""
    hypotheses = posterior.hypotheses
    members = [j for j in posterior.lead.members if hypotheses[j].name in names]
    for entry in posterior.entries:
        if entry.refit is not None and {*entry.members} == {*members}:
            return entry.refit
    if len(members) > len(names) and posterior.lead.refit is None:
        return None  # several steps imitate any course: they are named where they are a solution
    return refit(posterior.base, [held(hypotheses[j], j) for j in members if hypotheses[j].effect])


def _signal_rows(posterior: Posterior, joint: Refit, name: str) -> FloatArray:
    """What an effect of ``joint`` explains, whitened, the model projected out, (r,)."""
    same = {held(h, j).name for j, h in enumerate(posterior.hypotheses) if h.name == name}
    return joint.signal(same, posterior.table.projector)


def _open(posterior: Posterior) -> tuple[Inclusion, ...]:
    """What may be missing, the most probable first; noise among it by its own probability."""
    noise = Inclusion("noise", ("noise",), posterior.noise, "noise")
    every = sorted((*posterior.classes, *posterior.others, noise),
                   key=lambda each: -each.probability)
    least = CONSTANTS.least_offered * (1 - posterior.nothing)
    likely = [each for each in every if each.probability >= least]
    return tuple(likely or every[:1])


def _unlisted(posterior: Posterior, share: float, explains: bool) -> Verdict | None:
    """The verdict on what has no name in the leading set; None where it is open."""
    lead, something = posterior.lead, 1 - posterior.nothing
    least = CONSTANTS.sure * something
    members = [posterior.hypotheses[j] for j in lead.members]
    is_function = any(h.kind == "unknown" and posterior.any_of([h.name]) >= least for h in members)
    drawn = kinds_in_a_class(posterior)
    if drawn and not is_function:
        return _noise(posterior, drawn)
    noises = posterior.noise + sum(
        posterior.mass(e) for e in posterior.entries
        if any(posterior.hypotheses[j].kind == "drawn" for j in e.members))
    if noises >= least and not is_function:
        first = next((h for h in members if h.kind == "drawn"), None)
        return _noise(posterior, (first.name,) if first else kinds_of_noise(posterior.base))
    unnamed = [h for h in members if h.kind != "listed" or h.is_placed]
    if not unnamed:
        return None
    first = max(unnamed, key=lambda h: (h.kind != "bad_pose", posterior.any_of([h.name])))
    alike = next(each.members for each in posterior.classes if each.name == first.name)
    mass = posterior.any_of(alike if first.kind == "unknown" else [first.name])
    details = tuple(h.detail for h in members if h.name == first.name and h.detail)
    errs = posterior.what_errs(first.name) if first.follows else BIAS
    if first.is_course:
        courses = {h.name for h in posterior.hypotheses if h.is_course}
        if posterior.any_of(courses) < least:
            return None
        if mass < least:
            return Verdict(
                Code.UNKNOWN, "time_s", details=_best_step(posterior),
                either=tuple(each for each in _open(posterior) if each.name in courses),
                share=share, explains=explains, errs=errs,
            )
    if mass < least or first.kind == "listed":  # a step without which poses are predicted better
        return None
    if first.kind == "drawn":
        return _noise(posterior, (first.name,))
    if first.kind == "bad_pose":
        return Verdict(Code.BAD_POSE, details[0], group=details, details=details, share=share,
                       explains=explains)
    if first.follows == ATTITUDE and (odd := few_odd_poses(posterior.base)):
        return Verdict(Code.BAD_POSE, odd[0], group=odd, details=odd, share=1.0, explains=True)
    return Verdict(
        Code.UNKNOWN, first.subject, group=alike if len(alike) > 1 else (),
        details=details, errs=errs,
        beside=beside(posterior, [each for each in posterior.classes if each.name == first.name]),
        share=share, explains=explains,
    )


def _noise(posterior: Posterior, group: tuple[str, ...]) -> Verdict:
    """The verdict on noise: ``group`` are the kinds of it that look the same, the first its name.

    A wander of few poses may be noise that is the same at all times.
    """
    lead = [posterior.hypotheses[j] for j in posterior.lead.members]
    detail = {h.name: h.detail for h in (*posterior.first.values(), *reversed(lead))}
    group = told_apart(posterior.base, group, detail.get(next(iter(group), ""), ""))
    name = next(iter(group), None)
    details = tuple(detail[each] for each in group[:1] if each in detail)
    if name == RATES and (form := as_no_plate_scatters(posterior.base, details)):
        return Verdict(Code.UNKNOWN, "spin_rad_s", details=(form,), errs="error")
    return Verdict(Code.NOISE, name, group=group, beside=_open(posterior), details=details)


def _best_step(posterior: Posterior) -> tuple[str, ...]:
    """When the bias steps, if it steps once; empty where no time is known."""
    steps = [j for j, h in enumerate(posterior.hypotheses) if _is_step(h)]
    if not steps:
        return ()
    best = max(steps, key=lambda j: posterior.log_factor[j])
    return (posterior.hypotheses[best].detail,)
