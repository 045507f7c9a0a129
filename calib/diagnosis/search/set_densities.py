"""Log densities of the residual under sets of hypotheses of a table."""

from collections.abc import Sequence

import numpy as np

from calib.diagnosis.search.evidence import Sets, nothing_log_density, set_log_densities
from calib.diagnosis.search.table import Table


def set_densities(table: Table, sets: Sequence[Sequence[int]]) -> list[float]:
    """The log density of the residual under every set.

    -inf where a set has as many columns as there are degrees of freedom.
    """
    values = [-np.inf] * len(sets)
    by_sizes: dict[tuple[int, ...], list[int]] = {}
    for i, members in enumerate(sets):
        sizes = tuple(int(k) for k in table.seen[list(members)] if k)
        if not sizes:
            values[i] = float(np.logaddexp(*nothing_log_density(table.chi2, table.dof)))
        elif sum(sizes) < table.dof + len(sizes):
            by_sizes.setdefault(sizes, []).append(i)
    for sizes, places in by_sizes.items():
        stack = sets_of(table, [sets[i] for i in places], sizes)
        for i, value in zip(places, set_log_densities(stack), strict=True):
            values[i] = float(value)
    return values


def sets_of(table: Table, sets: Sequence[Sequence[int]], sizes: tuple[int, ...]) -> Sets:
    """Sets of hypotheses of a table, whose numbers of visible columns are ``sizes``."""
    x = np.array([np.concatenate([table.rows[table.where(j)] for j in members])
                  for members in sets])
    return Sets(
        gram=x @ x.swapaxes(1, 2),
        product=x @ table.residual,
        chi2=np.full(len(sets), table.chi2),
        dof=np.full(len(sets), table.dof),
        sizes=sizes,
    )
