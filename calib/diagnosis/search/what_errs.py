"""What of the reading an unknown function is: the bias, the gain, or the error of each axis.

All functions of one quantity have one name in the search, since any of them is without a name in
the catalogue. Where the rows tell which of them it is, a reader learns it.
"""

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.candidates import Candidates, Members
from calib.diagnosis.search.table import Table


def what_errs(table: Table, candidates: Candidates, members: Members, name: str) -> str:
    """What errs by the function ``name`` in the set ``members``; empty where that is not sure.

    Every form of it is weighed in its place among the others at ``table``.
    """
    hypotheses = candidates.hypotheses
    others = tuple(j for j in members if hypotheses[j].name != name)
    forms = [(j, h.course.errs) for j, h in enumerate(hypotheses)
             if h.name == name and h.course is not None]
    sets = [(*others, j) for j, _ in forms]
    weight = table.batch(sets).averaged(range(len(sets))) + candidates.log_prior(sets)
    least = np.logaddexp.reduce(weight) + np.log(CONSTANTS.sure)
    kinds = dict.fromkeys(errs for _, errs in forms)
    of_kind = {kind: [one for one, (_, errs) in zip(weight, forms, strict=True) if errs == kind]
               for kind in kinds}
    return next((kind for kind in kinds if np.logaddexp.reduce(of_kind[kind]) > least), "")
