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
from calib.fit.validation.leave_one_out import left_out_residual
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
class Products:
    """Products of columns of a table; the last column of each kind is nothing.

    ``gram`` (u, v) of those of some hypotheses with those of all, ``squared`` (v,) of each with
    itself and ``product`` (v,) with the residual; ``row`` and ``first`` (m,) are where those of
    each hypothesis begin.
    """

    gram: FloatArray
    squared: FloatArray
    product: FloatArray
    row: IntArray
    first: IntArray


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
        return Signature("", self.rows[self.where(j)].T, self.unit_block(j),
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

    @cached_property
    def _widths(self) -> list[int]:
        return [width_for(seen) if seen else 0 for seen in self.seen.tolist()]

    def products(self, sets: Sequence[tuple[int, ...]]) -> Products:
        """The products that ``sets`` are made of."""
        some = sorted({j for members in sets for j in members[:-1]})
        every = sorted({j for members in sets for j in members})
        (few, row), (rows, first) = self._columns(some), self._columns(every)
        return Products(few @ rows.T, (rows**2).sum(axis=1), rows @ self.residual, row, first)

    def _columns(self, which: Sequence[int]) -> tuple[FloatArray, IntArray]:
        """The visible columns of the hypotheses ``which``, and nothing; where each begins, (m,)."""
        seen, first = self.seen[which], np.zeros(len(self.seen), int)
        first[which] = np.cumsum(seen) - seen
        nothing = np.zeros((1, len(self.residual)))
        return np.concatenate([*(self.rows[self.where(j)] for j in which), nothing]), first

    def sets(self, members: Sequence[tuple[int, ...]], of: Products | None = None) -> Sets:
        """Sets of hypotheses whose blocks have the same widths, one after another.

        ``of`` has the products that they are made of, where these are known.
        """
        of = self.products(members) if of is None else of
        which = np.array(members)  # (B, k)
        seen, widths = self.seen[which], tuple(self._widths[j] for j in members[0])

        def index(first: IntArray, nothing: int, k: int) -> IntArray:
            place = np.arange(widths[k])
            return np.where(place < seen[:, k, None], first[which[:, k], None] + place, nothing)

        blocks = range(len(widths))
        columns = [index(of.first, len(of.product) - 1, k) for k in blocks]
        across = np.concatenate(columns, axis=1)
        rows = np.concatenate([np.zeros((len(which), 0), int),
                               *(index(of.row, len(of.gram) - 1, k) for k in blocks[:-1])], axis=1)
        return Sets(of.gram[rows[:, :, None], across[:, None, :]], of.squared[columns[-1]],
                    of.product[across], self.chi2, self.noise, widths, seen)

    def weighed(self, sets: Sequence[tuple[int, ...]]) -> FloatArray:
        """Log density of the residual under every set, (B,).

        -inf where a set has a member that is blind, or one that the others leave next to nothing
        of.
        """
        values = np.full(len(sets), -np.inf)
        groups = self._of_equal_widths(sets)
        of = self.products(sets)
        for places in groups:
            members = [sets[i] for i in places]
            values[places] = (self.sets(members, of).averaged() if members[0] else
                              np.logaddexp(*self.noise.nothing(self.chi2)))
        self._leave_apart(sets, groups, of, values)
        return values

    def at_most(self, sets: Sequence[tuple[int, ...]]) -> FloatArray:
        """Upper bound of the log density (B,), no unit, of ``sets``; see :meth:`weighed`."""
        values, of = np.full(len(sets), np.inf), self.products(sets)
        for places in self._of_equal_widths(sets):
            if sets[places[0]]:
                values[places] = self.sets([sets[i] for i in places], of).at_most()
        return values

    def _of_equal_widths(self, sets: Sequence[tuple[int, ...]]) -> list[IntArray]:
        """Groups of ``sets`` with blocks of equal widths, all of them seen."""
        groups: dict[tuple[int, ...], list[int]] = {}
        widths, seen = self._widths, self.seen.tolist()
        for i, members in enumerate(sets):
            if all(seen[j] for j in members):
                groups.setdefault(tuple([widths[j] for j in members]), []).append(i)
        return [np.array(places) for places in groups.values()]

    def _leave_apart(
        self, sets: Sequence[tuple[int, ...]], groups: Sequence[IntArray], of: Products,
        values: FloatArray,
    ) -> None:
        """Give -inf in ``values`` (B,) to sets whose members are not apart, if they could count."""
        judged, best = np.zeros(len(sets), bool), np.inf
        while (top := float(values.max(initial=-np.inf))) < best:  # it falls with its best set
            best = top
            for at in groups:
                some = at[(values[at] > best - 2 * CONSTANTS.negligible) & ~judged[at]]
                if len(some) and len(sets[some[0]]) > 1:
                    group = self.sets([sets[i] for i in some], of)
                    values[some[~group.are_apart]] = -np.inf
                judged[some] = True

    def left_out(self, members: Sequence[int], pose: IntArray) -> FloatArray:
        """Whitened residual of every data row when its pose is left out of the fit, (d,).

        ``members`` are fitted with the base, each held to its likeliest size; ``pose`` (d,)
        numbers the data rows' poses.
        """
        seen = tuple(j for j in members if not self.is_blind(j))
        base = self.projector.model
        if not seen:
            return left_out_residual(self.residual, base, pose)
        x = np.concatenate([self.rows[self.where(j)] for j in seen]).T
        root = 1 / np.repeat(self.sets([seen]).likeliest_sizes()[0], self.seen[list(seen)])
        solution = np.linalg.solve(x.T @ x + np.diag(root**2), x.T @ self.residual)
        residual = np.concatenate([self.residual - x @ solution, -root * solution])
        nothing = np.zeros((len(root), base.shape[1]))
        return left_out_residual(
            residual, np.block([[base, x], [nothing, np.diag(root)]]), pose
        )

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
