"""The leading candidates judged by a joint refit, single and in pairs.

Scores before the refit also accuse innocent effects, the more so the stronger the missing one is:
the columns are linearised at a fit that the missing effect has biased. Here everything is fitted
jointly, nonlinearly, and the evidence is asked for again at that solution. Two effects at once read
as one wrong one until they are fitted in pairs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from calib.diagnosis.hypotheses import Hypothesis, Weighed, listed_hypothesis, weigh
from calib.diagnosis.signature import Projector
from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.solver import Fit, fit

SINGLES, PAIRED = 6, 4
FOLLOWED, SECONDS = 2, 2
"""So many of the best singles are each followed by so many that explain what they leave."""

SHAPED = 3
"""So many of the best pairs with a shape parameter get it fitted; farther down none wins by it."""

BEHIND, BEHIND_SHARE = 3.0, 0.1
"""Log evidence behind the best, or share of it, beyond which no refit makes a candidate the best:
what the biased linearisation costs grows with the effect."""

FEWEST_DOF = 4
"""A model that leaves fewer degrees of freedom explains anything and is not trusted."""


@dataclass(frozen=True, eq=False)
class Refit:
    """One or two effects added and everything refitted.

    ``score`` is the Bayesian information criterion with the row scatter free above the stated
    noise (lower is better), ``p_value`` whether the refitted model explains the rows.
    """

    names: tuple[str, ...]
    fit: Fit
    score: float
    p_value: float


def judge(found: Fit, names: tuple[str, ...] = ()) -> Refit:
    """Score a fit; see :class:`Refit`."""
    n = found.equations.data_count
    parameters = n - found.dof
    scatter = max(1.0, found.chi2 / max(found.dof, 1))
    score = found.chi2 / scatter + n * np.log(scatter) + parameters * np.log(n)
    return Refit(names, found, float(score), found.p_value)


def parameters_of(hypothesis: Hypothesis) -> int:
    """Parameters that a fit with this listed effect has more, as far as these poses see them."""
    assert hypothesis.signature is not None
    return hypothesis.signature.seen + (0 if hypothesis.shape is None else 1)


def _fit_with(base: Fit, chosen: Sequence[Hypothesis], held: bool = False) -> Fit | None:
    """``chosen`` added and everything refitted; None where that is no candidate.

    ``held`` keeps a shape parameter at the best of its starts, which takes a tenth of the time.
    """
    if base.dof - sum(map(parameters_of, chosen)) < FEWEST_DOF:
        return None
    model = base.model
    for hypothesis in chosen:
        assert hypothesis.effect is not None
        effect, shape = hypothesis.effect, hypothesis.shape
        if shape is not None:
            effect = effect.at_shape(shape) if held else effect.from_shape(shape)
        model = model + effect
    try:
        found = fit(base.poses, model, robust=base.is_robust)
    except CalibrationError:
        return None  # not determined together, or no true vector exists: no candidate
    return found if found.dof >= FEWEST_DOF else None


def _leading(listed: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The listed hypotheses that could be the best after a refit, the best first."""
    order = sorted(listed, key=lambda h: -h.log_evidence)
    if not order:
        return []
    best = order[0].log_evidence
    return [h for h in order if h.log_evidence > best - max(BEHIND, BEHIND_SHARE * best)][:SINGLES]


def _at_refit(base: Fit, hypothesis: Hypothesis) -> Hypothesis:
    """``hypothesis`` with its evidence at the joint refit instead of at the biased base fit."""
    assert hypothesis.effect is not None
    found = _fit_with(base, (hypothesis,), held=True)
    if found is None:
        return hypothesis
    at_refit = Projector(found, hypothesis.name)
    again = listed_hypothesis(found, at_refit, hypothesis.effect)
    # "Nothing" leaves another chi-square along these columns than where it was fitted.
    nothing = (Projector(base).chi2 - at_refit.chi2) / 2
    evidence = again.log_evidence + nothing
    return replace(hypothesis, log_evidence=evidence, shape=again.shape, after=found)


def refitted(base: Fit, weighed: Weighed) -> Weighed:
    """``weighed`` with the leading listed effects judged at their joint refits.

    A shape parameter is held at its likeliest start for that, and fitted for the best alone.
    """
    leading = {h.name for h in _leading(weighed.listed)}
    listed = [_at_refit(base, h) if h.name in leading else h for h in weighed.listed]
    best = max(listed, key=lambda h: h.log_evidence, default=None)
    if best is not None and best.after is not None and best.shape is not None:
        listed[listed.index(best)] = replace(best, after=_fit_with(base, (best,)) or best.after)
    return replace(weighed, listed=tuple(listed))


def refit_pairs(
    base: Fit, singles: Sequence[Hypothesis], own: Sequence[Effect] = ()
) -> list[Refit]:
    """The refitted ``singles``, best first, in pairs and with what best explains what they leave.

    An effect that another one hides scores nothing on its own; it shows once that one is fitted.
    The best score comes first.
    """
    pairs = {frozenset((a.name, b.name)): (a, b) for a, b in combinations(singles[:PAIRED], 2)}
    for first in singles[:FOLLOWED]:
        assert first.after is not None
        listed = weigh(first.after, Projector(first.after), own).listed
        for h in sorted(listed, key=lambda h: -h.log_evidence)[:SECONDS]:
            pairs.setdefault(frozenset((first.name, h.name)), (first, h))
    held = [(pair, _fit_with(base, pair, held=True)) for pair in pairs.values()]
    judged = [(pair, judge(found, _names(pair))) for pair, found in held if found is not None]
    judged.sort(key=lambda item: item[1].score)
    shaped = [i for i, (pair, _) in enumerate(judged) if any(h.shape is not None for h in pair)]
    for place in shaped[:SHAPED]:
        pair, _ = judged[place]
        whole = _fit_with(base, pair)
        if whole is not None:
            judged[place] = pair, judge(whole, _names(pair))
    return sorted((refit for _, refit in judged), key=lambda refit: refit.score)


def _names(pair: Sequence[Hypothesis]) -> tuple[str, ...]:
    return tuple(hypothesis.name for hypothesis in pair)
