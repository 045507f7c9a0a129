"""Every hypothesis at one table: their signatures at one solution, and the evidence of any set.

A table is made at a joint fit of the base and some effects. What those explained is put back into
the residual and what the base can absorb is projected out, so that every set, larger or smaller,
is weighed in closed form from the same Gram matrix. At a solution that explains the rows this
linearisation is right; at the base it is biased by what is missing, and screens only.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.hypotheses.signature import Projector, reference_columns, vector_columns
from calib.diagnosis.search.evidence import (
    block_log_densities,
    likeliest_sizes,
    nothing_log_density,
    set_log_density,
)
from calib.fit.column_scaling import RANK_TOLERANCE, orthonormal_columns
from calib.fit.identifiability import VISIBLE_SHARE
from calib.fit.leave_one_out import left_out_residual
from calib.fit.result import Fit
from calib.poses.imu_log import FloatArray, IntArray

NORM_FLOOR = 1e-9
"""Share of a block's largest column below which a column is zero."""


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
        raw, widths = _raw_columns(fit, hypotheses, self.projector.root)
        self.raw, self.raw_ends = raw, np.cumsum(widths)
        d = fit.equations.data_count
        norm = np.sqrt((raw**2).sum(axis=0))
        ends = np.cumsum(widths)
        for h, start, end in zip(hypotheses, ends - widths, ends, strict=True):
            part = norm[start:end]
            if h.effect is None:  # not parameters of their own units: their proportions count
                part[:] = np.where(part > 0, np.sqrt(np.mean(part**2)), 0.0)
            part[part <= NORM_FLOOR * max(float(part.max(initial=0.0)), 1e-300)] = np.inf
        count = np.add.reduceat(np.isfinite(norm), ends - widths) if len(widths) else widths
        unit = np.repeat([_unit_signal(h, d) for h in hypotheses], widths)
        unit = unit / np.sqrt(np.maximum(np.repeat(count, widths), 1))
        # Each combination of parameters of an effect is judged as the fit will judge it.
        whole = np.where([h.kind == "listed" for h in hypotheses], np.maximum(count, 1), 1)
        total = np.array([_unit_signal(h, d) for h in hypotheses]) / np.sqrt(whole)
        scaled = self.projector(raw / norm * unit)
        # One that was fitted was seen where its shape began; where that ended, less of it may be.
        least = np.where([h.shape is not None and h.name in members for h in hypotheses],
                         RANK_TOLERANCE, VISIBLE_SHARE) * total
        self.slices: list[slice] = [slice(0, 0)] * len(hypotheses)
        parts: list[FloatArray] = []
        at = 0
        for width in np.unique(widths[widths > 0]):
            which = np.flatnonzero(widths == width)
            index = (ends - widths)[which][:, None] + np.arange(width)
            stacked = scaled[:, index].transpose(1, 0, 2)
            squared, turns = np.linalg.eigh(stacked.transpose(0, 2, 1) @ stacked)
            visible = squared > least[which][:, None] ** 2
            turned = stacked @ turns
            for i, j in enumerate(which):
                part = turned[i][:, visible[i]]
                parts.append(part)
                self.slices[j] = slice(at, at + part.shape[1])
                at += part.shape[1]
        self.columns = (
            np.concatenate(parts, axis=1) if parts else np.zeros((len(self.residual), 0))
        )
        self.seen = np.array([s.stop - s.start for s in self.slices])
        self.total = total
        self.unit: dict[int, FloatArray] = {}

    def is_blind(self, j: int) -> bool:
        """Whether the base swallows all of hypothesis ``j``."""
        return bool(self.seen[j] == 0)

    def raw_block(self, j: int) -> FloatArray:
        """Columns of hypothesis ``j`` with nothing projected out, per unit of each parameter."""
        start = int(self.raw_ends[j - 1]) if j else 0
        return self.raw[:, start : self.raw_ends[j]]

    def block(self, j: int) -> FloatArray:
        """Visible columns of hypothesis ``j``, (r, v)."""
        return self.columns[:, self.slices[j]]

    def log_density(self, members: Sequence[int]) -> float:
        """Log density of the residual under the set of ``members``."""
        seen = [j for j in members if not self.is_blind(j)]
        if not seen:
            return float(np.logaddexp(*nothing_log_density(self.chi2, self.dof)))
        x = np.concatenate([self.block(j) for j in seen], axis=1)
        if x.shape[1] >= self.dof + len(seen):
            return -np.inf
        sizes = [int(self.seen[j]) for j in seen]
        return set_log_density(x.T @ x, x.T @ self.residual, self.chi2, self.dof, sizes)

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

    def beside(self, members: Sequence[int]) -> "Beside":
        """Every hypothesis beside the set of ``members``, whose space is projected out."""
        return beside(self, members)

    def correlations(self, j: int, others: Sequence[int], given: Sequence[int]) -> FloatArray:
        """Least canonical correlation of ``j`` with each of ``others`` beside ``given``.

        Zero where they do not see equally many directions; an effect of the reference is compared
        with the part of the other one that it could be.
        """
        q = _basis(self, given)

        def visible(k: int) -> FloatArray:
            block = self.block(k)
            if q.shape[1] == 0:  # its columns are orthogonal as they are
                if k not in self.unit:
                    self.unit[k] = np.asarray(block / np.sqrt((block**2).sum(axis=0)))
                return self.unit[k]
            return _orthonormal(block - q @ (q.T @ block))

        mine = visible(j)
        least = np.zeros(len(others))
        for i, other in enumerate(others):
            theirs = visible(other)
            few = min(mine.shape[1], theirs.shape[1])
            if mine.shape[1] < self.seen[j] or theirs.shape[1] < self.seen[other] or few == 0:
                continue  # what is fitted beside them leaves too little to compare
            overlap = mine.T @ theirs
            if (overlap**2).sum() >= few * CONSTANTS.alias_correlation**2:
                least[i] = np.linalg.svd(overlap, compute_uv=False)[:few].min()
            if mine.shape[1] != theirs.shape[1] and few > 1:
                least[i] = 0.0
        return least


