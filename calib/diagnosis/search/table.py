"""Every hypothesis at one table: their signatures at one solution, and the evidence of any set.

A table is made at a joint fit of the base and some effects. What those explained is put back into
the residual and what the base can absorb is projected out, so that every set, larger or smaller,
is weighed in closed form from the same Gram matrix. At a solution that explains the rows this
linearisation is right; at the base it is biased by what is missing, and screens only.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.signature import Projector, Signature
from calib.diagnosis.search.evidence import Sets, block_log_densities, width_for
from calib.fit.noise_size import Noise
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The projected columns of one hypothesis of k parameters, turned until they are orthogonal.

    ``turns`` (k, k) turn them, ``squared`` (k,) are their squared lengths then, ``along`` (k,)
    what they have in common with the residual; ``unit`` (k,) is what one of the table's units is
    in each parameter.
    """

    turns: FloatArray
    squared: FloatArray
    along: FloatArray
    unit: FloatArray


@dataclass(frozen=True, eq=False)
class Batch:
    """N sets of hypotheses, those of like shape side by side.

    ``parts`` are the places (B,) in the batch of some of them, and these sets; those with a blind
    member are in none.
    """

    count: int
    parts: Sequence[tuple[IntArray, Sets]]

    def at_most(self) -> FloatArray:
        """Upper bound of the log density of the residual under every set, (N,), no unit."""
        values = np.full(self.count, -np.inf)
        for places, sets in self.parts:
            values[places] = sets.at_most()
        return values

    def averaged(self, which: Sequence[int] | IntArray = (0,)) -> FloatArray:
        """Log density (N,) of the residual under the sets ``which``, -inf of all others.

        And where members are not apart: the others leave next to nothing of one.
        """
        values = np.full(self.count, -np.inf)
        for places, sets in self.parts:
            some = np.flatnonzero(np.isin(places, which))
            if some.size:
                group = sets.take(some)
                values[places[some]] = np.where(group.are_apart, group.averaged(), -np.inf)
        return values


