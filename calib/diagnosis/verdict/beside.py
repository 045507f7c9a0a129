"""What may be missing beside what a verdict names."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.entry import Inclusion
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.table import Table


def beside(posterior: Posterior, named: Sequence[Inclusion]) -> tuple[Inclusion, ...]:
    """What else may be missing, its probability not small.

    What has no name may be all that an effect seems to take: an unknown function is any function
    of its quantity, and where the rows keep a misfit an effect has the odds of its share of that.
    """
    known = {name for each in named for name in each.members}
    functions = {each.follows for each in named} - {None}
    others = [
        replace(each, probability=each.probability * _share_beside(posterior, each))
        if each.kind == "listed" else each for each in posterior.inclusion
        if each.name not in known
        and not (each.kind == "listed" and posterior.first[each.name].covariate in functions)]
    return tuple(each for each in others if each.probability >= 1 - CONSTANTS.sure)


def _share_beside(posterior: Posterior, each: Inclusion) -> float:
    """Part of the variance beyond noise that one more takes, in the likeliest set that has it."""
    whole = next(e.members for e in posterior.ordered
                 if not posterior.names(e).isdisjoint(each.members))
    rest = [j for j in whole if posterior.hypotheses[j].name not in each.members]
    before, after = (_beyond_noise(posterior.at_solution, some) for some in (rest, whole))
    return max(1 - after / before, 0.0) if 0 < before < np.inf else 1.0


def _beyond_noise(table: Table, members: Sequence[int]) -> float:
    """Variance that ``members`` leave beyond noise; infinite where no row is left to tell."""
    blocks = [np.zeros((len(table.residual), 0)), *(table.unit_block(j) for j in members)]
    basis = np.linalg.qr(np.concatenate(blocks, axis=1))[0]
    dof = table.dof - basis.shape[1]
    if dof < CONSTANTS.fewest_dof:
        return np.inf
    rest = table.chi2 - float(np.sum((basis.T @ table.residual) ** 2))
    return float(max(rest / dof - 1, 0.0))
