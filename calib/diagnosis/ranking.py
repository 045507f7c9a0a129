"""The ranking: every hypothesis with its probability and what adding it would do."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from calib.diagnosis.hypotheses import Hypothesis, Weighed
from calib.diagnosis.signature import Projector, Signature, are_aliases, contains
from calib.fit.leave_one_out import compare
from calib.fit.result import Fit
from calib.poses.imu_log import FloatArray

SEEN_SHARE = 1e-3
"""Of the best seen combination of parameters; those seen less have no size of their own."""

PRIOR_NONE, PRIOR_LISTED, PRIOR_UNKNOWN, PRIOR_GENERAL = 0.5, 0.35, 0.09, 0.02


@dataclass(frozen=True, eq=False)
class Candidate:
    """One hypothesis in the ranking.

    ``size`` and ``sd`` (k,) of its parameters, ``chi2_drop``, what adding it takes off chi-square,
    and ``rms_after`` and ``loo_after``, the errors left, SI, are those of the joint refit where
    one was made, and predicted from the score otherwise; ``p_value`` is that of the score test.
    ``aliases`` look the same in these poses.
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
    blind: bool
    aliases: tuple[str, ...]


def log_posterior(weighed: Weighed) -> dict[str, float]:
    """Log probability of every hypothesis, "none" among them; unknown names carry a ``~``."""
    score = {"none": np.log(PRIOR_NONE)}
    shares = ((PRIOR_LISTED, weighed.listed), (PRIOR_UNKNOWN, weighed.unknown))
    for share, hypotheses in shares:
        for h in hypotheses:
            score[key_of(h)] = np.log(share / len(hypotheses)) + h.log_evidence
    for h in weighed.general:
        score[key_of(h)] = np.log(PRIOR_GENERAL) + h.log_evidence
    top = max(score.values())
    total = top + np.log(sum(np.exp(v - top) for v in score.values()))
    return {key: float(value - total) for key, value in score.items()}


def key_of(hypothesis: Hypothesis) -> str:
    """Name of a hypothesis among all; an unknown function of NAME is ``~NAME``."""
    return f"~{hypothesis.name}" if hypothesis.kind == "unknown" else hypothesis.name


def _alias_names(of: Hypothesis, listed: Sequence[Hypothesis]) -> tuple[str, ...]:
    """Effects that look the same in these poses.

    An error of the reference is the common part of an error of the sensor: where an effect of the
    sensor holds all of it, equal sizes on all axes would be the same.
    """
    assert of.effect is not None
    assert of.signature is not None
    is_reference = of.effect.acts_on == "reference"
    found = []
    for h in listed:
        if h.name == of.name or h.signature is None:
            continue
        if are_aliases(of.signature, h.signature) or (
            is_reference and contains(h.signature, of.signature)
        ):
            found.append(h.name)
    return tuple(found)


def _predicted(signature: Signature, projector: Projector) -> tuple[FloatArray, FloatArray]:
    """Size and sd of the parameters that the residual asks for, each (k,)."""
    columns = np.zeros((len(projector.residual), signature.columns.shape[1]))
    columns[: len(signature.columns)] = signature.columns
    columns *= projector.root[:, None]
    norm = np.maximum(np.sqrt((columns**2).sum(axis=0)), 1e-300)
    left = projector(columns / norm)
    covariance = np.linalg.pinv(left.T @ left, rcond=SEEN_SHARE**2, hermitian=True)
    size = covariance @ (left.T @ projector.residual)
    return size / norm, np.sqrt(np.diag(covariance)) / norm


def _after(fit: Fit, projector: Projector, signature: Signature) -> tuple[float, float, float]:
    """Chi-square drop, RMS and leave-one-out RMS (SI) when the signature is projected out too.

    The errors are NaN where the signature leaves no degree of freedom.
    """
    amplitude = signature.basis.T @ projector.residual
    drop = float(amplitude @ amplitude)
    if signature.seen >= projector.dof:  # it passes through every row, and says nothing by that
        return drop, float("nan"), float("nan")
    left = projector.residual - signature.basis @ amplitude
    d, sd = projector.data_count, fit.equations.row_sd
    leverage = (projector.model[:d] ** 2).sum(axis=1) + (signature.basis[:d] ** 2).sum(axis=1)
    out = left[:d] / np.maximum(1 - leverage, 1e-3)
    rms = float(np.sqrt(np.mean((left[:d] * sd) ** 2)))
    return drop, rms, float(np.sqrt(np.mean((out * sd) ** 2)))


def _candidate(
    fit: Fit,
    projector: Projector,
    h: Hypothesis,
    probability: float,
    aliases: tuple[str, ...],
    left_out: float,
) -> Candidate:
    nothing = np.zeros(0)
    size, sd, unit = nothing, nothing, ""
    drop, rms, loo, p_value = 0.0, fit.residual_rms, left_out, 1.0
    if h.signature is not None and not h.signature.is_blind:
        drop, rms, loo = _after(fit, projector, h.signature)
        p_value = float(chdtrc(h.signature.seen, drop))
        if h.effect is not None:
            size, sd = _predicted(h.signature, projector)
            unit = h.effect.unit_for(fit.poses.triad)
    if h.after is not None:
        where = h.after.model.slices()[h.name]
        size, sd = h.after.theta[where], np.sqrt(np.diag(h.after.cov)[where])
        drop, rms = fit.chi2 - h.after.chi2, h.after.residual_rms
        loo = compare(h.after).loo_rms
    return Candidate(
        name=h.name,
        kind=h.kind,
        log_evidence=h.log_evidence,
        probability=probability,
        chi2_drop=drop,
        size=size,
        sd=sd,
        unit=unit,
        rms_after=rms,
        loo_after=loo,
        p_value=p_value,
        blind=False,
        aliases=aliases,
    )


def rank(
    fit: Fit, projector: Projector, weighed: Weighed, log_p: dict[str, float]
) -> tuple[list[Hypothesis], tuple[Candidate, ...]]:
    """All hypotheses and their candidates, the most probable first."""
    every = sorted(
        (*weighed.listed, *weighed.unknown, *weighed.general), key=lambda h: -log_p[key_of(h)]
    )
    left_out = compare(fit).loo_rms
    candidates = tuple(
        _candidate(
            fit,
            projector,
            h,
            float(np.exp(log_p[key_of(h)])),
            _alias_names(h, weighed.listed) if h.kind == "listed" else (),
            left_out,
        )
        for h in every
    )
    return every, candidates
