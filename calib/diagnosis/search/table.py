"""Every hypothesis at one table: their signatures at one solution, and the evidence of any set.

A table is made at a joint fit of the base and some effects. What those explained is put back into
the residual and what the base can absorb is projected out, so that every set, larger or smaller,
is weighed in closed form from the same Gram matrix. At a solution that explains the rows this
linearisation is right; at the base it is biased by what is missing, and screens only.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Projector
from calib.diagnosis.search.evidence import likeliest_sizes, nothing_log_density, set_log_density
from calib.diagnosis.search.raw_columns import RawColumns
from calib.fit.column_scaling import RANK_TOLERANCE, orthonormal_columns
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.validation.leave_one_out import left_out_residual
from calib.poses.imu_log import FloatArray, IntArray

NORM_FLOOR = 1e-9
"""Share of a block's largest column below which a column is zero: rounding."""


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


class Table:
    """The hypotheses' visible columns at one solution.

    Parameters
    ----------
    fit : Fit
        The joint fit.
    hypotheses : sequence of Hypothesis
    members : sequence of str
        Names of the effects of ``fit`` that are on trial.
    """

    def __init__(
        self, fit: Fit, hypotheses: Sequence[Hypothesis], members: Sequence[str] = ()
    ) -> None:
        self.projector = Projector(fit, members)
        self.residual, self.chi2 = self.projector.residual, self.projector.chi2
        self.dof = self.projector.dof
        self.log_prior = np.array([h.log_prior for h in hypotheses])
        raw = RawColumns.of(fit, hypotheses, self.projector.root)
        unit, self.total = _units(raw, hypotheses, fit.equations.data_count)
        projected = raw.rows * unit[:, None]
        projected -= (projected @ self.projector.model) @ self.projector.model.T
        # One that was fitted was seen where its shape began; where that ended, less of it may be.
        least = np.where([h.shape is not None and h.name in members for h in hypotheses],
                         RANK_TOLERANCE, VISIBLE_SHARE) * self.total
        m = len(hypotheses)
        self.spectra: dict[int, Spectrum] = {}
        self.first, self.seen = np.zeros((2, m), int)
        parts = [np.zeros((0, len(self.residual)))]
        for width in np.unique(raw.width[raw.width > 0]):
            which = np.flatnonzero(raw.width == width)
            index = raw.start[which][:, None] + np.arange(width)
            stacked = projected[index]
            squared, turns = np.linalg.eigh(stacked @ stacked.transpose(0, 2, 1))
            turned = turns.transpose(0, 2, 1) @ stacked
            visible = squared > least[which][:, None] ** 2
            self.seen[which] = visible.sum(axis=1)
            before = sum(map(len, parts))
            self.first[which] = before + np.cumsum(self.seen[which]) - self.seen[which]
            parts.append(turned[visible])
            along = turned @ self.residual
            for i, j in enumerate(map(int, which)):
                if hypotheses[j].effect is not None:
                    self.spectra[j] = Spectrum(
                        turns[i], squared[i], along[i], unit[index[i]]
                    )
        self.rows = np.concatenate(parts)

    @cached_property
    def unit_rows(self) -> FloatArray:
        """The visible columns as rows of length one."""
        return np.asarray(self.rows / np.sqrt((self.rows**2).sum(axis=1, keepdims=True)))

    def is_blind(self, j: int) -> bool:
        """Whether the base swallows all of hypothesis ``j``."""
        return bool(self.seen[j] == 0)

    def where(self, j: int) -> slice:
        """The rows of :attr:`rows` that are the visible columns of hypothesis ``j``."""
        return slice(int(self.first[j]), int(self.first[j] + self.seen[j]))

    def block(self, j: int) -> FloatArray:
        """Visible columns of hypothesis ``j``, (r, v), orthogonal."""
        return self.rows[self.where(j)].T

    def log_density(self, members: Sequence[int]) -> float:
        """Log density of the residual under the set of ``members``."""
        seen = [j for j in members if not self.is_blind(j)]
        if not seen:
            return float(np.logaddexp(*nothing_log_density(self.chi2, self.dof)))
        x = np.concatenate([self.rows[self.where(j)] for j in seen])
        if len(x) >= self.dof + len(seen):
            return -np.inf
        sizes = [int(self.seen[j]) for j in seen]
        return set_log_density(x @ x.T, x @ self.residual, self.chi2, self.dof, sizes)

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
        taus, variance = likeliest_sizes(gram, product, self.chi2, self.dof, sizes)
        root = np.sqrt(variance) / np.repeat(taus, sizes)
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

    def correlations(self, j: int, others: Sequence[int], beside: Sequence[int]) -> FloatArray:
        """Least canonical correlation of ``j`` with each of ``others`` beside a set.

        Zero where they do not see equally many directions; an effect of the reference is compared
        with the part of the other one that it could be.
        """
        q = self.space(beside)

        def visible(k: int) -> FloatArray:
            if q.shape[1] == 0:  # they are orthogonal as they are
                return self.unit_rows[self.where(k)]
            block = self.block(k)
            return _orthonormal(block - q @ (q.T @ block)).T

        mine = visible(j)
        least = np.zeros(len(others))
        if len(mine) < self.seen[j] or not others:
            return least
        theirs = [visible(other) for other in others]
        count = np.array([len(each) for each in theirs])
        ends = np.cumsum(count)
        overlap = np.concatenate(theirs) @ mine.T
        shared = np.add.reduceat((overlap**2).sum(axis=1), ends - count)
        few = np.minimum(count, len(mine))
        alike = shared >= few * CONSTANTS.alias_correlation**2
        # What is fitted beside them may leave too little to compare.
        comparable = (few > 0) & (count == self.seen[others]) & ((count == len(mine)) | (few == 1))
        for i in np.flatnonzero(alike & comparable):
            part = overlap[ends[i] - count[i] : ends[i]]
            least[i] = np.linalg.svd(part, compute_uv=False)[: few[i]].min()
        return least


