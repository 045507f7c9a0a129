"""The ranking: every hypothesis by its probability, with what adding it alone would do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from calib.diagnosis.hypotheses.listed import held
from calib.diagnosis.search.entry import Entry
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.refit import Refit, linear_loo_rms
from calib.diagnosis.search.table import Table
from calib.effects.effect import EFFECTS
from calib.fit.triad.calibration import covariance_with_misfit
from calib.poses.imu_log import FloatArray

SEEN_SHARE = 1e-3
"""Share of the best seen combination of parameters; those seen less have no size of their own. A
judgement."""

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
        Its parameters, the sds with the misfit that is left, as a calibration has them: by the
        refit with what the verdict names where it is among that, else by the leading set's where it
        is a member, else by its own.
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


def rank(posterior: Posterior, named: Refit | None = None) -> tuple[Candidate, ...]:
    """One candidate for every name, the most probable first.

    ``named`` is the refit with exactly what the verdict names: the sizes of these are its own, as
    the page and ``add`` have them.
    """
    by_name: dict[str, list[int]] = {}
    for j, h in enumerate(posterior.hypotheses):
        if not posterior.table.is_blind(j):
            by_name.setdefault(h.name, []).append(j)
    best = {name: max(which, key=lambda j: posterior.log_factor[j])
            for name, which in by_name.items()}
    probability = {each.name: each.probability for each in posterior.others}
    for inclusion in posterior.classes:
        probability |= dict.fromkeys(inclusion.members[1:], inclusion.probability)
        probability[inclusion.name] = inclusion.probability
    whole = {e.members[0]: e for e in posterior.entries if len(e.members) == 1 and e.refit}
    leverage = np.asarray((posterior.table.projector.model**2).sum(axis=1))
    candidates = [
        _candidate(posterior, j, by_name[name], probability.get(name, 0.0), leverage,
                   _by_itself(posterior, whole, j, by_name[name]), named)
        for name, j in best.items()
    ]
    candidates.append(_noise(posterior))
    lead = posterior.names(posterior.lead)
    candidates.sort(key=lambda c: (-c.probability, c.name not in lead, -c.log_evidence))
    return tuple(candidates)


def _by_itself(
    posterior: Posterior, whole: Mapping[int, Entry], j: int, of_name: Sequence[int]
) -> Refit | None:
    """The refit with hypothesis ``j`` alone: of an effect from whichever start of its shape, but of
    a step or a pose only where it is this one."""
    if j in whole or posterior.hypotheses[j].is_placed:
        return whole[j].refit if j in whole else None
    return next((whole[k].refit for k in of_name if k in whole), None)


def _noise(posterior: Posterior) -> Candidate:
    nothing, base = np.zeros(0), posterior.base
    stated, larger = posterior.log_nothing
    return Candidate("noise", "noise", larger - stated, posterior.noise, 0.0, nothing, nothing, "",
                     base.residual_rms, linear_loo_rms(base), 1.0, ())


def _candidate(
    posterior: Posterior, j: int, of_name: Sequence[int], probability: float,
    leverage: FloatArray, alone: Refit | None, named: Refit | None,
) -> Candidate:
    """The candidate of hypothesis ``j``, the best of those ``of_name``; ``alone`` is its refit by
    itself, ``named`` that of the verdict."""
    h, table = posterior.hypotheses[j], posterior.table
    size, sd, unit = np.zeros(0), np.zeros(0), ""
    same: list[int] = []
    if h.kind == "listed":
        assert h.effect is not None
        if not h.effect.in_square:
            size, sd = _predicted_size(table, j)
        unit = h.effect.unit_for(posterior.base.poses.triad)
        same = table.aliases(j, [k for k, other in enumerate(posterior.hypotheses)
                                 if other.kind == "listed" and other.name != h.name])
    drop, rms, loo = _after(posterior, j, leverage)
    p_value = float(chdtrc(int(table.seen[j]), drop))
    if alone is not None:
        fit = alone.fit
        drop, rms, loo = _drop(posterior, alone), fit.residual_rms, linear_loo_rms(fit)
    joint = [one for one in (named, posterior.lead.refit, alone) if one is not None]
    inside = next((m for m in posterior.lead.members if posterior.hypotheses[m].name == h.name), j)
    fitted_as = held(posterior.hypotheses[inside], inside).name if h.effect is not None else h.name
    fitted = next((one for one in joint if fitted_as in one.names), None)
    if h.kind == "listed" and fitted is not None:
        size, sd = _fitted(fitted, fitted_as)
    shown = len(EFFECTS[h.name].parameters) if h.name in EFFECTS else None
    factors = posterior.log_factor[of_name]
    return Candidate(
        name=h.subject,
        kind=h.kind,
        log_evidence=float(np.logaddexp.reduce(factors) - np.log(len(factors))),
        probability=probability,
        chi2_drop=drop,
        size=size[:shown],
        sd=sd[:shown],
        unit=unit,
        rms_after=rms,
        loo_after=loo,
        p_value=p_value,
        aliases=tuple(dict.fromkeys(posterior.hypotheses[k].name for k in same)),
        follows=h.follows,
    )


def _predicted_size(table: Table, j: int) -> tuple[FloatArray, FloatArray]:
    """Size and sd of the parameters of ``j`` alone that the residual requires, SI, each (k,)."""
    each = table.spectra[j]
    seen = each.squared > SEEN_SHARE**2 * float(each.squared.max())
    turns, squared = each.turns[:, seen], each.squared[seen]
    size = turns @ (each.along[seen] / squared)
    return size * each.unit, np.sqrt((turns**2 / squared).sum(axis=1)) * each.unit


def _drop(posterior: Posterior, refit: Refit) -> float:
    before, after = (float(f.weight @ f.rows.residual**2) for f in (posterior.base, refit.fit))
    return before - after


def _fitted(refit: Refit, name: str) -> tuple[FloatArray, FloatArray]:
    where = refit.fit.model.slices()[name]
    return refit.fit.theta[where], np.sqrt(np.diag(covariance_with_misfit(refit.fit))[where])


def _after(posterior: Posterior, j: int, leverage: FloatArray) -> tuple[float, float, float]:
    """Chi-square drop, RMS and leave-one-out RMS (SI) when a hypothesis is projected out too.

    The errors are NaN where it leaves no degree of freedom; ``leverage`` (r,) is that of the base.
    """
    table, fit = posterior.table, posterior.base
    q = table.unit_block(j)
    amplitude = q.T @ table.residual
    drop = float(amplitude @ amplitude)
    if q.shape[1] >= table.dof:  # it passes through every row, and says nothing by that
        return drop, float("nan"), float("nan")
    rest = table.residual - q @ amplitude
    d, sd = table.projector.data_count, fit.equations.row_sd
    keeps = leverage[:d] + (q[:d] ** 2).sum(axis=1)
    out = rest[:d] / np.maximum(1 - keeps, LEAST_LEFT)
    rms, loo = (float(np.linalg.norm(each * sd) / np.sqrt(d)) for each in (rest[:d], out))
    return drop, rms, loo
