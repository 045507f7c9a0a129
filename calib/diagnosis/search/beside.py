"""Sets one larger than another, and pairs: what is weighed of all hypotheses at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.evidence import block_log_densities, nothing_log_density
from calib.diagnosis.search.table import Table
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Beside:
    """Single hypotheses beside a set.

    ``log_factor`` (m,) is the log Bayes factor of each against nothing more, -inf where it is
    blind or in the set; ``drop`` (m,) what it takes off chi-square.
    """

    log_factor: FloatArray
    drop: FloatArray


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


def besides(table: Table, sets: Sequence[Sequence[int]]) -> list[Beside]:
    """Every hypothesis of a table beside each of ``sets``, the set's space projected out."""
    rests = [_Remaining.of(table, members) for members in sets]
    nothing = [float(np.logaddexp(*nothing_log_density(each.chi2, each.dof))) for each in rests]
    weighed = [
        Beside(np.full(len(each.outside), -np.inf), np.zeros(len(each.outside))) for each in rests
    ]
    for turned in (False, True):
        some = [i for i, each in enumerate(rests) if each.turned == turned]
        widths = sorted({int(k) for i in some for k in rests[i].table.seen[rests[i].outside]})
        for alike in _grouped(widths):
            _weigh(alike, [(rests[i], nothing[i], weighed[i]) for i in some])
    return weighed


def _grouped(widths: Sequence[int]) -> list[list[int]]:
    """Ascending ``widths``, those side by side that differ by less than four times."""
    groups: list[list[int]] = []
    for width in widths:
        if groups and width < 4 * groups[-1][0]:
            groups[-1].append(width)
        else:
            groups.append([width])
    return groups


def _weigh(widths: Sequence[int], cases: Sequence[tuple[_Remaining, float, Beside]]) -> None:
    """Weigh the hypotheses of these numbers of visible columns in all ``cases``, and note it there.
    """
    signals = [_Signals.of(width, [rest for rest, _, _ in cases]) for width in widths]
    case = np.concatenate([each.case for each in signals])
    which = np.concatenate([each.which for each in signals])
    # Zeros stand for the columns that the narrower ones lack.
    strength, amplitude = np.zeros((2, len(which), widths[-1]))
    ends = np.cumsum([len(each.which) for each in signals])
    for each, end in zip(signals, ends.tolist(), strict=True):
        rows, width = slice(end - len(each.which), end), each.strength.shape[1]
        strength[rows, :width], amplitude[rows, :width] = each.strength, each.amplitude
    chi2, dof, nothing = (
        np.array(each)[case] for each in zip(
            *((rest.chi2, rest.dof, density) for rest, density, _ in cases), strict=True
        )
    )
    factor = block_log_densities(strength, amplitude, chi2, dof) - nothing
    factor[~strength.any(axis=1)] = -np.inf
    drop = (amplitude**2).sum(axis=1)
    for i, (_, _, weighed) in enumerate(cases):
        weighed.drop[which[case == i]] = drop[case == i]
        weighed.log_factor[which[case == i]] = factor[case == i]


@dataclass(frozen=True, eq=False)
class _Signals:
    """What hypotheses of equally many visible columns show beside the sets of several cases.

    ``case`` and ``which`` (m,) say whose and which hypothesis each is; ``strength`` and
    ``amplitude`` (m, v) are what :func:`block_log_densities` takes.
    """

    case: IntArray
    which: IntArray
    strength: FloatArray
    amplitude: FloatArray

    @classmethod
    def of(cls, width: int, rests: Sequence[_Remaining]) -> "_Signals":
        """Those of the hypotheses of ``width`` visible columns."""
        which = [np.flatnonzero((each.table.seen == width) & each.outside) for each in rests]
        index = [each.table.first[part][:, None] + np.arange(width)
                 for each, part in zip(rests, which, strict=True)]
        along = np.concatenate([each.product[i] for each, i in zip(rests, index, strict=True)])
        rows = np.concatenate([each.rows[i] for each, i in zip(rests, index, strict=True)])
        if width == 1 or not rests[0].turned:  # orthogonal as they are
            squared = (rows**2).sum(axis=2)
        else:
            squared, turns = np.linalg.eigh(rows @ rows.transpose(0, 2, 1))
            along = (turns.transpose(0, 2, 1) @ along[:, :, None])[:, :, 0]
        total = np.concatenate([each.table.total[part]
                                for each, part in zip(rests, which, strict=True)])
        visible = squared > (VISIBLE_SHARE * total[:, None]) ** 2
        strength = np.where(visible, np.sqrt(np.maximum(squared, 0.0)), 0.0)
        case = np.repeat(np.arange(len(rests)), [len(part) for part in which])
        return cls(case, np.concatenate(which), strength,
                   np.where(visible, along / np.where(visible, strength, 1.0), 0.0))


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
