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
from calib.hypotheses import Hypothesis
from calib.solver import Fit, fit

SINGLES, PAIRED = 6, 4
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


def _refit(base: Fit, chosen: Sequence[Hypothesis]) -> Refit | None:
    model = base.model
    for hypothesis in chosen:
        assert hypothesis.effect is not None
        model = model + hypothesis.effect
    try:
        found = fit(base.poses, model, robust=base.is_robust)
    except CalibrationError:
        return None  # not determined together, or no true vector exists: no candidate
    if found.dof < FEWEST_DOF:
        return None
    return judge(found, tuple(hypothesis.name for hypothesis in chosen))


def refit_singles(base: Fit, leading: Sequence[Hypothesis]) -> list[Refit]:
    """Each of the leading candidates added on its own, best score first."""
    tried = (_refit(base, (hypothesis,)) for hypothesis in leading[:SINGLES])
    return sorted((r for r in tried if r is not None), key=lambda r: r.score)


def refit_pairs(base: Fit, leading: Sequence[Hypothesis], singles: Sequence[Refit]) -> list[Refit]:
    """The best singles added in pairs, best score first."""
    by_name = {hypothesis.name: hypothesis for hypothesis in leading}
    best = [by_name[refit.names[0]] for refit in singles[:PAIRED]]
    tried = (_refit(base, pair) for pair in combinations(best, 2))
    return sorted((r for r in tried if r is not None), key=lambda r: r.score)
