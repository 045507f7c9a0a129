"""The evidence of all sensors of a lot side by side, evenings of one sensor added up."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.population.evidence import Evidence, Trial
from calib.fit.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class LotEvidence:
    """S sensors and K parameters of all trials.

    Parameters
    ----------
    sensors : tuple of str
    trials : tuple of Trial
    score, information : array, shapes (S, K) and (S, K, K)
        What a sensor's poses do not show or cannot evaluate is zero.
    whole : array, shape (S, K)
        Diagonal of the information beside the fitted models alone.
    chi2, dof, noise_dof : array, shape (S,)
    """

    sensors: tuple[str, ...]
    trials: tuple[Trial, ...]
    score: FloatArray
    information: FloatArray
    whole: FloatArray
    chi2: FloatArray
    dof: FloatArray
    noise_dof: FloatArray

    def __len__(self) -> int:
        return len(self.sensors)

    @classmethod
    def of(cls, parts: Iterable[tuple[str, Evidence]]) -> "LotEvidence | None":
        """The lot of pairs of a sensor's name and the evidence of one of its evenings.

        None where there are none. Trials of the same name, shape and unit are the same.
        """
        places: dict[Trial, slice] = {}
        size = 0
        sums: dict[str, list[tuple[Evidence, list[int]]]] = {}
        for sensor, evidence in parts:
            for trial in evidence.trials:
                if trial not in places:
                    places[trial] = slice(size, size + trial.size)
                    size += trial.size
            index = [i for trial in evidence.trials
                     for i in range(places[trial].start, places[trial].stop)]
            sums.setdefault(sensor, []).append((evidence, index))
        if not sums:
            return None
        n = len(sums)
        score, information = np.zeros((n, size)), np.zeros((n, size, size))
        scalars = np.zeros((n, 3))
        for i, evenings in enumerate(sums.values()):
            for evidence, index in evenings:
                score[i, index] += evidence.score
                information[i][np.ix_(index, index)] += evidence.information
                scalars[i] += evidence.chi2, evidence.dof, evidence.noise_dof
        whole = np.einsum("skk->sk", information).copy()
        chi2, dof, noise_dof = scalars.T
        return cls(tuple(sums), tuple(places), score, information, whole, chi2, dof, noise_dof)

    @classmethod
    def joined(cls, parts: Sequence["LotEvidence"]) -> "LotEvidence":
        """Parts with the same trials as one lot, evenings of one sensor added up."""
        names = [name for part in parts for name in part.sensors]
        sensors = tuple(dict.fromkeys(names))
        number = {name: i for i, name in enumerate(sensors)}
        index = np.array([number[name] for name in names])

        def added(arrays: list[FloatArray]) -> FloatArray:
            rows = np.concatenate(arrays)
            sums = np.zeros((len(sensors), *rows.shape[1:]))
            np.add.at(sums, index, rows)
            return sums

        fields = ("score", "information", "whole", "chi2", "dof", "noise_dof")
        sums = {name: added([getattr(part, name) for part in parts]) for name in fields}
        return cls(sensors, parts[0].trials, **sums)

    def only(self, i: int) -> "LotEvidence":
        """The lot of one sensor alone."""
        rows = {name: value[i : i + 1] for name, value in vars(self).items() if name != "trials"}
        return LotEvidence(trials=self.trials, **rows)

    def place(self, trial: Trial) -> slice:
        """Where the parameters of ``trial`` stand."""
        start = 0
        for each in self.trials:
            if each == trial:
                return slice(start, start + each.size)
            start += each.size
        raise KeyError(trial)

    def beside(self, trial: Trial) -> "LotEvidence":
        """The evidence that is left when ``trial`` is fitted to every sensor, in its own size."""
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
    squares of the whole signals; of others the inverse knows nothing.
    """
    length = np.sqrt(np.where(whole > 0, whole, 1.0))
    unit = information / (length[:, :, None] * length[:, None, :])
    values, vectors = np.linalg.eigh(unit)
    seen = values > VISIBLE_SHARE**2
    inverse = np.where(seen, 1 / np.where(seen, values, 1.0), 0.0)
    product = (vectors * inverse[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    return product / (length[:, :, None] * length[:, None, :]), seen.sum(axis=1).astype(float)