@dataclass(frozen=True, eq=False)
class Table:
    """The visible columns of m hypotheses at one solution.

    Parameters
    ----------
    projector : Projector
        Of the joint fit, less what is on trial.
    noise : Noise
    rows : array, shape (v, r)
        The visible columns, those of one hypothesis orthogonal and one after another.
    first, seen : array of int, shape (m,)
        Where in ``rows`` those of each hypothesis begin, and how many it has.
    spectra : mapping of int to Spectrum
        Of each hypothesis that has an effect.
    """

    projector: Projector
    noise: Noise
    rows: FloatArray
    first: IntArray
    seen: IntArray
    spectra: Mapping[int, Spectrum]

    @property
    def residual(self) -> FloatArray:
        """Whitened residual with the model projected out, (r,)."""
        return self.projector.residual

    @property
    def chi2(self) -> float:
        """Sum of its squares."""
        return self.projector.chi2

    @property
    def dof(self) -> int:
        """Data rows less what the model fits."""
        return int(self.projector.dof)

    def is_blind(self, j: int) -> bool:
        """Whether the base swallows all of hypothesis ``j``."""
        return bool(self.seen[j] == 0)

    def where(self, j: int) -> slice:
        """The rows of :attr:`rows` that are the visible columns of hypothesis ``j``."""
        return slice(int(self.first[j]), int(self.first[j] + self.seen[j]))

    @cached_property
    def _unit_rows(self) -> FloatArray:
        return np.asarray(self.rows / np.sqrt((self.rows**2).sum(axis=1, keepdims=True)))

    def unit_block(self, j: int) -> FloatArray:
        """Visible columns of hypothesis ``j`` as unit vectors, (r, v), orthogonal."""
        return self._unit_rows[self.where(j)].T

    def signature(self, j: int) -> Signature:
        """The visible columns of hypothesis ``j`` as directions with their strengths."""
        return Signature("", self.unit_block(j),
                         np.sqrt((self.rows[self.where(j)] ** 2).sum(axis=1)))

    def singles(self) -> tuple[FloatArray, FloatArray]:
        """Log density under each hypothesis alone (m,), -inf of a blind one; chi-square's fall."""
        widest = int(self.seen.max(initial=1))
        strength, amplitude = np.zeros((2, len(self.seen), max(widest, 1)))
        inside = np.arange(max(widest, 1)) < self.seen[:, None]
        length = np.sqrt((self.rows**2).sum(axis=1))
        index = (self.first[:, None] + np.arange(max(widest, 1)))[inside]
        strength[inside] = length[index]
        amplitude[inside] = (self.rows @ self.residual / length)[index]
        density = np.full(len(self.seen), -np.inf)
        for width in np.unique(self.seen[self.seen > 0]):
            some = self.seen == width
            density[some] = block_log_densities(
                strength[some, :width], amplitude[some, :width], self.chi2, self.noise)
        return density, (amplitude**2).sum(axis=1)

    def batch(self, sets: Sequence[Sequence[int]]) -> Batch:
        """``sets`` of hypotheses, in which the member of most columns is the last block."""
        seen, groups = self._seen, dict[tuple[int, ...], list[int]]()
        sets = [self.by_width(members) for members in sets]
        for i, members in enumerate(sets):
            widths = [seen[j] for j in members]
            if all(widths):
                shape = len(members), 3 * -(-sum(widths[:-1]) // 3), width_for(widths[-1])
                groups.setdefault(shape, []).append(i)
        which = [np.array([sets[i] for i in places]) for places in groups.values()]
        first, last = ([self._index(each[:, part], shape[1 + k])
                        for each, shape in zip(which, groups, strict=True)]
                       for k, part in enumerate((slice(-1), slice(-1, None))))
        few, row = self._used([index for index, _ in first])
        many, column = self._used([index for index, _ in (*first, *last)])
        gram, squared, product = few @ many.T, (many**2).sum(axis=1), many @ self.residual

        def of_group(g: int) -> Sets:
            (index, block), (diagonal, _) = first[g], last[g]
            every = column[np.concatenate([index, diagonal], axis=1)]
            return Sets(gram[row[index][:, :, None], every[:, None, :]],
                        squared[column[diagonal]], product[every], block, self.seen[which[g]],
                        self.chi2, self.noise)

        return Batch(len(sets), [(np.array(places), of_group(g))
                                 for g, places in enumerate(groups.values())])

    def by_width(self, members: Sequence[int]) -> tuple[int, ...]:
        """``members`` by their number of columns, the fewest first."""
        return tuple(sorted(members, key=lambda j: (self._seen[j], j)))

    @cached_property
    def _seen(self) -> list[int]:
        return list(map(int, self.seen))

    def _index(self, members: IntArray, width: int) -> tuple[IntArray, IntArray]:
        """Which rows of :attr:`rows` are the columns of B sets of ``members`` (B, k), one behind
        the next, the number of all where a set has fewer; and whose each is: both (B, width)."""
        seen, count = self.seen[members], members.shape[1]
        ends = np.cumsum(seen, axis=1)
        place = np.arange(width if count else 0)
        block = (place >= ends[:, :, None]).sum(axis=1)
        inside, block = block < count, np.minimum(block, count - 1)
        begin = np.take_along_axis(self.first[members] - ends + seen, block, axis=1)
        return np.where(inside, begin + place, len(self.rows)), block

    def _used(self, indices: Sequence[IntArray]) -> tuple[FloatArray, IntArray]:
        """The columns of these ``indices`` and of nothing as rows, and the place of each index."""
        is_used = np.arange(len(self.rows) + 1) == len(self.rows)
        for index in indices:
            is_used[index] = True
        used = np.flatnonzero(is_used)
        rows = np.concatenate([self.rows[used[:-1]], np.zeros((1, len(self.residual)))])
        return rows, np.cumsum(is_used) - 1

    def likeliest_sizes(self, sets: Sequence[Sequence[int]]) -> list[FloatArray]:
        """The tau (k,) of each member of ``sets``, near which the density is highest, no unit."""
        sizes: list[FloatArray] = [np.zeros(0)] * len(sets)
        for places, some in self.batch(sets).parts:
            for i, taus in zip(places, some.likeliest_sizes(), strict=True):
                of = dict(zip(self.by_width(sets[i]), taus, strict=True))
                sizes[i] = np.array([of[j] for j in sets[i]])
        return sizes

    def aliases(self, j: int, others: Sequence[int]) -> list[int]:
        """Which of ``others`` can make all of what ``j`` makes: canonical correlations over 0.99.

        They have as many visible directions; of one direction, or more. An effect of one direction
        is thus an alias of a larger one that holds it, and not the larger one of it.
        """
        count = int(self.seen[j])
        some = [other for other in others
                if self.seen[other] == count or (count == 1 and self.seen[other])]
        if not (count and some):
            return []
        mine, which = self.unit_block(j), [self.where(other) for other in some]
        overlap = np.concatenate([self._unit_rows[each] for each in which]) @ mine
        last = np.cumsum(self.seen[some])
        share = np.add.reduceat((overlap**2).sum(axis=1), last - self.seen[some])
        return [some[i] for i in np.flatnonzero(share >= count * CONSTANTS.alias_correlation**2)
                if np.linalg.svd(overlap[last[i] - self.seen[some[i]] : last[i]],
                                 compute_uv=False)[:count].min() > CONSTANTS.alias_correlation]
