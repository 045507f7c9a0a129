"""What is missing in a lot: the evidence of all its sessions added up.

Two questions for every candidate, F ratios against what the rows of the sessions leave when the
candidate is fitted to each of them, so that sds which are all wrong by a factor name nothing:

    has it one size in all sensors?      (Σu)ᵀ (ΣI)⁻¹ (Σu),    k degrees of freedom
    has it any size in the sessions?     Σ uᵀ I⁻¹ u,            Σk degrees of freedom

The sds of a session come from ν degrees of freedom, s² = σ² x with x = χ²_ν/ν. A sum of its ratios
scatters like one of c = (ν - 4)/(ν - 2) times as many degrees of freedom; and in a sum that weighs
sessions by 1/s², as Σu does, those with small s count too much: its variance is 1/c times what the
rows leave (the moments of 1/x). A session that nothing explains (``WILD_P_VALUE``) counts with its
sds widened by the Birge ratio, as in its own calibration. Candidates enter one after another,
the strongest first; beside each stand those that explain the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from calib.diagnosis.population.evidence import Trial
from calib.diagnosis.population.lot import LotEvidence, visible_inverse
from calib.diagnosis.population.random_effects import RandomEffects, random_effects
from calib.poses.imu_log import FloatArray

FALSE_ALARM = 0.01
"""Probability that a lot without effects is said to have one, all candidates and both questions
together (Bonferroni): derived, the level of both triads of one session. What it comes to is
measured by ``python -m tests.bench.study_population``."""

MOST_NAMED = 4
"""Effects named in one lot; derived: more than any sensor showed."""

AS_STRONG = 3.0
"""Behind the strongest in exponent, up to which a candidate that is not named by itself may be the
true one: derived, odds of 20 to 1."""

WILD_P_VALUE = 1e-6
"""Below which the residual of a session is no chance. Derived: 10,000 sound sessions have none, so
that widening takes nothing from what the others leave."""

FEWEST_DOF_OF_VARIANCE = 8.0
"""Degrees of freedom that count behind sds at least. Derived: the variance of 1/x, and with it 1/c
= (ν - 2)/(ν - 4), is infinite at four; at twice as many 1/c is 1.5. (A mean of 1/x is enough where
sessions are compared one by one: ``FEWEST_DOF_OF_MEAN`` of ``repeatability``.)"""

ALONE = 0.98
"""Share of a parameter in what is seen from which a sensor states a size of it; derived, as
``UNDETERMINED_SHARE`` of a fit."""


@dataclass(frozen=True)
class PooledTrial:
    """What a lot says of one candidate.

    ``p_common`` and ``p_any`` answer the two questions of this module, ``exponent`` (half the
    excess of chi-square, the logarithm of an odds) ranks where they underflow; ``sessions`` of the
    lot show it.
    """

    trial: Trial
    sessions: int
    p_common: float
    p_any: float
    exponent: float

    @property
    def p_value(self) -> float:
        """That of the better answer, for having asked twice."""
        return min(1.0, 2 * min(self.p_common, self.p_any))


@dataclass(frozen=True, eq=False)
class PooledEffect:
    """One effect that is missing in the lot.

    ``alternatives`` are names that explain the same in these sessions, ``sizes`` (k) the common
    size and the spread of each parameter over the sensors, SI, ``size`` and ``sd`` (n, k) those of
    each sensor in the order of the pool's, NaN where its poses do not show it.
    """

    evidence: PooledTrial
    alternatives: tuple[str, ...]
    sizes: tuple[RandomEffects | None, ...]
    size: FloatArray
    sd: FloatArray

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.evidence.trial.name


@dataclass(frozen=True, eq=False)
class Pool:
    """What is missing in a lot of n ``sensors``: ``effects``, the strongest first.

    ``candidates`` are all of them, as the lot shows them before anything is named.
    """

    sensors: tuple[str, ...]
    effects: tuple[PooledEffect, ...]
    candidates: tuple[PooledTrial, ...]


def pool(lot: LotEvidence) -> Pool:
    """What is missing in ``lot``."""
    first = _judged(lot)
    level = FALSE_ALARM / max(len(first), 1)
    named: list[tuple[PooledTrial, tuple[str, ...]]] = []
    remaining, judged = lot, first
    while judged and len(named) < MOST_NAMED:
        best = max(judged, key=lambda each: each.exponent)
        if best.p_value >= level:
            break
        named.append((best, _alternatives(remaining, best, judged, level)))
        remaining = remaining.beside(best.trial)
        judged = [each for each in _judged(remaining) if each.trial.name not in
                  {one.trial.name for one, _ in named}]
    effects = []
    of_named = lot.of_trials([best.trial for best, _ in named])
    for best, alternatives in named:
        beside = of_named
        for other, _ in named:
            if other.trial != best.trial:
                beside = beside.beside(other.trial)
        size, sd = _sizes(beside, best.trial)
        effects.append(PooledEffect(best, alternatives, _common(size, sd), size, sd))
    return Pool(tuple(dict.fromkeys(lot.sensors)), tuple(effects), tuple(first))


def _judged(lot: LotEvidence) -> list[PooledTrial]:
    return [each for trial in lot.trials if (each := judge(lot, trial)) is not None]


def judge(lot: LotEvidence, trial: Trial) -> PooledTrial | None:
    """Both questions about one candidate; None where no session of the lot shows it."""
    where = lot.place(trial)
    score, information = lot.score[:, where], lot.information[:, where, where]
    inverse, rank = visible_inverse(information, lot.whole[:, where])
    sees = rank > 0
    if not sees.any():
        return None
    drop = np.einsum("si,sij,sj->s", score, inverse, score)[sees]
    rank, spare = rank[sees], np.maximum(lot.dof[sees] - rank[sees], 0.0)
    rest = np.where(spare > 0, np.maximum(lot.chi2[sees] - drop, 0.0), 0.0)
    widening = _widening(rest, spare, lot.noise_dof[sees])
    like = _as_many(lot.noise_dof[sees])
    spare_dof = float((spare * like).sum())
    if spare.any():
        variance = float((rest / widening).sum() / spare.sum())
    else:
        variance = float(lot.chi2.sum() / max(lot.dof.sum(), 1.0))  # of all that there was
    total = (information[sees] / widening[:, None, None]).sum(axis=0)
    pull = (score[sees] / widening[:, None]).sum(axis=0)
    whole = (lot.whole[sees][:, where] / widening[:, None]).sum(axis=0)
    of_sum, common_dof = visible_inverse(total[None], whole[None])
    common = float(pull @ of_sum[0] @ pull) / variance * float(like.mean())
    compared = spare > 0  # a session that the candidate explains whatever it holds says nothing
    every = float((drop / widening)[compared].sum()) / variance
    every_dof = float(rank[compared].sum())
    return PooledTrial(
        trial,
        int(sees.sum()),
        _tail(common, float(common_dof[0]), float(common_dof[0]), spare_dof),
        _tail(every, every_dof, float((rank * like)[compared].sum()), spare_dof),
        max(_exponent(common, float(common_dof[0])), _exponent(every, every_dof)),
    )


def _widening(rest: FloatArray, spare: FloatArray, noise_dof: FloatArray) -> FloatArray:
    """By which each session's chi-square counts less, (S,)."""
    ratio = rest / np.maximum(spare, 1.0)
    misfit = (spare > 0) & (fdtrc(np.maximum(spare, 1.0), noise_dof, ratio) < WILD_P_VALUE)
    return np.asarray(np.where(misfit, ratio, 1.0))