def _raw_columns(
    fit: Fit, hypotheses: Sequence[Hypothesis], root: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Whitened, weighted columns of all hypotheses side by side (r, k), and how many each has."""
    errors = [None if h.on_reference else h.errors(fit) for h in hypotheses]
    vectors = [e for e in errors if e is not None]
    together = vector_columns(fit, np.concatenate(vectors, axis=2)) if vectors else None
    blocks, at = [], 0
    for h, e in zip(hypotheses, errors, strict=True):
        if e is None:
            assert h.effect is not None
            blocks.append(reference_columns(fit, h.effect))
            continue
        assert together is not None
        blocks.append(together[:, at : at + e.shape[2]])
        at += e.shape[2]
    d = fit.equations.data_count
    widths = np.array([block.shape[1] for block in blocks])
    raw = np.zeros((len(root), int(widths.sum())))
    raw[:d] = np.concatenate(blocks, axis=1) * root[:d, None]
    return raw, widths


def _unit_signal(hypothesis: Hypothesis, rows: int) -> float:
    """Length of the signal of unit size: one sd in every row, or four of a bad pose's own."""
    return CONSTANTS.bad_pose_size if hypothesis.kind == "bad_pose" else float(np.sqrt(rows))


def _basis(table: Table, members: Sequence[int]) -> FloatArray:
    seen = [table.block(j) for j in members if not table.is_blind(j)]
    if not seen:
        return np.zeros((len(table.residual), 0))
    return orthonormal_columns(np.concatenate(seen, axis=1))


def _orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of what is visible of ``columns``."""
    if columns.shape[1] == 0:
        return columns
    u, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, singular > VISIBLE_SHARE * max(float(singular.max()), 1e-300)])


@dataclass(frozen=True, eq=False)
class Beside:
    """Single hypotheses beside a set.

    ``log_factor`` (m,) is the log Bayes factor of each against nothing more, -inf where it is
    blind or in the set; ``drop`` (m,) what it takes off chi-square, ``seen`` (m,) the directions
    it has.
    """

    log_factor: FloatArray
    drop: FloatArray
    seen: FloatArray


def beside(table: Table, members: Sequence[int]) -> Beside:
    """See :meth:`Table.beside`."""
    q = _basis(table, members)
    residual = table.residual - q @ (q.T @ table.residual)
    chi2, dof = float(residual @ residual), table.dof - q.shape[1]
    columns = table.columns - q @ (q.T @ table.columns)
    product = columns.T @ residual
    m = len(table.seen)
    log_factor, drop, seen = np.full(m, -np.inf), np.zeros(m), np.zeros(m, int)
    nothing = float(np.logaddexp(*nothing_log_density(chi2, dof)))
    inside = np.isin(np.arange(m), members)
    for width in np.unique(table.seen[table.seen > 0]):
        which = np.flatnonzero((table.seen == width) & ~inside)
        if len(which) == 0:
            continue
        index = np.array([table.slices[j].start for j in which])[:, None] + np.arange(width)
        stacked = columns[:, index].transpose(1, 0, 2)
        squared, turns = np.linalg.eigh(stacked.transpose(0, 2, 1) @ stacked)
        visible = squared > (VISIBLE_SHARE * table.total[which][:, None]) ** 2
        strength = np.where(visible, np.sqrt(np.maximum(squared, 0.0)), 0.0)
        along = np.einsum("mji,mj->mi", turns, product[index])
        amplitude = np.where(visible, along / np.where(visible, strength, 1.0), 0.0)
        drop[which] = (amplitude**2).sum(axis=1)
        seen[which] = visible.sum(axis=1)
        density = block_log_densities(strength, amplitude, chi2, dof)
        log_factor[which] = np.where(visible.any(axis=1), density - nothing, -np.inf)
    return Beside(log_factor, drop, seen)


def pair_scores(table: Table, candidates: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Every pair of ``candidates``, the best first: indices (k, 2) and scores (k,).

    The score is the Bayesian information criterion with the scatter free above the stated noise,
    as a log density, and the priors; the pair's drop of chi-square comes from the block inverse.
    """
    seen = [j for j in candidates if not table.is_blind(j)]
    m = len(seen)
    widest = max((int(table.seen[j]) for j in seen), default=0)
    basis = np.zeros((m, len(table.residual), widest))
    for i, j in enumerate(seen):
        block = table.block(j)
        basis[i, :, : block.shape[1]] = block / np.sqrt((block**2).sum(axis=0))
    amplitude = np.einsum("mrv,r->mv", basis, table.residual)
    first, second = np.triu_indices(m, 1)
    overlap = np.einsum("rx,ry->xy", *(2 * [basis.transpose(1, 0, 2).reshape(-1, m * widest)]))
    overlap = overlap.reshape(m, widest, m, widest).transpose(0, 2, 1, 3)[first, second]
    rest = amplitude[second] - np.einsum("kvw,kv->kw", overlap, amplitude[first])
    inner = np.eye(widest) * (1 + 1e-6) - overlap.transpose(0, 2, 1) @ overlap
    more = (rest * np.linalg.solve(inner, rest[:, :, None])[:, :, 0]).sum(axis=1)
    chi2 = np.maximum(table.chi2 - (amplitude[first] ** 2).sum(axis=1) - more, 0.0)
    size = np.array([table.seen[j] for j in seen])
    p = size[first] + size[second]
    dof = np.maximum(table.dof - p, 1)
    variance = np.maximum(chi2 / dof, 1.0)
    score = -0.5 * (table.dof * np.log(variance) + chi2 / variance + p * np.log(table.dof))
    prior = table.log_prior[seen]
    score = score + prior[first] + prior[second]
    score[table.dof - p < CONSTANTS.fewest_dof] = -np.inf
    order = np.argsort(-score, kind="stable")
    pairs = np.column_stack([np.array(seen)[first], np.array(seen)[second]])
    return pairs[order], score[order]
