"""Effects that a lot lacks: the evidence of all its sessions added up.

Two questions for every candidate, F ratios against what the rows of the sessions leave when the
candidate is fitted to each of them, so that sds which are all wrong by a factor name nothing:

    has it one size in all sensors?      (Σu)ᵀ (ΣI)⁻¹ (Σu),    k degrees of freedom
    has it any size in the sessions?     Σ uᵀ I⁻¹ u,            Σk degrees of freedom

The second less the first is Cochran's Q: whether the sizes differ from session to session.

The sds of a session come from ν degrees of freedom, s² = σ² x with x = χ²_ν/ν. A sum of its ratios
scatters like one of c = (ν - 4)/(ν - 2) times as many degrees of freedom; and in a sum that weighs
sessions by 1/s², as Σu does, those with small s count too much: its variance is 1/c times what the
rows leave (the moments of 1/x). A session that nothing explains (``WILD_P_VALUE``) counts with its
sds widened by the Birge ratio, as in its own calibration. Candidates enter one after another,
the strongest first; beside each stand those that explain the same.

All of these are sums over sessions. They are added up block by block, in a pass over the lot for
every question, so that memory does not grow with the number of sessions.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import fdtrc

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.population.evidence import Trial
from calib.diagnosis.population.lot import LotEvidence, visible_inverse
from calib.diagnosis.population.random_effects import RandomEffects, random_effects
from calib.diagnosis.population.sums import SensorSums, TrialSums, sums_of
from calib.effects.effect import EFFECTS
from calib.poses.imu_log import FloatArray

FALSE_ALARM = 0.01
"""Probability that a lot without effects is said to have one, all candidates and both questions
together (Bonferroni), or any sensor unlike it, or moved: derived, the level of both triads of one
session. What it comes to is measured by ``python -m tests.bench.study_population``."""

MOST_NAMED = 4
"""Effects named in one lot; derived: more than any sensor showed."""

Blocks = Callable[[Sequence[Trial]], Iterable[LotEvidence]]
"""Passes over a lot: each call gives the evidence of its sessions from the first to the last, of
some trials at least; of every one where none is named."""


@dataclass(frozen=True)
class PooledTrial:
    """Result of a lot for one candidate.

    ``p_common`` and ``p_any`` answer the two questions of this module, ``p_same`` is that of sizes
    which differ so much if all are the same, ``exponent`` (half the excess of chi-square, the
    logarithm of an odds) ranks where they underflow; ``sessions`` of the lot show it.
    """

    trial: Trial
    sessions: int
    p_common: float
    p_any: float
    p_same: float
    exponent: float

    @property
    def p_value(self) -> float:
        """P-value of the better of two answers, which counts that two were looked at."""
        return min(1.0, 2 * min(self.p_common, self.p_any))


@dataclass(frozen=True, eq=False)
class PooledEffect:
    """One effect that the lot lacks.

    ``alternatives`` are names that explain the same in these sessions, ``only`` is the sensor
    without which the lot does not show it, None where others do. ``sizes`` (k) are the common size
    and the spread of each parameter over the sensors, SI, ``size`` and ``sd`` (n, k) those of each
    sensor in the order of the pool's, NaN where its poses do not show it.
    """

    evidence: PooledTrial
    alternatives: tuple[str, ...]
    only: str | None
    sizes: tuple[RandomEffects | None, ...]
    size: FloatArray = field(repr=False)
    sd: FloatArray = field(repr=False)

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.evidence.trial.name


@dataclass(frozen=True, eq=False)
class Pool:
    """Effects that a lot of n ``sensors`` lacks: ``effects``, the strongest first.

    ``candidates`` are all of them, as the lot shows them before anything is named.
    """

    sensors: tuple[str, ...] = field(repr=False)
    effects: tuple[PooledEffect, ...]
    candidates: tuple[PooledTrial, ...] = field(repr=False)


def pool(blocks: Blocks) -> Pool:
    """Pool of the lot whose sessions ``blocks`` gives, pass after pass."""
    sensors: dict[str, int] = {}
    named: list[tuple[PooledTrial, tuple[str, ...]]] = []
    sums: dict[Trial, TrialSums] = {}
    for block in _noting(blocks, sensors)(()):
        _add(sums, {trial: sums_of(block, trial) for trial in block.trials})
    first = judged = _judged(sums)
    level = FALSE_ALARM / max(len(first), 1)
    while judged and len(named) < MOST_NAMED:
        best = max(judged, key=lambda trial: trial.exponent)
        if best.p_value >= level:
            break
        beside = [trial.trial for trial, _ in named]
        after, alternatives = _after(blocks, beside, best, judged, level)
        if lines := _contained(best, alternatives, judged):
            best = max(lines, key=lambda trial: trial.exponent)
            after, alternatives = _after(blocks, beside, best, judged, level)
        judged = after
        named.append((best, alternatives))
        known = {trial.trial.name for trial, _ in named}
        judged = [trial for trial in judged if trial.trial.name not in known]
    sums_of_sensors = _sums_of_sensors(blocks, [trial.trial for trial, _ in named], sensors)
    names = tuple(sensors)
    effects = tuple(
        PooledEffect(best, alternatives, _only(sums, names), _common(*sizes), *sizes)
        for (best, alternatives), sums in zip(named, sums_of_sensors, strict=True)
        for sizes in [sums.sizes()])
    return Pool(names, effects, tuple(first))


def _contained(
    best: PooledTrial, alternatives: Sequence[str], judged: Sequence[PooledTrial]
) -> list[PooledTrial]:
    """What ``best`` contains and beside which it is not needed: the line of a curve."""
    effect = EFFECTS.get(best.trial.name)
    return [] if effect is None else [
        trial for trial in judged if trial.trial.name in {*effect.contains} & {*alternatives}]


def _only(sums: SensorSums, names: Sequence[str]) -> str | None:
    """The sensor that speaks for the lot alone: without it neither question has an answer."""
    strongest, others = sums.beside_strongest()
    judged = judge(sums.trial, others)
    return names[strongest] if judged is None or judged.p_value >= FALSE_ALARM else None


def _noting(blocks: Blocks, sensors: dict[str, int]) -> Blocks:
    """The same pass, in which every sensor is given its number."""
    def passing(trials: Sequence[Trial]) -> Iterator[LotEvidence]:
        for lot in blocks(trials):
            for sensor in lot.sensors:
                sensors.setdefault(sensor, len(sensors))
            yield lot

    return passing


def judge(trial: Trial, sums: TrialSums) -> PooledTrial | None:
    """Both questions about one candidate; None where no session of the lot shows it."""
    if not sums.sessions:
        return None
    # Where nothing is left beside it, the variance is of all that there was.
    variance = sums.rest / sums.spare if sums.spare else sums.chi2 / max(sums.dof, 1.0)
    of_sum, common_dof = visible_inverse(sums.total[None], sums.whole[None])
    dof = float(common_dof[0])
    of_one_size = float(sums.pull @ of_sum[0] @ sums.pull) / variance
    common = of_one_size * sums.like / sums.sessions
    every = sums.drop / variance
    return PooledTrial(
        trial,
        int(sums.sessions),
        _tail(common, dof, dof, sums.spare_like),
        _tail(every, sums.rank, sums.rank_like, sums.spare_like),
        _tail(every - of_one_size, sums.rank - dof, sums.rank_like * (1 - dof / sums.rank)
              if sums.rank else 0.0, sums.spare_like),
        max(_exponent(common, dof), _exponent(every, sums.rank)),
    )


def _add(sums: dict[Trial, TrialSums], of_block: Mapping[Trial, TrialSums]) -> None:
    """Add the sums of a block to those of the blocks before it."""
    for trial, more in of_block.items():
        sums[trial] = sums[trial] + more if trial in sums else more


def _judged(sums: Mapping[Trial, TrialSums]) -> list[PooledTrial]:
    """The candidates that a session of the lot shows."""
    return [judged for trial, total in sums.items() if (judged := judge(trial, total)) is not None]


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


def _after(
    blocks: Blocks, beside: Sequence[Trial], best: PooledTrial, judged: Sequence[PooledTrial],
    level: float,
) -> tuple[list[PooledTrial], tuple[str, ...]]:
    """Every candidate with each session fitted with ``beside`` and ``best``, and names beside which
    ``best`` is not needed any more, named by themselves or as strong."""
    rivals = [
        other.trial for other in judged if other.trial.name != best.trial.name
        and (other.p_value < level or other.exponent > best.exponent - CONSTANTS.told_apart)
    ]
    sums: dict[Trial, TrialSums] = {}
    needed: dict[Trial, TrialSums] = {}
    for block in blocks(()):
        before = block.reduced_by(beside)
        if best.trial in before.trials:
            _add(needed, {other: sums_of(
                before.selected([other, best.trial]).reduced_by([other]), best.trial)
                for other in rivals})
        lot = before.reduced_by([best.trial])
        _add(sums, {trial: sums_of(lot, trial) for trial in lot.trials})
    again = {other: judge(best.trial, total) for other, total in needed.items()}
    return _judged(sums), tuple(dict.fromkeys(
        other.name for other, trial in again.items() if trial is None or trial.p_value >= level))


def _sums_of_sensors(
    blocks: Blocks, trials: Sequence[Trial], sensors: dict[str, int]
) -> list[SensorSums]:
    """What every sensor shows of each trial beside the others."""
    sums = [SensorSums(trial, len(sensors)) for trial in trials]
    for block in blocks(trials) if trials else ():
        index = np.array([sensors[name] for name in block.sensors])
        for of_trial in sums:
            others = [trial for trial in trials if trial != of_trial.trial]
            of_trial.add(block.selected(trials).reduced_by(others), index)
    return sums


def _common(size: FloatArray, sd: FloatArray) -> tuple[RandomEffects | None, ...]:
    fits = []
    for value, one in zip(size.T, sd.T, strict=True):
        stated = np.isfinite(value)
        fits.append(random_effects(value[stated], one[stated] ** 2) if stated.any() else None)
    return tuple(fits)
