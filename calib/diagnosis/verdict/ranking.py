"""The ranking: every hypothesis by its probability, with what adding it alone would do."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from calib.diagnosis.search.classes import aliases
from calib.diagnosis.search.odds import Odds
from calib.diagnosis.search.refit import Refit, linear_loo_rms
from calib.diagnosis.search.sets import Search
from calib.diagnosis.search.sizes import predicted_size
from calib.poses.imu_log import FloatArray

LEAST_LEFT = 1e-3
"""Floor of what a row keeps for itself after the fit. Numerical."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One hypothesis in the ranking.

    Attributes
    ----------
    name : str
        The effect, or the kind; of an unknown function what it follows.
    kind : str
        That of its hypothesis, or ``noise``.
    log_evidence : float
        Log Bayes factor of the name alone against nothing.
    probability : float
        Of being missing.
    chi2_drop, rms_after, loo_after : float
        What adding it alone does, errors in SI: at its refit where one was made, predicted from the
        score otherwise.
    size, sd : array, shape (k,)
        Its parameters, those of the leading set's joint refit where it is a member.
    unit : str
        Of the parameters, SI.
    p_value : float
        Of the score test.
    aliases : tuple of str
        What looks the same in these poses.
    follows : str or None
        What an unknown function is a function of.
    """

    name: str
    kind: str
    log_evidence: float
    probability: float
    chi2_drop: float
    size: FloatArray
    sd: FloatArray
    unit: str
    rms_after: float
    loo_after: float
    p_value: float
    aliases: tuple[str, ...]
    follows: str | None = None


def rank(state: Search, odds: Odds) -> tuple[Candidate, ...]:
    """One candidate for every name, the most probable first."""
    by_name: dict[str, list[int]] = {}
    for j, h in enumerate(state.hypotheses):
        by_name.setdefault(h.name, []).append(j)
    seen = {name: [j for j in which if not state.table.is_blind(j)]
            for name, which in by_name.items()}
    best = {name: max(which, key=lambda j: state.alone.log_factor[j])
            for name, which in seen.items() if which}
    probability = {each.name: each.probability for each in odds.others}
    for inclusion in odds.classes:
        probability |= dict.fromkeys(inclusion.members[1:], inclusion.probability)
        probability[inclusion.name] = inclusion.probability
    candidates = [_candidate(state, odds, j, by_name[name], probability.get(name, 0.0))
                  for name, j in best.items()]
    candidates.append(_noise(state, odds))
    lead = [state.hypotheses[j].name for j in odds.lead.members]
    candidates.sort(key=lambda c: (-c.probability, c.name not in lead, -c.log_evidence))
    return tuple(candidates)


def _noise(state: Search, odds: Odds) -> Candidate:
    nothing = np.zeros(0)
    evidence = state.nothing[1] - state.nothing[0]
    return Candidate("noise", "noise", evidence, odds.noise, 0.0, nothing, nothing, "",
                     state.base.residual_rms, linear_loo_rms(state.base), 1.0, ())


def _candidate(
    state: Search, odds: Odds, j: int, alike: Sequence[int], probability: float
) -> Candidate:
    """Of hypothesis ``j``, the best of those ``alike``, which have its name."""
    h = state.hypotheses[j]
    size, sd, unit = np.zeros(0), np.zeros(0), ""
    if h.kind == "listed":
        assert h.effect is not None
        if not h.effect.in_square:
            size, sd = predicted_size(state.table, j)
        unit = h.effect.unit_for(state.base.poses.triad)
    drop, rms, loo = _after(state, j)
    p_value = float(chdtrc(int(state.table.seen[j]), drop))
    alone = state.entries.get(state.key([j]))
    if alone is not None and alone.refit is not None and alone.whole:
        fit = alone.refit.fit
        drop, rms = _drop(state, alone.refit), fit.residual_rms
        loo = linear_loo_rms(fit)
        if h.kind == "listed":
            size, sd = _fitted(alone.refit, h.name)
    lead = odds.lead.refit
    if h.kind == "listed" and lead is not None and h.name in lead.names:
        size, sd = _fitted(lead, h.name)
    same = aliases(state, state.table, j, _others(state, h.name), ()) if h.kind == "listed" else []
    return Candidate(
        name=h.subject,
        kind=h.kind,
        log_evidence=_evidence(state, alike),
        probability=probability,
        chi2_drop=drop,
        size=size,
        sd=sd,
        unit=unit,
        rms_after=rms,
        loo_after=loo,
        p_value=p_value,
        aliases=tuple(dict.fromkeys(state.hypotheses[k].name for k in same)),
        follows=h.follows,
    )


def _others(state: Search, name: str) -> list[int]:
    """The listed hypotheses of other names."""
    return [k for k, h in enumerate(state.hypotheses) if h.kind == "listed" and h.name != name]


def _evidence(state: Search, which: Sequence[int]) -> float:
    """Log Bayes factor of a name alone against nothing, averaged over its shapes and forms."""
    factors = state.alone.log_factor[which]
    if len({state.key([j]) for j in which}) == 1:
        alone = state.entries.get(state.key(which[:1]))
        if alone is not None and alone.whole:
            prior = float(np.logaddexp.reduce([state.hypotheses[j].log_prior for j in which]))
            return alone.log_posterior - prior - float(np.logaddexp(*state.nothing))
    return float(np.logaddexp.reduce(factors) - np.log(len(factors)))


def _drop(state: Search, refit: Refit) -> float:
    fit = refit.fit
    before, after = (float(f.weight @ f.rows.residual**2) for f in (state.base, fit))
    return before - after


def _fitted(refit: Refit, name: str) -> tuple[FloatArray, FloatArray]:
    where = refit.fit.model.slices()[name]
    return refit.fit.theta[where], np.sqrt(np.diag(refit.fit.cov)[where])


def _after(state: Search, j: int) -> tuple[float, float, float]:
    """Chi-square drop, RMS and leave-one-out RMS (SI) when a hypothesis is projected out too.

    The errors are NaN where it leaves no degree of freedom.
    """
    table, fit = state.table, state.base
    q = table.unit_rows[table.where(j)].T
    amplitude = q.T @ table.residual
    drop = float(amplitude @ amplitude)
    if q.shape[1] >= table.dof:  # it passes through every row, and says nothing by that
        return drop, float("nan"), float("nan")
    rest = table.residual - q @ amplitude
    d, sd = table.projector.data_count, fit.equations.row_sd
    leverage = state.leverage[:d] + (q[:d] ** 2).sum(axis=1)
    out = rest[:d] / np.maximum(1 - leverage, LEAST_LEFT)
    rms, loo = (float(np.linalg.norm(each * sd) / np.sqrt(d)) for each in (rest[:d], out))
    return drop, rms, loo


def names_of(candidates: Sequence[Candidate], kind: str) -> list[str]:
    """Names of the candidates of one kind, the most probable first."""
    return [c.name for c in candidates if c.kind == kind]
