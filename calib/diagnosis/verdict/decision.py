"""The verdict on a search: is anything missing, what, and do these data determine it.

Nothing is asked first. Effects are named when their classes are in the model together at odds that
grow with their number (``odds_of_a_name``), and the set they stand in explains: the rows, or most
of the misfit while the leave-one-out error falls. What has no name follows: bad poses, a course
that no effect has, and noise after all of these; where several remain, all that are credible, with
their odds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.unlisted import IN_A_CURVE
from calib.diagnosis.search.odds import Inclusion, Odds, is_course
from calib.diagnosis.search.sets import Search, is_nothing
from calib.diagnosis.verdict.explained import explained, predicted_share, signal_rows
from calib.fit.validation.leave_one_out import left_out_square
from calib.poses.imu_log import FloatArray

NOISES = ("wander", "plate_rate")
"""Kinds that no calibration takes away: they widen the sds."""


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
        All that these poses cannot separate from ``name``, itself first; or all that an ambiguous
        verdict leaves open, an unknown function by the name of its class.
    details : tuple of str
        Poses, times or forms of what is not an effect.
    beside : tuple of Inclusion
        What may be missing beside what is named.
    share : float
        Part of the misfit that the leading set takes.
    explains : bool
        Whether the poses' own noise explains what is left.
    straight : tuple of str
        Logged columns that a named effect follows along a straight line, where a curve in them
        would look the same.
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


def reach_verdict(state: Search, odds: Odds) -> Verdict:
    """The verdict, by the first of the module's questions that has an answer."""
    if is_nothing(state):
        return Verdict(Code.NOTHING_MISSING, explains=True)
    share, explains = explained(state, odds)
    named = _named(state, odds)
    if named and share > CONSTANTS.most_of_the_misfit and not explains:
        share = predicted_share(state, odds, named)
    if named and (explains or share > CONSTANTS.most_of_the_misfit):
        first = named[0]
        alone = _one_pose(state, odds, first) if len(named) == 1 else None
        if alone is not None:
            return Verdict(Code.BAD_POSE, alone, group=(alone,), details=(alone,), share=share,
                           explains=explains)
        return Verdict(
            Code.EFFECT, first.name, tuple(each.name for each in named), first.members,
            beside=_beside(state, odds, named), share=share, explains=explains,
            straight=_as_a_curve(state, odds, named),
        )
    share, _ = explained(state, odds)
    unlisted = _unlisted(state, odds, share, explains)
    if unlisted is not None:
        return unlisted
    likely = tuple(name for each in _open(odds) for name in each.members)
    return Verdict(
        Code.AMBIGUOUS, group=tuple(dict.fromkeys((*likely, *_explaining(state, odds)))),
        beside=_open(odds), share=share, explains=explains,
    )


def _named(state: Search, odds: Odds) -> list[Inclusion]:
    """The classes of the leading set that can be named together, the largest signal first.

    The k-th name stands when all k are in the model at odds of ``odds_of_a_name`` to the power k:
    every name is known by a formula only, and what that misses looks like the next one.
    """
    signal = {state.hypotheses[j].name: _signal(state, odds, j) for j in odds.lead.members}
    least = CONSTANTS.tolerance * max(signal.values(), default=0.0)
    kinds = {state.hypotheses[j].name: state.hypotheses[j].kind for j in odds.lead.members}
    judges = _judges(state, odds)
    sure = sorted(odds.classes, key=lambda each: -each.probability)
    named: list[Inclusion] = []
    for each in sure:
        if kinds[each.name] != "listed" or signal[each.name] < least:
            continue
        together = _together(odds, [*named, each], judges)
        if together < 1 - 1 / (1 + CONSTANTS.odds_of_a_name ** (len(named) + 1)):
            break
        named.append(each)
    return sorted(named, key=lambda each: -signal[each.name])


