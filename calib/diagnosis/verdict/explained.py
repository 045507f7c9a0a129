"""How much of the misfit the leading set explains, and whether it predicts poses left out."""

from collections.abc import Sequence

import numpy as np

from calib.diagnosis.search.odds import Inclusion, Odds
from calib.diagnosis.search.refit import Refit
from calib.diagnosis.search.sets import Search
from calib.fit.least_squares.result import Fit
from calib.fit.validation.leave_one_out import compare
from calib.poses.imu_log import FloatArray

HOLDING = 3
"""Refits beside that of the leading set that are asked what they predict: a limit of time. One
and six change none of 55 verdicts (``tests.bench.diagnosis_thresholds``)."""


def explained(state: Search, odds: Odds) -> tuple[float, bool]:
    """Part of the misfit that the leading set takes, and whether noise explains the rest."""
    whole = misfit(state.base)
    joint = odds.lead.refit
    if joint is None or whole <= 0:
        return 0.0, False
    share = 1 - max(misfit(joint.fit), 0.0) / whole
    return max(share, 0.0), bool(joint.explains and odds.lead.whole)


def misfit(fit: Fit) -> float:
    """Chi-square above its degrees of freedom."""
    return float(fit.weight @ fit.rows.residual**2) - fit.dof


def signal_rows(state: Search, joint: Refit, name: str) -> FloatArray:
    """What an effect of ``joint`` explains, whitened, the model projected out, (r,)."""
    where = joint.fit.model.slices()[name]
    rows = joint.fit.rows.jacobian[:, where] @ joint.fit.theta[where]
    model = state.table.projector.model
    return np.asarray(rows - model @ (model.T @ rows))


def predicted_share(state: Search, odds: Odds, named: Sequence[Inclusion]) -> float:
    """Part of the misfit that the leading set takes if it lowers the leave-one-out error.

    Otherwise that of the likeliest refit that lowers it, and in which a named effect is the
    largest: what is unsure beside it may be too much for the rows. 0 where there is none.
    """
    before, whole = compare(state.base).loo_rms, misfit(state.base)
    if whole <= 0:
        return 0.0
    names = {each.name for each in named}
    key = state.key(j for j in odds.lead.members if state.hypotheses[j].name in names)
    holding = [e for k, e in state.entries.items() if e.whole and e.refit and k & key == key]
    holding.sort(key=lambda e: -e.log_posterior)
    joints = [e.refit for e in holding[:HOLDING] if e.refit and _largest(state, e.refit) in names]
    for joint in (odds.lead.refit, *joints):
        if joint is not None and compare(joint.fit).loo_rms < before:
            return max(1 - max(misfit(joint.fit), 0.0) / whole, 0.0)
    return 0.0


def _largest(state: Search, joint: Refit) -> str:
    """The effect of ``joint`` that explains most."""
    return max(joint.names, key=lambda name: float((signal_rows(state, joint, name) ** 2).sum()))
