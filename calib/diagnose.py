"""What is missing: the verdict on one fit.

First whether anything is: chi-square against the poses' own noise. Then every hypothesis of
:mod:`calib.hypotheses` is ranked by its evidence, effects that these poses cannot see or cannot
tell apart are named as such, the leading ones are judged by a joint refit, and the answer is put
into words.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import chdtrc

from calib.compare import compare
from calib.effects import Effect
from calib.hypotheses import Hypothesis, Weighed, weigh
from calib.imu_log import FloatArray
from calib.refit import ADEQUATE_P_VALUE, Refit, judge, refit_pairs, refit_singles
from calib.signature import Projector, Signature, are_aliases, contains
from calib.solver import Fit

PRIOR_NONE, PRIOR_LISTED, PRIOR_UNKNOWN, PRIOR_GENERAL = 0.5, 0.35, 0.09, 0.02
MISFIT_P_VALUE = 1e-3
SURE = 0.9
CREDIBLE = 0.95
STRONG = 4.0
"""Above this chi-square per degree of freedom the columns, linearised at a biased fit, mislead."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One hypothesis in the ranking, judged without a refit.

    ``size`` and ``sd`` (k,) are predicted for its parameters; ``chi2_drop`` is what adding it
    would take off chi-square, ``p_value`` that of the score test, ``rms_after`` and ``loo_after``
    the errors left, SI. ``aliases`` look the same in these poses.
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


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The verdict on a fit.

    ``verdict`` is one of nothing_missing, effect, ambiguous, unknown, bad_pose, noise; ``name``
    the effect, column or pose it speaks of, ``group`` everything that cannot be told from it,
    ``rivals`` what an ambiguous verdict leaves open, ``partner`` a second effect found together
    with the first.
    """

    verdict: str
    name: str | None
    group: tuple[str, ...]
    ranking: tuple[Candidate, ...]
    blind: tuple[str, ...]
    unavailable: dict[str, str]
    p_value: float
    detail: str = ""
    partner: str | None = None
    after: Refit | None = field(default=None, repr=False)

    @property
    def addable(self) -> bool:
        """Whether the verdict names one effect that can be added as it is."""
        return self.verdict == "effect" and len(self.group) == 1


def _log_posterior(weighed: Weighed) -> dict[str, float]:
    """Log probability of every hypothesis, "none" among them; unknown names carry a ``~``."""
    score = {"none": np.log(PRIOR_NONE)}
    shares = ((PRIOR_LISTED, weighed.listed), (PRIOR_UNKNOWN, weighed.unknown))
    for share, hypotheses in shares:
        for h in hypotheses:
            score[_key(h)] = np.log(share / len(hypotheses)) + h.log_evidence
    for h in weighed.general:
        score[_key(h)] = np.log(PRIOR_GENERAL) + h.log_evidence
    top = max(score.values())
    total = top + np.log(sum(np.exp(v - top) for v in score.values()))
    return {key: float(value - total) for key, value in score.items()}


def _key(hypothesis: Hypothesis) -> str:
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
    inverse = np.linalg.pinv(left, rcond=1e-3)
    return inverse @ projector.residual / norm, np.sqrt((inverse**2).sum(axis=1)) / norm


def _after(fit: Fit, projector: Projector, signature: Signature) -> tuple[float, float, float]:
    """Chi-square drop, RMS and leave-one-out RMS (SI) when the signature is projected out too."""
    amplitude = signature.basis.T @ projector.residual
    left = projector.residual - signature.basis @ amplitude
    d, sd = projector.data_count, fit.equations.row_sd
    leverage = (projector.model[:d] ** 2).sum(axis=1) + (signature.basis[:d] ** 2).sum(axis=1)
    out = left[:d] / np.maximum(1 - leverage, 1e-3)
    rms = float(np.sqrt(np.mean((left[:d] * sd) ** 2)))
    return float(amplitude @ amplitude), rms, float(np.sqrt(np.mean((out * sd) ** 2)))


def _candidate(
    fit: Fit, projector: Projector, h: Hypothesis, probability: float, aliases: tuple[str, ...]
) -> Candidate:
    nothing = np.zeros(0)
    size, sd, unit = nothing, nothing, ""
    drop, rms, loo, p_value = 0.0, fit.residual_rms, compare(fit).loo_rms, 1.0
    if h.signature is not None and not h.signature.is_blind:
        drop, rms, loo = _after(fit, projector, h.signature)
        p_value = float(chdtrc(h.signature.seen, drop))
        if h.effect is not None:
            size, sd = _predicted(h.signature, projector)
            unit = h.effect.unit_for(fit.poses.triad)
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


def diagnose(fit: Fit, own: Sequence[Effect] = ()) -> Diagnosis:
    """What the model of ``fit`` is missing; ``own`` are users' effects to weigh with the listed.

    Returns
    -------
    Diagnosis
        The verdict with the full ranking, best first.
    """
    projector = Projector(fit)
    weighed = weigh(fit, projector, own)
    log_p = _log_posterior(weighed)
    every = sorted(
        (*weighed.listed, *weighed.unknown, *weighed.general), key=lambda h: -log_p[_key(h)]
    )
    ranking = tuple(
        _candidate(
            fit,
            projector,
            h,
            float(np.exp(log_p[_key(h)])),
            _alias_names(h, weighed.listed) if h.kind == "listed" else (),
        )
        for h in every
    )
    base = judge(fit, ())
    verdict = _Verdict(fit, weighed, every, ranking, log_p, base.p_value)
    kind, name, group, detail, partner, after = verdict.reach()
    return Diagnosis(
        verdict=kind,
        name=name,
        group=group,
        ranking=ranking,
        blind=weighed.blind,
        unavailable=weighed.unavailable,
        p_value=base.p_value,
        detail=detail,
        partner=partner,
        after=after,
    )


Reached = tuple[str, str | None, tuple[str, ...], str, str | None, Refit | None]
NOTHING: Reached = ("nothing_missing", None, (), "", None, None)


@dataclass(frozen=True, eq=False)
class _Verdict:
    """Decides on one ranking; see the module's docstring for the order of the questions."""

    fit: Fit
    weighed: Weighed
    every: Sequence[Hypothesis]
    ranking: Sequence[Candidate]
    log_p: dict[str, float]
    p_value: float

    def reach(self) -> Reached:
        none = float(np.exp(self.log_p["none"]))
        if (none >= PRIOR_NONE and self.p_value > MISFIT_P_VALUE) or (
            none > 1 - CREDIBLE and none == max(np.exp(v) for v in self.log_p.values())
        ):
            return NOTHING
        top = self.every[0]
        strong = self.fit.chi2 > STRONG * self.fit.dof
        if top.kind == "listed" or strong:
            judged = self._by_refit()
            if judged is not None:
                return judged
        if top.kind == "listed":
            return self._by_evidence(top, none)
        if top.kind in ("unknown", "jump"):
            return self._unknown(top, none)
        return (top.kind, None, (), top.detail, None, None)

    def _group(self, name: str) -> tuple[str, ...]:
        aliases = next(c.aliases for c in self.ranking if c.name == name and c.kind == "listed")
        return (name, *aliases)

    def _by_evidence(self, top: Hypothesis, none: float) -> Reached:
        group = self._group(top.name)
        mass = sum(float(np.exp(self.log_p[name])) for name in group)
        if mass >= SURE * (1 - none) and none < 1 - SURE:
            return ("effect", top.name, group, "", None, None)
        return ("ambiguous", None, self._credible(none), "", None, None)

    def _credible(self, none: float) -> tuple[str, ...]:
        """The smallest set of hypotheses that holds most of what is not "nothing"."""
        names, mass = [], 0.0
        for h in self.every:
            names.append(_key(h))
            mass += float(np.exp(self.log_p[_key(h)]))
            if mass >= CREDIBLE * (1 - none):
                break
        return tuple(names)

    def _unknown(self, top: Hypothesis, none: float) -> Reached:
        probability = float(np.exp(self.log_p[_key(top)]))
        if probability >= 0.5 * (1 - none):
            return ("unknown", top.name, (), top.detail, None, None)
        return ("ambiguous", None, self._credible(none), "", None, None)

    def _by_refit(self) -> Reached | None:
        """The verdict by joint refits of the leading listed effects, None where undecided."""
        leading = [h for h in self.every if h.kind == "listed"]
        singles = refit_singles(self.fit, leading)
        if not singles:
            return None
        best = singles[0]
        partner = None
        if best.p_value < ADEQUATE_P_VALUE:
            pairs = refit_pairs(self.fit, leading, singles)
            if pairs and pairs[0].score < best.score - 2 * np.log(SURE / (1 - SURE)):
                best, partner = self._stronger_of(pairs[0], singles)
        if best.p_value < ADEQUATE_P_VALUE and self._unknown_wins():
            return None
        name = best.names[0]
        group = self._group(name)
        rivals = [r for r in singles if r.names[0] not in group and r.names[0] != partner]
        if partner is None and rivals:
            lead = 0.5 * (rivals[0].score - best.score)
            if lead < np.log(SURE / (1 - SURE)):
                return None
        return ("effect", name, group, "", partner, best)

    def _stronger_of(self, pair: Refit, singles: Sequence[Refit]) -> tuple[Refit, str]:
        """The member of a pair that explains more on its own comes first; the other is partner."""
        order = [r for r in singles if r.names[0] in pair.names]
        first, second = order[0], order[1]
        return first, second.names[0]

    def _unknown_wins(self) -> bool:
        """Whether a shape that no listed effect has explains more than any of them."""
        return self.every[0].kind != "listed"
