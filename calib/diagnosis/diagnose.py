"""What is missing: the diagnosis of one fit.

First whether anything is: chi-square against the poses' own noise. Then every hypothesis of
:mod:`calib.diagnosis.hypotheses` is ranked by its evidence, effects that these poses cannot see or
cannot tell apart are named as such, the leading ones are judged by a joint refit, and where several
remain, the block of poses that would tell them apart is computed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.explain import put_into_words
from calib.diagnosis.hypotheses import Hypothesis, weigh
from calib.diagnosis.next_measurement import Advice, Rival, best_block
from calib.diagnosis.ranking import Candidate, log_posterior, rank
from calib.diagnosis.refit import judge, refitted
from calib.diagnosis.signature import Projector
from calib.diagnosis.verdict import FOLLOWS_EVIDENCE, Judge, Verdict, is_nothing
from calib.effects.effect import Effect
from calib.fit.result import Fit

RIVALS_COMPARED = 4


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What the model of one fit is missing.

    Parameters
    ----------
    verdict : str
        ``nothing_missing``, ``effect``, ``ambiguous``, ``unknown``, ``bad_pose`` or ``noise``.
    name : str or None
        The effect, column or pose it speaks of.
    group : tuple of str
        All that cannot be told from ``name``, itself first; or all that an ambiguous verdict
        leaves open, unknown functions of NAME as ``~NAME``.
    partner : str or None
        A second effect found together with the first.
    says : str
        The verdict in words.
    advice : Advice or None
        What to record next, where these data cannot tell.
    ranking : tuple of Candidate
        Every hypothesis, the most probable first.
    blind : tuple of str
        Listed effects that these poses cannot see.
    unavailable : dict
        Listed effects that could not be evaluated, and why.
    p_value : float
        Whether the poses' own noise explains the residual.
    """

    verdict: str
    name: str | None
    group: tuple[str, ...]
    partner: str | None
    says: str
    advice: Advice | None
    ranking: tuple[Candidate, ...]
    blind: tuple[str, ...]
    unavailable: dict[str, str]
    p_value: float

    @property
    def addable(self) -> bool:
        """Whether the verdict names one effect that can be added as it is."""
        return self.verdict == "effect" and len(self.group) == 1

    @property
    def follows(self) -> str | None:
        """The covariate that the misfit follows best, whatever its physics; None where none."""
        unknown = [c for c in self.ranking if c.kind == "unknown"]
        best = max(unknown, key=lambda c: c.log_evidence, default=None)
        return best.name if best is not None and best.log_evidence > FOLLOWS_EVIDENCE else None

    @property
    def record_next(self) -> str | None:
        """What to record next, in words."""
        return None if self.advice is None else self.advice.says


def diagnose(fit: Fit, own: Sequence[Effect] = (), full_scale: float = np.inf) -> Diagnosis:
    """Diagnose ``fit``; ``own`` are users' effects, weighed with the listed ones.

    ``full_scale`` of the triad, SI, keeps what to record next to what the sensor can measure.
    """
    projector = Projector(fit)
    weighed = weigh(fit, projector, own)
    log_p = log_posterior(weighed)
    p_value = judge(fit).p_value
    if not is_nothing(log_p, p_value):
        weighed = refitted(fit, weighed)
        log_p = log_posterior(weighed)
    every, ranking = rank(fit, projector, weighed, log_p)
    verdict = Judge(fit, every, ranking, log_p, p_value, own).reach()
    advice = _advise(fit, verdict, every, ranking, full_scale)
    return Diagnosis(
        verdict=verdict.code,
        name=verdict.name,
        group=verdict.group,
        partner=verdict.partner,
        says=put_into_words(fit, verdict, ranking, p_value, advice),
        advice=advice,
        ranking=ranking,
        blind=weighed.blind,
        unavailable=weighed.unavailable,
        p_value=p_value,
    )


def _advise(
    fit: Fit,
    verdict: Verdict,
    every: Sequence[Hypothesis],
    ranking: Sequence[Candidate],
    full_scale: float,
) -> Advice | None:
    """The block that would settle an open verdict."""
    open_names = verdict.group if len(verdict.group) > 1 or verdict.code == "ambiguous" else ()
    size = {c.name: c.size for c in ranking if c.kind == "listed"}
    rivals = [
        Rival(h.effect, size[h.name], h.shape)
        for h in every
        if h.kind == "listed" and h.name in open_names and h.effect is not None
    ]
    return best_block(fit, rivals[:RIVALS_COMPARED], full_scale) if rivals else None