def _units(
    raw: RawColumns, hypotheses: Sequence[Hypothesis], rows: int
) -> tuple[FloatArray, FloatArray]:
    """Factor of every raw column (c,), and the signal of each hypothesis's strongest column (m,).

    All columns of a hypothesis together then have the signal of unit size.
    """
    owner, m = raw.owner, len(hypotheses)
    squared = (raw.rows**2).sum(axis=1)
    has_effect = np.array([h.effect is not None for h in hypotheses], bool)
    # Not parameters of their own units: their proportions count.
    mean = np.bincount(owner, squared, m) / np.maximum(raw.width, 1)
    norm = np.sqrt(np.where(has_effect[owner] | (squared == 0), squared, mean[owner]))
    largest = np.zeros(m)
    np.maximum.at(largest, owner, norm)
    norm[norm <= NORM_FLOOR * np.maximum(largest, 1e-300)[owner]] = np.inf
    count = np.maximum(np.bincount(owner, np.isfinite(norm), m), 1)
    signal = np.array([_unit_signal(h, rows) for h in hypotheses])
    unit = (signal / np.sqrt(count))[owner] / norm
    # Each combination of parameters of an effect is judged as the fit will judge it.
    whole = np.where([h.kind == "listed" for h in hypotheses], count, 1)
    return unit, signal / np.sqrt(whole)


def _unit_signal(hypothesis: Hypothesis, rows: int) -> float:
    """Length of the signal of unit size: one sd in every row, or four of a bad pose's own."""
    return CONSTANTS.bad_pose_size if hypothesis.kind == "bad_pose" else float(np.sqrt(rows))


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of what is visible of ``columns``."""
    if columns.shape[1] == 0:
        return columns
    u, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, singular > VISIBLE_SHARE * max(float(singular.max()), 1e-300)])
