"""The diagnosis of one fit: the effects that its model lacks.

Everything that could be missing stands at one table: listed effects, logged columns, the user's
effects, what the base lacks, steps, curves, a wandering bias, bad poses, noise. A search over sets
of them gives probabilities; the verdict names what is sure and explains; and where these poses
leave something open, the block of poses that would settle it is computed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.averaged import Averaged, averaged
from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses.columns import set_aside
from calib.diagnosis.next_measurement.advice import (
    Advice,
    block_called,
    lay_missing,
    settling_block,
)
from calib.diagnosis.next_measurement.chance import (
    Rival,
    chance_of_a_name,
    chance_of_hypotheses,
)
from calib.diagnosis.next_measurement.pose_blocks import CLIPS, SOAK
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.stand_ins import StandIn, stand_ins
from calib.diagnosis.verdict.decision import Code, Verdict, refit_of
from calib.diagnosis.verdict.explain import explain
from calib.diagnosis.verdict.explanation import Explanation
from calib.diagnosis.verdict.ranking import Candidate, rank
from calib.diagnosis.verdict.wording import enumeration
from calib.effects.effect import EFFECTS, Effect
from calib.fit.least_squares.result import Fit
from calib.fit.validation.elsewhere import mean_square_error
from calib.fit.validation.prediction import Prediction
from calib.poses.imu_log import TEMPERATURE
from calib.threads import on_one_thread

NOT_ELSEWHERE = "Record the same poses in random order: with it new attitudes would err by more"
"""What follows a name that these poses determine only where they are."""


@dataclass(frozen=True)
class Limit:
    """Upper limit of an effect that was tested, 95 %, on its largest parameter."""

    name: str
    value: float
    unit: str


SHOWN = 4  #: classes with their probabilities, of a diagnosis in a notebook; a length of text


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Diagnosis of one fit.

    Parameters
    ----------
    verdict : Code
        ``nothing_missing``, ``effect``, ``ambiguous``, ``unknown``, ``bad_pose`` or ``noise``.
    name, names, group
        As of :class:`calib.diagnosis.verdict.decision.Verdict`.
    inclusion : tuple of Inclusion
        Every class that may be missing with its probability, the most probable first.
    sets : tuple of (tuple of str, float)
        The sets that remain, with their probabilities.
    explanation : Explanation
        The verdict in words, how it stands, and the next step.
    advice : Advice or None
        What to record next, where these data leave something open.
    ranking : tuple of Candidate
        Every hypothesis, the most probable first.
    blind : tuple of str
        Listed effects that these poses cannot see, or would only at a size that no part has.
    unavailable : dict
        Listed effects that could not be evaluated, and why.
    aside : tuple of str
        Logged columns that were not taken for causes: they follow the attitude or the clock.
    p_value : float
        Whether the poses' own noise explains the residual.
    averaged : Averaged
        What the parameters hold of all that may be missing, for their sds.
    stands_for : mapping of str to StandIn
        Effects of the model that these poses do not tell from others, and those.
    """

    verdict: Code
    name: str | None
    names: tuple[str, ...]
    group: tuple[str, ...]
    inclusion: tuple[Inclusion, ...]
    sets: tuple[tuple[tuple[str, ...], float], ...]
    explanation: Explanation
    advice: Advice | None
    ranking: tuple[Candidate, ...]
    blind: tuple[str, ...]
    unavailable: dict[str, str]
    aside: tuple[str, ...]
    p_value: float
    averaged: Averaged
    stands_for: Mapping[str, StandIn]

    @property
    def text(self) -> str:
        """The verdict in words."""
        return self.explanation.text

    def saying(self, more: str) -> "Diagnosis":
        """The same with a sentence more."""
        return replace(self, explanation=replace(self.explanation, text=self.text + more))

    def __repr__(self) -> str:
        odds = ", ".join(f"{' or '.join(each.members)} {each.probability:.2g}"
                         for each in self.inclusion[:SHOWN])
        following = self.explanation.following
        return "\n".join(filter(None, [
            f"{self.verdict}: {self.text}", odds and f"probabilities: {odds}",
            following and f"next: {following}"]))

    @property
    def listed(self) -> dict[str, Candidate]:
        """Candidates of the listed and own effects by name, the most probable first."""
        return {c.name: c for c in self.ranking if c.kind == "listed"}

    @property
    def addable(self) -> tuple[str, ...]:
        """The named effects that can be added as they are: no other has the same signature."""
        if self.explanation.step == "add" and self.verdict is Code.NOISE and self.name:
            return (self.name,)
        alone = {each.name for each in self.inclusion if len(each.members) == 1}
        return tuple(name for name in self.names if name in alone)

    def named_class(self, name: str) -> tuple[str, ...]:
        """All members of the named class of ``name``; empty without one."""
        classes = (each.members for each in self.inclusion if each.name in self.names)
        return next((members for members in classes if name in members), ())

    def is_guess(self, name: str) -> bool:
        """Whether to add ``name`` is a guess: no verdict names it, and others look the same, or the
        odds are against it by itself and among what may be missing."""
        one = self.listed.get(name)
        return one is not None and not self.named_class(name) and bool(
            one.aliases or (one.log_evidence <= 0 and one.probability < 0.5))

    def by_itself(self, name: str) -> float:
        """Probability of an effect alone, where ``inclusion`` has that of its class."""
        return sum(probability for names, probability in self.sets if name in names)

    def offered(self, name: str) -> str:
        """The effect to add for ``name``: of those that look the same, one that samples of another
        log tell, unless ``name`` is sure against it."""
        least = self.by_itself(name) * (1 - CONSTANTS.sure) / CONSTANTS.sure
        members = [EFFECTS[each] for each in self.named_class(name) if each in EFFECTS]
        told = [each.name for each in members
                if each.told_by == "sample" and self.by_itself(each.name) > least]
        return name if not told or name not in EFFECTS or name in told else told[0]

    @property
    def follows(self) -> str | None:
        """The covariate that the misfit follows best, whatever its physics; None without one."""
        unknown = [c for c in self.ranking if c.kind == "unknown"]
        best = max(unknown, key=lambda c: c.log_evidence, default=None)
        if best is None or best.log_evidence <= CONSTANTS.told_apart:
            return None
        return best.name

    @property
    def record_next(self) -> str | None:
        """The next measurement, in words."""
        return None if self.advice is None else self.advice.instruction

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Upper limits of the effects that were tested and are not named."""
        return tuple(
            Limit(c.name, float((np.abs(c.size) + CONSTANTS.limit_sd * c.sd).max()), c.unit)
            for c in self.listed.values() if c.name not in self.names and c.size.size
        )


@on_one_thread
def diagnose(
    fit: Fit,
    user_effects: Sequence[Effect] = (),
    full_scale: float = np.inf,
    covariates: Sequence[str] | None = None,
    prediction: Prediction | None = None,
) -> Diagnosis:
    """Diagnose ``fit``.

    Parameters
    ----------
    fit : Fit
        The fitted model.
    user_effects : sequence of Effect
        Users' effects, weighed with the listed ones.
    full_scale : float
        Of the triad, SI; keeps what to record next to what the sensor can measure.
    covariates : sequence of str, optional
        Logged columns that may cause an error; without it all but those that follow the attitude
        or the clock by themselves (magnetometer, orientation, status).
    prediction : Prediction, optional
        What the calibration will err by; where it does not hold in every direction, the verdict
        says so and asks for poses there.
    """
    finding = find(fit, user_effects, covariates)
    posterior, verdict = finding.posterior, finding.verdict
    joint = refit_of(posterior, verdict.names) if verdict.names else None
    ranking = rank(posterior, joint)
    # Effects seen only at an absurd size count as unseen, unless the poses do show them.
    too_small = finding.absurd
    absurd = [one.name for one in ranking
              if one.name in too_small and one.probability < CONSTANTS.least_offered]
    ranking = tuple(one for one in ranking if one.name not in absurd)
    advice = _advise(posterior, verdict, ranking, full_scale)
    if verdict.code in (Code.NOTHING_MISSING, Code.AMBIGUOUS, Code.NOISE) and (
        verdict.name != "rate_scatter"
    ):
        advice = lay_missing(fit, prediction) or advice
    explanation = explain(
        fit, verdict, ranking, posterior.p_value, advice, prediction, posterior.beyond)
    if joint is not None and not verdict.details and explanation.step == "add" and (
            mean_square_error(joint.fit) >= mean_square_error(fit)):
        explanation = replace(explanation, step="record", following=NOT_ELSEWHERE)
    standing_in = stand_ins(fit, posterior.hypotheses)
    explanation = replace(explanation, text=" ".join([explanation.text, *(
        f"'{name}' of the model stands for its class: these poses do not tell it from "
        f"{enumeration(alike.names, 'or')}." for name, alike in standing_in.items())]))
    return Diagnosis(
        verdict=verdict.code,
        name=verdict.name,
        names=verdict.names,
        group=verdict.group,
        inclusion=posterior.inclusion,
        sets=tuple(each for each in posterior.sets if each[1] >= CONSTANTS.least_listed),
        explanation=explanation,
        advice=advice if advice is not None and advice.is_worth_it else None,
        ranking=ranking,
        blind=(*finding.blind, *absurd),
        unavailable=finding.unavailable,
        aside=set_aside(fit.poses, covariates),
        p_value=posterior.p_value,
        averaged=averaged(posterior),
        stands_for=standing_in,
    )


def _advise(
    posterior: Posterior,
    verdict: Verdict,
    ranking: Sequence[Candidate],
    full_scale: float,
) -> Advice | None:
    """The block that would settle an open verdict."""
    if "rate_scatter" in (verdict.name, *verdict.group):
        return block_called(posterior.base, CLIPS.code)
    if verdict.code == Code.UNKNOWN and verdict.name == TEMPERATURE:
        return block_called(posterior.base, SOAK)
    is_open = verdict.code == Code.AMBIGUOUS or len(verdict.group) > 1
    if not is_open or verdict.code not in (Code.AMBIGUOUS, Code.EFFECT):
        return None
    size = {c.name: c.size for c in ranking if c.kind == "listed"}
    rivals = {h.name: Rival(h.effect, size[h.name], h.shape)
              for h in posterior.hypotheses if h.effect and not h.is_placed and h.name in size}
    if rivals.keys() >= {*verdict.group}:
        some = [rivals[name] for name in verdict.group]
        return settling_block(
            posterior.base, lambda then: chance_of_a_name(then, some), full_scale)
    return settling_block(
        posterior.base, lambda then: chance_of_hypotheses(posterior, then, verdict.group),
        full_scale)