def _judges(state: Search, odds: Odds) -> Mapping[int, float]:
    """The sets that say what is in the model: without unknown functions where they crowd it."""
    if not _is_crowded(state, odds):
        return odds.masses
    unknown = odds.mask({h.name for h in state.hypotheses if h.kind == "unknown"})
    return {key: mass for key, mass in odds.masses.items() if not key & unknown}


def _is_crowded(state: Search, odds: Odds) -> bool:
    """Whether an unknown function takes up the rows that would speak for what stands beside it."""
    members = odds.lead.members
    unknown = any(state.hypotheses[j].kind == "unknown" for j in members)
    rest = state.table.dof - sum(int(state.table.seen[j]) for j in members)
    return unknown and rest < CONSTANTS.fewest_dof


def _together(odds: Odds, classes: Sequence[Inclusion], judges: Mapping[int, float]) -> float:
    """Probability that one member of each of ``classes`` is in the model, by these sets."""
    masks = [odds.mask(each.members) for each in classes]
    inside = sum(mass for key, mass in judges.items() if all(key & mask for mask in masks))
    return inside / sum(judges.values())


def _signal_rows(state: Search, odds: Odds, j: int) -> FloatArray | None:
    """What a member of the leading set explains, noise units, the model projected out, (r,)."""
    h, joint = state.hypotheses[j], odds.lead.refit
    if joint is None or not state.can_refit([j]):
        return None
    name = next((n for n in joint.names if n in (h.name, f"{h.name} {j}")), None)
    if name is None:  # more members than the rows carry a refit of
        return None
    return signal_rows(state, joint, name)


def _signal(state: Search, odds: Odds, j: int) -> float:
    """Root mean square of what a member of the leading set explains, noise units."""
    rows = _signal_rows(state, odds, j)
    return 0.0 if rows is None else float(np.sqrt(np.mean(rows**2)))


def _one_pose(state: Search, odds: Odds, named: Inclusion) -> str | None:
    """The pose whose own error would look the same as a named effect, if there is one.

    An effect of which one pose shows nearly all is no more than that this pose contradicts the
    others; the effect's size then has no second witness.
    """
    j = next(j for j in odds.lead.members if state.hypotheses[j].name == named.name)
    signal = _signal_rows(state, odds, j)
    if signal is None:
        return None
    pose = state.base.equations.row_pose
    share = left_out_square(signal, state.table.projector.model, pose)
    alone = share > CONSTANTS.alias_correlation**2 * float(signal @ signal)
    return str(state.base.poses.label[np.flatnonzero(alone)[0]]) if alone.any() else None


def _as_a_curve(state: Search, odds: Odds, named: Sequence[Inclusion]) -> tuple[str, ...]:
    """Columns of which the poses show too few values to tell a straight line from a curve."""
    columns = []
    for each in named:
        j = next(j for j in odds.lead.members if state.hypotheses[j].name == each.name)
        effect = state.hypotheses[j].effect
        column = None if effect is None else effect.names_column
        curves = [k for k, h in enumerate(state.hypotheses)
                  if column is not None and h.follows == column and h.detail == IN_A_CURVE]
        if any(state.table.correlations(j, curves, ()) > CONSTANTS.alias_correlation):
            columns.append(str(column))
    return tuple(columns)


def _beside(state: Search, odds: Odds, named: Sequence[Inclusion]) -> tuple[Inclusion, ...]:
    """What else may be missing, its probability not small."""
    known = {each.name for each in named}
    more = [each for each in (*odds.classes, *odds.others) if each.name not in known]
    return tuple(each for each in more if each.probability >= 1 - CONSTANTS.sure)


def _open(odds: Odds) -> tuple[Inclusion, ...]:
    """What may be missing, the most probable first; noise among it by its own probability."""
    noise = Inclusion("noise", ("noise",), odds.noise, "noise")
    every = sorted((*odds.classes, *odds.others, noise), key=lambda each: -each.probability)
    least = CONSTANTS.least_offered * (1 - odds.nothing)
    likely = [each for each in every if each.probability >= least]
    return tuple(likely or every[:1])


