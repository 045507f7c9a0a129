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
from calib.diagnosis.hypotheses.signature import Projector
from calib.diagnosis.search.evidence import Sets, likeliest_sizes
from calib.fit.column_scaling import orthonormal_columns
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.validation.leave_one_out import left_out_residual
from calib.numbers import NO_LENGTH
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
class Table:
    """The visible columns of m hypotheses at one solution.

    Parameters
    ----------
    projector : Projector
        Of the joint fit, less what is on trial.
    log_prior, total : array, shape (m,)
        Of each hypothesis: the log odds before the data, the signal of its strongest column.
    rows : array, shape (v, r)
        The visible columns, those of one hypothesis orthogonal and one after another.
    first, seen : array of int, shape (m,)
        Where in ``rows`` those of each hypothesis begin, and how many it has.
    spectra : mapping of int to Spectrum
        Of each hypothesis that has an effect.
    """

    projector: Projector
    log_prior: FloatArray
    total: FloatArray
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
        return self.projector.dof

    @cached_property
    def unit_rows(self) -> FloatArray:
        """The visible columns as rows, unit vectors (v, r)."""
        return np.asarray(self.rows / np.sqrt((self.rows**2).sum(axis=1, keepdims=True)))

    def is_blind(self, j: int) -> bool:
        """Whether the base swallows all of hypothesis ``j``."""
        return bool(self.seen[j] == 0)

    def where(self, j: int) -> slice:
        """The rows of :attr:`rows` that are the visible columns of hypothesis ``j``."""
        return slice(int(self.first[j]), int(self.first[j] + self.seen[j]))

    def block(self, j: int) -> FloatArray:
        """Visible whitened columns of hypothesis ``j``, (r, v), orthogonal."""
        return self.rows[self.where(j)].T

    def left_out(self, members: Sequence[int], pose: IntArray) -> FloatArray:
        """Whitened residual of every data row when its pose is left out of the fit, (d,).

        ``members`` are fitted with the base, each held to its likeliest size; ``pose`` (d,)
        numbers the data rows' poses.
        """
        seen = [j for j in members if not self.is_blind(j)]
        base = self.projector.model
        if not seen:
            return left_out_residual(self.residual, base, pose)
        x = np.concatenate([self.block(j) for j in seen], axis=1)
        sizes = [int(self.seen[j]) for j in seen]
        gram, product = x.T @ x, x.T @ self.residual
        one = Sets(gram[None], product[None], np.array([self.chi2]), np.array([self.dof]),
                   tuple(sizes))
        taus, variance = likeliest_sizes(one)
        root = np.sqrt(variance[0]) / np.repeat(taus[0], sizes)
        solution = np.linalg.solve(gram + np.diag(root**2), product)
        residual = np.concatenate([self.residual - x @ solution, -root * solution])
        nothing = np.zeros((len(root), base.shape[1]))
        return left_out_residual(
            residual, np.block([[base, x], [nothing, np.diag(root)]]), pose
        )

    def space(self, members: Sequence[int]) -> FloatArray:
        """Orthonormal basis (r, k) of all that is visible of ``members``."""
        seen = [self.block(j) for j in members if not self.is_blind(j)]
        if not seen:
            return np.zeros((len(self.residual), 0))
        return orthonormal_columns(np.concatenate(seen, axis=1))

    def visible(self, j: int, beside: FloatArray) -> FloatArray:
        """Orthonormal rows (v, r) of what is visible of ``j`` beside a space (r, k)."""
        if beside.shape[1] == 0:  # they are orthogonal as they are
            return self.unit_rows[self.where(j)]
        block = self.block(j)
        return _orthonormal(block - beside @ (beside.T @ block)).T

    def _visible(
        self, which: Sequence[int], beside: FloatArray
    ) -> tuple[FloatArray, IntArray]:
        """:meth:`visible` of each of ``which``, one after another, and how many rows each has."""
        if beside.shape[1] == 0:
            count = self.seen[which]
            first = np.repeat(self.first[which] - (np.cumsum(count) - count), count)
            return self.unit_rows[first + np.arange(len(first))], count
        rows = [self.visible(j, beside) for j in which]
        return np.concatenate(rows), np.array([len(each) for each in rows])

    def shared_signal(
        self, j: int, others: Sequence[int], beside: Sequence[int]
    ) -> FloatArray:
        """Correlation of the signal of ``j``, fitted beside a set, with what each of ``others`` can
        make of it in its place, (others,).
        """
        q = self.space(beside)
        mine = self.visible(j, q)
        signal = mine.T @ (mine @ self.residual)
        signal /= max(float(np.linalg.norm(signal)), NO_LENGTH)
        return np.array([np.linalg.norm(self.visible(other, q) @ signal) for other in others])

    def correlations(self, j: int, others: Sequence[int], beside: Sequence[int]) -> FloatArray:
        """Least canonical correlation of ``j`` with each of ``others`` beside a set, (others,).

        Zero where they do not see equally many directions; an effect of the reference is compared
        with the part of the other one that it could be.
        """
        q = self.space(beside)
        mine = self.visible(j, q)
        least = np.zeros(len(others))
        if len(mine) < self.seen[j] or not others:
            return least
        theirs, count = self._visible(others, q)
        ends = np.cumsum(count)
        overlap = theirs @ mine.T
        shared = np.add.reduceat((overlap**2).sum(axis=1), ends - count)
        few = np.minimum(count, len(mine))
        alike = shared >= few * CONSTANTS.alias_correlation**2
        # What is fitted beside them may leave too little to compare.
        comparable = (few > 0) & (count == self.seen[others]) & ((count == len(mine)) | (few == 1))
        close = np.flatnonzero(alike & comparable)
        least[close] = np.sqrt(shared[close])  # of one direction
        close = close[few[close] > 1]  # which see as many as ``j``
        part = overlap[ends[close][:, None] - np.arange(len(mine), 0, -1)]
        least[close] = np.linalg.svd(part, compute_uv=False).min(axis=1, initial=1.0)
        return least


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of what is visible of ``columns``."""
    if columns.shape[1] == 0:
        return columns
    u, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, singular > VISIBLE_SHARE * max(float(singular.max()), NO_LENGTH)])
