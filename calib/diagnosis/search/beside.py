"""Sets one larger than another, and pairs: what is weighed of all hypotheses at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.evidence import block_log_densities, nothing_log_density
from calib.diagnosis.search.table import Table
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Beside:
    """Single hypotheses beside a set.

    ``log_factor`` (m,) is the log Bayes factor of each against nothing more, -inf where it is
    blind or in the set; ``drop`` (m,) what it takes off chi-square.
    """

    log_factor: FloatArray
    drop: FloatArray


@dataclass(frozen=True, eq=False)
class BesideSets:
    """Asks for every hypothesis of ``table`` beside each of ``sets``."""

    table: Table
    sets: Sequence[Sequence[int]]


@dataclass(frozen=True, eq=False)
class _Remaining:
    """What the space of one set leaves of a table: rows (v, r), their products with what it leaves
    of the residual (v,), that one's chi-square and degrees of freedom.

    ``outside`` (m,) are the hypotheses that are not in the set, ``turned`` says whether the rows of
    a hypothesis are no longer orthogonal.
    """

    table: Table
    rows: FloatArray
    product: FloatArray
    chi2: float
    dof: int
    outside: BoolArray
    turned: bool

    @classmethod
    def of(cls, table: Table, members: Sequence[int]) -> "_Remaining":
        q = table.space(members)
        residual = table.residual - q @ (q.T @ table.residual)
        rows = table.rows - (table.rows @ q) @ q.T if q.shape[1] else table.rows
        outside = table.seen > 0
        outside[list(members)] = False
        return cls(table, rows, rows @ residual, float(residual @ residual),
                   table.dof - q.shape[1], outside, bool(q.shape[1]))


def besides(requests: Sequence[BesideSets]) -> list[list[Beside]]:
    """Every hypothesis beside the sets of each request, the set's space projected out.

    Parameters
    ----------
    requests : sequence of BesideSets
        Of tables with equally many rows.

    Returns
    -------
    list of list of Beside
        One for each set of each request.
    """
    rests = [_Remaining.of(each.table, members) for each in requests for members in each.sets]
    nothing = [float(np.logaddexp(*nothing_log_density(each.chi2, each.dof))) for each in rests]
    weighed = [
        Beside(np.full(len(each.outside), -np.inf), np.zeros(len(each.outside))) for each in rests
    ]
    for turned in (False, True):
        some = [i for i, each in enumerate(rests) if each.turned == turned]
        widths = {int(k) for i in some for k in rests[i].table.seen[rests[i].outside]}
        for width in sorted(widths):
            _weigh(width, [(rests[i], nothing[i], weighed[i]) for i in some])
    ends = iter(weighed)
    return [[next(ends) for _ in each.sets] for each in requests]


def _weigh(width: int, cases: Sequence[tuple[_Remaining, float, Beside]]) -> None:
    """Weigh the hypotheses of ``width`` visible columns in all ``cases``, and note it there."""
    which = [np.flatnonzero((each.table.seen == width) & each.outside) for each, _, _ in cases]
    count = [len(part) for part in which]
    index = [each.table.first[part][:, None] + np.arange(width)
             for (each, _, _), part in zip(cases, which, strict=True)]
    along = np.concatenate([each.product[i] for (each, _, _), i in zip(cases, index, strict=True)])
    stacked = np.concatenate([each.rows[i] for (each, _, _), i in zip(cases, index, strict=True)])
    if width == 1 or not cases[0][0].turned:  # orthogonal as they are
        squared = (stacked**2).sum(axis=2)
    else:
        squared, turns = np.linalg.eigh(stacked @ stacked.transpose(0, 2, 1))
        along = (turns.transpose(0, 2, 1) @ along[:, :, None])[:, :, 0]
    total = np.concatenate([each.table.total[part]
                            for (each, _, _), part in zip(cases, which, strict=True)])
    visible = squared > (VISIBLE_SHARE * total[:, None]) ** 2
    strength = np.where(visible, np.sqrt(np.maximum(squared, 0.0)), 0.0)
    amplitude = np.where(visible, along / np.where(visible, strength, 1.0), 0.0)
    drop = (amplitude**2).sum(axis=1)
    chi2 = np.repeat([each.chi2 for each, _, _ in cases], count)
    dof = np.repeat([each.dof for each, _, _ in cases], count)
    density = block_log_densities(strength, amplitude, chi2, dof)
    factor = density - np.repeat([nothing for _, nothing, _ in cases], count)
    factor[~visible.any(axis=1)] = -np.inf
    end = 0
    for (_, _, weighed), part in zip(cases, which, strict=True):
        weighed.drop[part] = drop[end : end + len(part)]
        weighed.log_factor[part] = factor[end : end + len(part)]
        end += len(part)


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
