"""An unknown function in the place of a listed effect that it looks like.

Effects that explain the rows stand for whatever looks like them. Where they leave a misfit, either
something else is there too, or the largest of them is none: a function of the same quantity, which
is as likely to look like any effect, leaves of itself what no noise explains.
"""

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import held
from calib.diagnosis.search.candidates import Candidates
from calib.diagnosis.search.entry import Entry
from calib.diagnosis.search.table import Table


def imitation(table: Table, candidates: Candidates, entry: Entry) -> Entry | None:
    """The set of ``entry`` with an unknown function in the place of its largest effect.

    None where its refit explains the rows, or leaves more than that effect takes. ``table`` is
    that of all hypotheses at the base.
    """
    joint, hypotheses = entry.refit, candidates.hypotheses
    if joint is None or joint.explains:
        return None
    signal = [joint.signal([held(hypotheses[j], j).name], table.projector) for j in entry.members]
    size = [float(each @ each) for each in signal]
    largest = entry.members[int(np.argmax(size))]
    instead = next((j for j, h in enumerate(hypotheses)
                    if h.follows and h.follows == hypotheses[largest].covariate), None)
    odds = table.noise.log_odds_unlike(joint.fit.chi2, table.chi2)
    if instead is None or odds == -np.inf or max(size) < joint.fit.chi2:
        return None
    listed = {h.name for h in hypotheses if h.kind == "listed" and not h.is_placed}
    odds += float(np.log(CONSTANTS.odds_unknown / len(listed))) - hypotheses[largest].log_prior
    members = {*entry.members, instead} - {largest}
    return Entry(tuple(sorted(members)), entry.log_posterior + odds)