def _explaining(state: Search, odds: Odds) -> tuple[str, ...]:
    """The effects of the best set of effects alone that explains the rows, if it is not far off."""
    least = odds.lead.log_posterior - CONSTANTS.behind
    sets = [
        e for e in state.entries.values()
        if e.explains and e.log_posterior > least
        and all(state.hypotheses[j].kind == "listed" for j in e.members)
    ]
    if not sets:
        return ()
    return tuple(state.hypotheses[j].name for j in state.best(sets).members)


def _unlisted(state: Search, odds: Odds, share: float, explains: bool) -> Verdict | None:
    """The verdict on what has no name in the leading set; None where it is open."""
    members = [state.hypotheses[j] for j in odds.lead.members]
    members = [h for h in members if h.kind != "listed"]
    if not odds.lead.members:
        return Verdict(Code.NOISE, beside=_open(odds)) if _is_noise(odds, odds.noise) else None
    if not members:
        return None
    probability = {each.name: each.probability for each in (*odds.classes, *odds.others)}
    first = max(members, key=lambda h: (h.kind != "bad_pose", probability.get(h.name, 0.0)))
    mass = probability.get(first.name, 0.0)
    if first.kind in NOISES and _is_noise(odds, mass):
        details = tuple(h.detail for h in members if h.name == first.name)
        return Verdict(Code.NOISE, first.name, details=details, beside=_open(odds))
    if is_course(first):
        every = {each.name: each for each in (*odds.classes, *odds.others)}.values()
        mass = min(1.0, sum(each.probability for each in every if is_course(each)))
    if mass < CONSTANTS.sure * (1 - odds.nothing):
        return None
    alone = probability.get(first.name, 0.0) >= CONSTANTS.sure * (1 - odds.nothing)
    if is_course(first) and not alone:
        return Verdict(
            Code.UNKNOWN, "time_s", details=_best_step(state),
            beside=tuple(each for each in _open(odds) if is_course(each)),
            share=share, explains=explains,
        )
    same = [h for h in members if h.name == first.name]
    details = tuple(h.detail for h in same if h.detail)
    if first.kind == "bad_pose":
        return Verdict(
            Code.BAD_POSE, details[0], group=details, details=details, share=share,
            explains=explains,
        )
    if first.kind == "unknown" and _explaining(state, odds):
        return None  # effects that have names would do as well
    if first.kind == "unknown" and not _smoother_predicts(state, odds):
        return Verdict(Code.NOISE)
    return Verdict(
        Code.UNKNOWN, first.subject, details=details, beside=_beside(state, odds, odds.classes),
        share=share, explains=explains,
    )


def _is_noise(odds: Odds, leading: float) -> bool:
    """Whether the rows hold noise that the poses do not show: the leading kind is sure by itself,
    or one of its kinds is and no effect is likely. They differ by what would lower them only.
    """
    of_a_kind = sum(share for names, share in odds.sets if {*names} & {*NOISES})
    effects = [each for each in (*odds.classes, *odds.others) if each.kind == "listed"]
    likely = any(each.probability >= 1 - CONSTANTS.sure for each in effects)
    least = CONSTANTS.sure * (1 - odds.nothing)
    return leading >= least or (of_a_kind + odds.noise >= least and not likely)


def _best_step(state: Search) -> tuple[str, ...]:
    """When the bias steps, if it steps once; empty where no time is known."""
    steps = [j for j, h in enumerate(state.hypotheses) if h.kind == "jump"]
    if not steps:
        return ()
    return (state.hypotheses[max(steps, key=lambda j: state.alone.log_factor[j])].detail,)


def _smoother_predicts(state: Search, odds: Odds) -> bool:
    """Whether the leave-one-out error falls with the leading set, each size held to its best."""
    pose = state.base.equations.row_pose
    before = state.table.left_out((), pose)
    after = state.table.left_out(odds.lead.members, pose)
    return float(after @ after) < float(before @ before)
