"""The evidence of all sessions of a lot side by side."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.population.evidence import Evidence, Trial
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import FloatArray

AT_ONCE = 500
"""Sessions in one block of a lot: a limit of memory, 17 MB for each matrix."""


@dataclass(frozen=True, eq=False)
class LotEvidence(Evidence):
    """S sessions and K parameters of all trials.

    Parameters
    ----------
    sensors : tuple of str, length S
        Which sensor each session is of.
    whole : array, shape (S, K)
        Diagonal of the information beside the fitted models alone. There as in the others, what the
        poses of a session do not show or cannot evaluate is zero.
    """

    sensors: tuple[str, ...]
    whole: FloatArray

    def __len__(self) -> int:
        return len(self.sensors)

    @classmethod
    def of(cls, parts: Iterable[tuple[str, Evidence]]) -> "LotEvidence | None":
        """The lot of pairs of a sensor's name and the evidence of one of its sessions.

        None where there are none. Trials of the same name, shape and unit are the same.
        """
        places: dict[Trial, slice] = {}
        size = 0
        sessions: list[tuple[str, Evidence, list[int]]] = []
        for sensor, evidence in parts:
            for trial in evidence.trials:
                if trial not in places:
                    places[trial] = slice(size, size + trial.size)
                    size += trial.size
            index = [i for trial in evidence.trials
                     for i in range(places[trial].start, places[trial].stop)]
            sessions.append((sensor, evidence, index))
        if not sessions:
            return None
        n = len(sessions)
        sensors = tuple(sensor for sensor, _, _ in sessions)
        score, information = np.zeros((n, size)), np.zeros((n, size, size))
        scalars = np.zeros((3, n))
        for i in reversed(range(n)):  # each is released as soon as it is copied
            _, evidence, index = sessions.pop()
            score[i, index] = evidence.score
            information[i][np.ix_(index, index)] = evidence.information
            scalars[:, i] = evidence.chi2, evidence.dof, evidence.noise_dof
        return cls.from_stack(sensors, Evidence(tuple(places), score, information, *scalars))

    @classmethod
    def from_stack(cls, sensors: Sequence[str], evidence: Evidence) -> "LotEvidence":
        """The lot of the sessions of one stack, ``sensors`` (S) their names."""
        whole = np.einsum("skk->sk", evidence.information).copy()
        return cls(**vars(evidence), sensors=tuple(sensors), whole=whole)

    def selected(self, trials: Sequence[Trial]) -> "LotEvidence":
        """The evidence of these trials alone."""
        known = [trial for trial in trials if trial in self.trials]
        index = [i for trial in known
                 for i in range(self.place(trial).start, self.place(trial).stop)]
        return replace(
            self, trials=tuple(known), score=self.score[:, index], whole=self.whole[:, index],
            information=self.information[:, index][:, :, index],
        )

    def place(self, trial: Trial) -> slice:
        """Slice of the parameters of ``trial``."""
        start = 0
        for one in self.trials:
            if one == trial:
                return slice(start, start + one.size)
            start += one.size
        raise KeyError(trial)

    def reduced_by(self, trials: Sequence[Trial]) -> "LotEvidence":
        """The evidence that is left when ``trials`` are fitted to every session, in its own sizes.

        One after another; those that no session of this part shows are left out.
        """
        lot = self
        for trial in trials:
            if trial in self.trials:
                lot = lot._reduced_by_one(trial)
        return lot

    def _reduced_by_one(self, trial: Trial) -> "LotEvidence":
        where = self.place(trial)
        inverse, rank = visible_inverse(self.information[:, where, where], self.whole[:, where])
        across = self.information[:, :, where]
        pull = across @ inverse
        explained = np.einsum("si,sij,sj->s", self.score[:, where], inverse, self.score[:, where])
        return replace(
            self,
            score=self.score - (pull @ self.score[:, where, None])[..., 0],
            information=self.information - pull @ np.swapaxes(across, 1, 2),
            chi2=self.chi2 - explained,
            dof=self.dof - rank,
        )


def visible_inverse(information: FloatArray, whole: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Inverses (S, k, k) of what is seen of S informations, and how many combinations are, (S,).

    A combination is seen that keeps ``VISIBLE_SHARE`` of its signal, ``whole`` (S, k) being the
    squares of the whole signals; of others the inverse knows nothing. Any unit.
    """
    length = np.sqrt(np.where(whole > 0, whole, 1.0))
    unit = information / (length[:, :, None] * length[:, None, :])
    values, vectors = np.linalg.eigh(unit)
    seen = values > VISIBLE_SHARE**2
    inverse = np.where(seen, 1 / np.where(seen, values, 1.0), 0.0)
    product = (vectors * inverse[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return product / (length[:, :, None] * length[:, None, :]), seen.sum(axis=1).astype(float)
