"""The leading candidates judged by a joint refit, single and in pairs.

Scores before the refit also accuse innocent effects, the more so the stronger the missing one is,
and two effects at once read as one wrong one. Here everything is fitted jointly, nonlinearly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from calib.compare import compare
from calib.errors import CalibrationError
from calib.hypotheses import Hypothesis, weigh
from calib.signature import Projector
from calib.solver import Fit, fit

SINGLES, PAIRED = 6, 4
FOLLOWED, SECONDS = 2, 2
"""So many of the best singles are each followed by so many that explain what they leave."""

SHAPED = 2
"""So many of the best refits get their shape parameters fitted; farther down none can win by it."""

ADEQUATE_P_VALUE = 0.005
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

    @property
    def loo_rms(self) -> float:
        """Leave-one-out error of the refitted model, SI."""
        return compare(self.fit).loo_rms


def judge(found: Fit, names: tuple[str, ...]) -> Refit:
    """Score a fit; see :class:`Refit`."""
    n = found.equations.data_count
    parameters = n - found.dof
    scatter = max(1.0, found.chi2 / max(found.dof, 1))
    score = found.chi2 / scatter + n * np.log(scatter) + parameters * np.log(n)
    p_value = float(fdtrc(found.dof, found.poses.noise_dof, found.chi2 / found.dof))
    return Refit(names, found, float(score), p_value)


def parameters_of(hypothesis: Hypothesis) -> int:
    """Parameters that a fit with this listed effect has more, as far as these poses see them."""
    assert hypothesis.signature is not None
    return hypothesis.signature.seen + (0 if hypothesis.shape is None else 1)


def _refit(base: Fit, chosen: Sequence[Hypothesis], held: bool = False) -> Refit | None:
    """``chosen`` added and everything refitted; None where that is no candidate.

    ``held`` keeps a shape parameter at the best of its starts, which takes a twentieth of the time.
    """
    if base.dof - sum(map(parameters_of, chosen)) < FEWEST_DOF:
        return None
    model = base.model
    for hypothesis in chosen:
        assert hypothesis.effect is not None
        effect, shape = hypothesis.effect, hypothesis.shape
        model = model + (effect.at_shape(shape) if held and shape is not None else effect)
    try:
        found = fit(base.poses, model, robust=base.is_robust)
    except CalibrationError:
        return None  # not determined together, or no true vector exists: no candidate
    if found.dof < FEWEST_DOF:
        return None
    return judge(found, tuple(hypothesis.name for hypothesis in chosen))


def _refits(base: Fit, tried: Sequence[Sequence[Hypothesis]]) -> list[Refit]:
    """Refits of ``tried``, best score first; shape parameters are fitted where it matters."""
    found = [(chosen, _refit(base, chosen, held=True)) for chosen in tried]
    judged = [(chosen, refit) for chosen, refit in found if refit is not None]
    judged.sort(key=lambda item: item[1].score)
    refits = []
    for place, (chosen, refit) in enumerate(judged):
        shaped = any(hypothesis.shape is not None for hypothesis in chosen)
        refits.append(_refit(base, chosen) if shaped and place < SHAPED else refit)
    return sorted((r for r in refits if r is not None), key=lambda r: r.score)


def refit_singles(base: Fit, leading: Sequence[Hypothesis]) -> list[Refit]:
    """Each of the leading candidates added on its own, best score first."""
    return _refits(base, [(hypothesis,) for hypothesis in leading[:SINGLES]])


def refit_pairs(base: Fit, leading: Sequence[Hypothesis], singles: Sequence[Refit]) -> list[Refit]:
    """The best singles added in pairs, and with what best explains the rest, best score first.

    An effect that another one hides scores nothing on its own; it shows once that one is fitted.
    """
    by_name = {hypothesis.name: hypothesis for hypothesis in leading}
    best = [by_name[refit.names[0]] for refit in singles[:PAIRED]]
    pairs = {frozenset((a.name, b.name)): (a, b) for a, b in combinations(best, 2)}
    for refit in singles[:FOLLOWED]:
        listed = weigh(refit.fit, Projector(refit.fit)).listed
        first = by_name[refit.names[0]]
        for h in sorted(listed, key=lambda h: -h.log_evidence)[:SECONDS]:
            if h.name in by_name:
                pairs.setdefault(frozenset((first.name, h.name)), (first, by_name[h.name]))
    return _refits(base, list(pairs.values()))
