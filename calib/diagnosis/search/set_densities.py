"""Log densities of the residual under sets of hypotheses of many tables, those alike together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.search.evidence import Sets, nothing_log_density, set_log_densities
from calib.diagnosis.search.table import Table


@dataclass(frozen=True, eq=False)
class SetDensities:
    """Asks for the log density of the residual under each of ``sets`` of hypotheses of ``table``.
    """

    table: Table
    sets: Sequence[Sequence[int]]


def set_densities(requests: Sequence[SetDensities]) -> list[list[float]]:
    """The log density under every set of every request.

    -inf where a set has as many columns as there are degrees of freedom.
    """
    values = [[-np.inf] * len(each.sets) for each in requests]
    by_sizes: dict[tuple[int, ...], list[tuple[int, int]]] = {}
    for i, each in enumerate(requests):
        for j, members in enumerate(each.sets):
            sizes = tuple(int(k) for k in each.table.seen[list(members)] if k)
            if not sizes:
                nothing = nothing_log_density(each.table.chi2, each.table.dof)
                values[i][j] = float(np.logaddexp(*nothing))
            elif sum(sizes) < each.table.dof + len(sizes):
                by_sizes.setdefault(sizes, []).append((i, j))
    for sizes, places in by_sizes.items():
        stack = sets_of([(requests[i].table, requests[i].sets[j]) for i, j in places], sizes)
        for (i, j), value in zip(places, set_log_densities(stack), strict=True):
            values[i][j] = float(value)
    return values


def sets_of(cases: Sequence[tuple[Table, Sequence[int]]], sizes: tuple[int, ...]) -> Sets:
    """Tables with sets of their hypotheses, whose numbers of visible columns are ``sizes``."""
    x = [np.concatenate([table.rows[table.where(j)] for j in members]) for table, members in cases]
    return Sets(
        gram=np.array([each @ each.T for each in x]),
        product=np.array(
            [each @ table.residual for each, (table, _) in zip(x, cases, strict=True)]
        ),
        chi2=np.array([table.chi2 for table, _ in cases]),
        dof=np.array([table.dof for table, _ in cases]),
        sizes=sizes,
    )