def _as_many(noise_dof: FloatArray) -> FloatArray:
    """c of this module, (S,)."""
    dof = np.maximum(noise_dof, FEWEST_DOF_OF_VARIANCE)
    return np.asarray((dof - 4) / (dof - 2))


def _tail(chi2: float, dof: float, like_dof: float, spare_dof: float) -> float:
    """Probability of so large a ratio by chance."""
    if dof <= 0:
        return 1.0
    return float(fdtrc(like_dof, spare_dof if spare_dof > 0 else 1e9, chi2 / dof))


def _exponent(chi2: float, dof: float) -> float:
    """Minus the logarithm of the tail of chi-square far out, which does not underflow."""
    if chi2 <= dof or dof <= 0:
        return 0.0
    return 0.5 * (chi2 - dof - dof * float(np.log(chi2 / dof)))


def _alternatives(
    lot: LotEvidence, best: PooledTrial, judged: Sequence[PooledTrial], level: float
) -> tuple[str, ...]:
    """Names beside which ``best`` is not needed any more, named by themselves or as strong."""
    names = []
    for other in judged:
        as_strong = other.exponent > best.exponent - AS_STRONG
        if other.trial.name == best.trial.name or (other.p_value >= level and not as_strong):
            continue
        both = lot.of_trials([other.trial, best.trial])
        again = judge(both.beside(other.trial), best.trial)
        if again is None or again.p_value >= level:
            names.append(other.trial.name)
    return tuple(dict.fromkeys(names))


def _sizes(lot: LotEvidence, trial: Trial) -> tuple[FloatArray, FloatArray]:
    """Size and sd of every parameter in every sensor, (n, k); NaN where not seen by itself."""
    where = lot.place(trial)
    score, information = lot.score[:, where], lot.information[:, where, where]
    inverse, rank = visible_inverse(information, lot.whole[:, where])
    drop = np.einsum("si,sij,sj->s", score, inverse, score)
    rest, spare = np.maximum(lot.chi2 - drop, 0.0), np.maximum(lot.dof - rank, 0.0)
    widening = _widening(rest, spare, lot.noise_dof)
    variance = float((rest / widening).sum() / spare.sum()) if spare.any() else 1.0
    sensor = np.unique(lot.sensors, return_inverse=True)[1]
    order = np.array([sensor[lot.sensors.index(name)] for name in dict.fromkeys(lot.sensors)])

    def by_sensor(values: FloatArray) -> FloatArray:
        sums = np.zeros((len(order), *values.shape[1:]))
        np.add.at(sums, sensor, values)
        return np.asarray(sums[order])

    total = by_sensor(information / widening[:, None, None])
    inverse, _ = visible_inverse(total, by_sensor(lot.whole[:, where] / widening[:, None]))
    size = (inverse @ by_sensor(score / widening[:, None])[..., None])[..., 0]
    as_known = max(variance, 1.0) / float(_as_many(lot.noise_dof).mean())
    sd = np.sqrt(np.einsum("skk->sk", inverse) * as_known)
    seen = (np.einsum("sij,sji->si", inverse, total) > ALONE) & (sd > 0)
    return np.where(seen, size, np.nan), np.where(seen, sd, np.nan)


def _common(size: FloatArray, sd: FloatArray) -> tuple[RandomEffects | None, ...]:
    fits = []
    for value, each in zip(size.T, sd.T, strict=True):
        stated = np.isfinite(value)
        fits.append(random_effects(value[stated], each[stated] ** 2) if stated.any() else None)
    return tuple(fits)
