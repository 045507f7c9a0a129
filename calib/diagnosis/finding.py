"""Result of a search on one fit: the verdict, without its report.

:mod:`calib.diagnosis.diagnose` makes of a finding what a reader needs beside it: the ranking, the
words, and what to record next.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.courses import by_clock, scattering_rates, scatters_too_much
from calib.diagnosis.hypotheses.listed import Hypothesis, listed_hypotheses
from calib.diagnosis.hypotheses.unlisted import unknown_hypotheses
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.search import search
from calib.diagnosis.search.table import Table
from calib.diagnosis.verdict.decision import Verdict, reach_verdict
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import Triad

LEAST_TYPICAL = 0.01
"""Sds, over all rows together, that the largest size quoted for an effect must leave. Derived:
sizes of parts differ by a factor of thirty, so that what shows at a hundred times the largest is
hardly this effect."""


@dataclass(frozen=True, eq=False)
class Finding:
    """Verdict on one fit, and the probabilities behind it.

    Parameters
    ----------
    posterior : Posterior
    verdict : Verdict
    unavailable : dict
        Listed effects that could not be evaluated, and why.
    """

    posterior: Posterior
    verdict: Verdict
    unavailable: dict[str, str]

    @property
    def absurd(self) -> frozenset[str]:
        """Effects that these poses show only at a size that no part has."""
        one_of = self.posterior
        triad = one_of.base.poses.triad
        return frozenset(h.name for j, h in enumerate(one_of.hypotheses)
                         if h.kind == "listed" and _shows_at_no_size(one_of.table, j, h, triad))

    @property
    def blind(self) -> tuple[str, ...]:
        """Listed effects that these poses cannot see, whatever their shape."""
        is_blind: dict[str, bool] = {}
        for j, h in enumerate(self.posterior.hypotheses):
            if h.kind == "listed":
                is_blind[h.name] = is_blind.get(h.name, True) and self.posterior.table.is_blind(j)
        return tuple(name for name, blind in is_blind.items() if blind)


def _shows_at_no_size(table: Table, j: int, h: Hypothesis, triad: Triad) -> bool:
    """Whether the rows show effect ``j`` only at a size that no part has."""
    if h.effect is None or h.effect.in_square or table.is_blind(j):
        return False
    sizes = [quoted.si_for(triad) for quoted in h.effect.page.typical.values()]
    largest = max((size for size in sizes if size is not None), default=np.inf)
    each = table.spectra[j]
    per_size = np.divide(np.sqrt(each.turns**2 @ np.maximum(each.squared, 0.0)), each.unit,
                         where=each.unit > 0, out=np.zeros_like(each.unit))
    return bool(largest * per_size.max() < LEAST_TYPICAL)


def find(
    fit: Fit, user_effects: Sequence[Effect] = (), covariates: Sequence[str] | None = None
) -> Finding:
    """Find the effects that ``fit`` lacks; the parameters are those of :func:`diagnose`."""
    listed, unavailable = listed_hypotheses(fit, user_effects, covariates)
    usual = [*listed, *unknown_hypotheses(fit, causes(fit.poses, covariates)),
             *by_clock(fit)]
    rates = scattering_rates(fit)
    # So large a scatter would hide any effect: it is believed where none takes most of the misfit.
    late = bool(rates) and scatters_too_much(fit)
    posterior = search(fit, usual if late else usual + rates)
    if late and 2 * posterior.likeliest_fit.relative_misfit > fit.relative_misfit:
        posterior = search(fit, usual + rates)
    return Finding(posterior, reach_verdict(posterior), unavailable)
