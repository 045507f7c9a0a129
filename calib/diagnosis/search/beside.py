"""Sets one larger than another, and pairs: what is weighed of all hypotheses at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.evidence import block_log_densities, nothing_log_density
from calib.diagnosis.search.table import Table
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Beside:
    """Single hypotheses beside a set.

    ``log_factor`` (m,) is the log Bayes factor of each against nothing more, -inf where it is
    blind or in the set; ``drop`` (m,) what it takes off chi-square.
    """

    log_factor: FloatArray
    drop: FloatArray


def beside(table: Table, members: Sequence[int]) -> Beside:
    """Every hypothesis beside the set of ``members``, whose space is projected out."""
    q = table.space(members)
    residual = table.residual - q @ (q.T @ table.residual)
    chi2, dof = float(residual @ residual), table.dof - q.shape[1]
    rows = table.rows - (table.rows @ q) @ q.T if q.shape[1] else table.rows
    product = rows @ residual
    m = len(table.seen)
    log_factor, drop = np.full(m, -np.inf), np.zeros(m)
    nothing = float(np.logaddexp(*nothing_log_density(chi2, dof)))
    outside = np.ones(m, bool)
    outside[list(members)] = False
    for width in np.unique(table.seen[table.seen > 0]):
        which = np.flatnonzero((table.seen == width) & outside)
        if len(which) == 0:
            continue
        index = table.first[which][:, None] + np.arange(width)
        along = product[index]
        if width == 1 or not q.shape[1]:  # orthogonal as they are
            squared = (rows[index] ** 2).sum(axis=2)
        else:
            stacked = rows[index]
            squared, turns = np.linalg.eigh(stacked @ stacked.transpose(0, 2, 1))
            along = (turns.transpose(0, 2, 1) @ along[:, :, None])[:, :, 0]
        visible = squared > (VISIBLE_SHARE * table.total[which][:, None]) ** 2
        strength = np.where(visible, np.sqrt(np.maximum(squared, 0.0)), 0.0)
        amplitude = np.where(visible, along / np.where(visible, strength, 1.0), 0.0)
        drop[which] = (amplitude**2).sum(axis=1)
        density = block_log_densities(strength, amplitude, chi2, dof)
        log_factor[which] = np.where(visible.any(axis=1), density - nothing, -np.inf)
    return Beside(log_factor, drop)


def pair_scores(table: Table, candidates: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Every pair of ``candidates``, the best first: indices (k, 2) and scores (k,).

    The score is the Bayesian information criterion with the scatter free above the stated noise,
    as a log density, and the priors; the pair's drop of chi-square comes from the block inverse.
    """
    seen = [j for j in candidates if not table.is_blind(j)]
    m = len(seen)
    widest = max((int(table.seen[j]) for j in seen), default=0)
    basis = np.zeros((m, widest, len(table.residual)))
    for i, j in enumerate(seen):
        basis[i, : int(table.seen[j])] = table.unit_rows[table.where(j)]
    amplitude = basis @ table.residual
    first, second = np.triu_indices(m, 1)
    flat = basis.reshape(m * widest, -1)
    overlap = (flat @ flat.T).reshape(m, widest, m, widest).transpose(0, 2, 1, 3)[first, second]
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
