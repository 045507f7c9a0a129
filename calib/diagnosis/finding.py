"""Result of a search on one fit: the verdict, without its report.

:mod:`calib.diagnosis.diagnose` makes of a finding what a reader needs beside it: the ranking, the
words, and what to record next.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.courses import by_clock, scattering_rates
from calib.diagnosis.hypotheses.listed import Hypothesis, listed_hypotheses
from calib.diagnosis.hypotheses.unlisted import unknown_hypotheses
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.search import search
from calib.diagnosis.search.sizes import shows_at_no_size
from calib.diagnosis.verdict.decision import Verdict, reach_verdict
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit


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
                         if h.kind == "listed" and shows_at_no_size(one_of.table, j, h, triad))

    @property
    def blind(self) -> tuple[str, ...]:
        """Listed effects that these poses cannot see, whatever their shape."""
        is_blind: dict[str, bool] = {}
        for j, h in enumerate(self.posterior.hypotheses):
            if h.kind == "listed":
                is_blind[h.name] = is_blind.get(h.name, True) and self.posterior.table.is_blind(j)
        return tuple(name for name, blind in is_blind.items() if blind)


def find(
    fit: Fit, user_effects: Sequence[Effect] = (), covariates: Sequence[str] | None = None
) -> Finding:
    """Find the effects that ``fit`` lacks; the parameters are those of :func:`diagnose`."""
    listed, unavailable = listed_hypotheses(fit, user_effects, covariates)
    posterior = search(fit, [
        *listed, *unknown_hypotheses(fit, causes(fit.poses, covariates)),
        *_by_clock(_Clock.of(fit)), *scattering_rates(fit)])
    return Finding(posterior, reach_verdict(posterior), unavailable)


@dataclass(frozen=True)
class _Clock:
    """Times, names and runs of poses, the model's effects, the constants: ``key``."""

    key: tuple[object, ...]
    fit: Fit = field(compare=False)

    @classmethod
    def of(cls, fit: Fit) -> "_Clock":
        poses = fit.poses
        times = [None if each is None else each.tobytes()
                 for each in (poses.time_s, poses.run_time_s)]
        names = fit.model.names
        return cls((*times, poses.label, poses.run, names, *vars(CONSTANTS).values()), fit)


@lru_cache(maxsize=4)  # sessions of one design are diagnosed by the thousand
def _by_clock(clock: _Clock) -> tuple[Hypothesis, ...]:
    """The hypotheses that depend on a pose through its time alone."""
    return by_clock(clock.fit)
