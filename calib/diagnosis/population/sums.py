"""Result of a lot for one candidate, as sums over its sessions that are accumulated by block.

With ν degrees of freedom behind the sds of a session, and c of :mod:`.pool`. A session that nothing
explains counts with its sds widened by the Birge ratio.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.special import fdtrc

from calib.diagnosis.population.evidence import Trial
from calib.diagnosis.population.lot import LotEvidence, visible_inverse
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

WILD_P_VALUE = 1e-6
"""Below which the residual of a session is no chance. Derived: 10,000 sound sessions have none, so
that widening takes nothing from what the others leave."""

FEWEST_DOF_OF_VARIANCE = 8.0
"""Degrees of freedom that count behind sds at least. Derived: the variance of 1/x, and with it 1/c
= (ν - 2)/(ν - 4), is infinite at four; at twice as many 1/c is 1.5. (A mean of 1/x is enough where
sessions are compared one by one: ``FEWEST_DOF_OF_MEAN`` of ``spread``.)"""


@dataclass(frozen=True, eq=False)
class TrialSums:
    """Sums over the sessions that show one candidate; those of two blocks add up.

    ``sessions`` are how many; ``like``, ``spare``, ``spare_like`` and ``rest`` sum c, the degrees
    of freedom that the candidate leaves, both, and what it leaves of chi-square; ``drop``, ``rank``
    and ``rank_like`` what it takes off with how many degrees of freedom, where some are left;
    ``total`` (k, k), ``pull`` and ``whole`` (k,) are the information, the score and the squares of
    the whole signals; ``chi2`` and ``dof`` those of all sessions.
    """

    sessions: float
    like: float
    spare: float
    spare_like: float
    rest: float
    drop: float
    rank: float
    rank_like: float
    total: FloatArray
    pull: FloatArray
    whole: FloatArray
    chi2: float
    dof: float

    def __add__(self, other: "TrialSums") -> "TrialSums":
        return TrialSums(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))


def sums_of(lot: LotEvidence, trial: Trial) -> TrialSums:
    """The sums of one candidate over a lot, or over a block of one."""
    all_of_them = _Sessions.of(lot, trial)
    some = all_of_them.take(all_of_them.rank > 0)
    compared = some.spare > 0  # a session that the candidate fits exactly says nothing
    return TrialSums(
        sessions=float(len(some.rank)),
        like=float(some.like.sum()),
        spare=float(some.spare.sum()),
        spare_like=float((some.spare * some.like).sum()),
        rest=float(some.rest.sum()),
        drop=float(some.drop[compared].sum()),
        rank=float(some.rank[compared].sum()),
        rank_like=float((some.rank * some.like)[compared].sum()),
        total=some.information.sum(axis=0),
        pull=some.score.sum(axis=0),
        whole=some.whole.sum(axis=0),
        chi2=float(lot.chi2.sum()),
        dof=float(lot.dof.sum()),
    )


@dataclass(frozen=True, eq=False)
class _Sessions:
    """What S sessions show of one candidate of k parameters, each as wide as its misfit asks.

    ``information`` (S, k, k), ``score`` and ``whole`` (S, k) as of :class:`LotEvidence`; ``rank``,
    how many parameters are seen, ``drop`` and ``rest``, what they take off chi-square and leave,
    ``spare``, the degrees of freedom that they leave, and ``like``, c, each (S,).
    """

    information: FloatArray
    score: FloatArray
    whole: FloatArray
    rank: FloatArray
    drop: FloatArray
    rest: FloatArray
    spare: FloatArray
    like: FloatArray

    @classmethod
    def of(cls, lot: LotEvidence, trial: Trial) -> "_Sessions":
        """The sessions of a lot."""
        where = lot.place(trial)
        score, information = lot.score[:, where], lot.information[:, where, where]
        inverse, rank = visible_inverse(information, lot.whole[:, where])
        drop = np.einsum("si,sij,sj->s", score, inverse, score)
        spare = np.maximum(lot.dof - rank, 0.0)
        rest = np.where(spare > 0, np.maximum(lot.chi2 - drop, 0.0), 0.0)
        ratio = rest / np.maximum(spare, 1.0)
        misfit = (spare > 0) & (
            fdtrc(np.maximum(spare, 1.0), lot.noise_dof, ratio) < WILD_P_VALUE)
        width = np.where(misfit, ratio, 1.0)
        freedom = np.maximum(lot.noise_dof, FEWEST_DOF_OF_VARIANCE)
        return cls(information / width[:, None, None], score / width[:, None],
                   lot.whole[:, where] / width[:, None], rank, drop / width, rest / width, spare,
                   (freedom - 4) / (freedom - 2))

    def take(self, which: BoolArray) -> "_Sessions":
        """The sessions ``which`` alone."""
        return _Sessions(*(getattr(self, f.name)[which] for f in fields(self)))


class SensorSums:
    """Information, score and whole signals of one trial, added up sensor by sensor."""

    def __init__(self, trial: Trial, sensors: int) -> None:
        self.trial = trial
        k = trial.size
        self.information, self.whole = np.zeros((sensors, k, k)), np.zeros((sensors, k))
        self.score = np.zeros((sensors, k))
        self.rest = self.spare = self.like = self.sessions = 0.0

    def add(self, lot: LotEvidence, sensor: IntArray) -> None:
        """Add the sessions of a block, which are of these sensors (S,)."""
        if self.trial not in lot.trials:
            return
        some = _Sessions.of(lot, self.trial)
        np.add.at(self.information, sensor, some.information)
        np.add.at(self.score, sensor, some.score)
        np.add.at(self.whole, sensor, some.whole)
        self.rest += float(some.rest.sum())
        self.spare += float(some.spare.sum())
        self.like += float(some.like.sum())
        self.sessions += len(lot)

    def sizes(self) -> tuple[FloatArray, FloatArray]:
        """Sizes and their sds, SI, (n, k)."""
        inverse, _ = visible_inverse(self.information, self.whole)
        size = (inverse @ self.score[..., None])[..., 0]
        variance = self.rest / self.spare if self.spare else 1.0
        as_known = max(variance, 1.0) / (self.like / self.sessions)
        sd = np.sqrt(np.einsum("skk->sk", inverse) * as_known)
        seen = (np.einsum("sij,sji->si", inverse, self.information) > 1 - VISIBLE_SHARE) & (sd > 0)
        return np.where(seen, size, np.nan), np.where(seen, sd, np.nan)

    def beside_strongest(self) -> tuple[int, TrialSums]:
        """The sensor that shows most of the trial, and the sums over all others."""
        inverse, rank = visible_inverse(self.information, self.whole)
        drop = np.einsum("si,sij,sj->s", self.score, inverse, self.score)
        strongest = int(drop.argmax())
        others = np.arange(len(drop)) != strongest
        like = self.like / self.sessions
        ranks = float(rank[others].sum())
        return strongest, TrialSums(
            self.sessions, self.like, self.spare, self.spare * like, self.rest,
            float(drop[others].sum()), ranks, ranks * like, self.information[others].sum(axis=0),
            self.score[others].sum(axis=0), self.whole[others].sum(axis=0), self.rest, self.spare)
