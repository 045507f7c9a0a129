"""What a search finds about one fit, or about many fits at once: the verdict, without its report.

:func:`find` and :func:`find_many` reach the same findings; :mod:`calib.diagnosis.diagnose` makes of
one what a reader needs beside it: the ranking, the words, and what to record next.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.columns import causes
from calib.diagnosis.hypotheses.listed import (
    Hypothesis,
    listed_hypotheses,
    listed_in_each,
)
from calib.diagnosis.hypotheses.unlisted import (
    bad_pose_hypotheses,
    plate_hypotheses,
    step_hypotheses,
    unknown_hypotheses,
    wander_hypotheses,
)
from calib.diagnosis.search.expansion import search
from calib.diagnosis.search.odds import Inclusion, Odds, odds_of
from calib.diagnosis.search.sets import Search
from calib.diagnosis.search.steps import Steps, alone
from calib.diagnosis.search.together import in_turn
from calib.diagnosis.verdict.decision import Verdict, reach_verdict
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit

JUDGED_AT_ONCE = 100
"""Fits whose listed effects are judged in one call: a limit of memory; it changes no verdict."""


@dataclass(frozen=True, eq=False)
class Finding:
    """What is missing in one fit, and how it was weighed.

    Parameters
    ----------
    state : Search
    odds : Odds
    verdict : Verdict
    unavailable : dict
        Listed effects that could not be evaluated, and why.
    """

    state: Search
    odds: Odds
    verdict: Verdict
    unavailable: dict[str, str]

    @property
    def blind(self) -> tuple[str, ...]:
        """Listed effects that these poses cannot see, whatever their shape."""
        is_blind: dict[str, bool] = {}
        for j, h in enumerate(self.state.hypotheses):
            if h.kind == "listed":
                is_blind[h.name] = is_blind.get(h.name, True) and self.state.table.is_blind(j)
        return tuple(name for name, blind in is_blind.items() if blind)

    @property
    def inclusion(self) -> tuple[Inclusion, ...]:
        """Every class that may be missing with its probability, the most probable first."""
        odds = self.odds
        every = sorted((*odds.classes, *odds.others), key=lambda each: -each.probability)
        unique = {each.name: each for each in reversed(every)}
        return tuple(
            each for each in every
            if unique[each.name] is each and each.probability >= CONSTANTS.least_listed
        )


def find(
    fit: Fit, user_effects: Sequence[Effect] = (), covariates: Sequence[str] | None = None
) -> Finding:
    """What is missing in ``fit``; the parameters are those of :func:`diagnose`."""
    return alone(_finding(fit, covariates, *listed_hypotheses(fit, user_effects, covariates)))


def find_many(
    fits: Sequence[Fit], user_effects: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None,
) -> list[Finding]:
    """What is missing in each of ``fits``: as :func:`find` has it.

    Probabilities are the same to rounding, where an effect has a shape parameter to about 1e-5: its
    fit is as exact as sets are weighed.

    Fits of one design, with equal numbers of poses and the same logged columns, are the fastest:
    what their searches ask is answered for all of them as stacked arrays.

    Parameters
    ----------
    fits : sequence of Fit
        Of any designs; as many as memory holds, about 0.13 MB each.
    user_effects : sequence of Effect
        Users' effects, weighed with the listed ones.
    covariates : sequence of str, optional
        Logged columns that may cause an error.

    Returns
    -------
    list of Finding
    """
    by_number = dict(find_each(fits, user_effects, covariates))
    return [by_number[i] for i in range(len(fits))]


def find_each(
    fits: Iterable[Fit], user_effects: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None,
) -> Iterator[tuple[int, Finding]]:
    """:func:`find_many` for more fits than memory holds.

    Yields
    ------
    number : int
        Which of ``fits`` it is: findings come as they end, in an order of their own.
    found : Finding
    """
    return in_turn(_findings(fits, user_effects, covariates))


def _findings(
    fits: Iterable[Fit], user_effects: Sequence[Effect], covariates: Sequence[str] | None
) -> Iterator[Steps[Finding]]:
    waiting = iter(fits)
    while some := list(islice(waiting, JUDGED_AT_ONCE)):
        listed = listed_in_each(some, user_effects, covariates)
        for fit, each in zip(some, listed, strict=True):
            yield _finding(fit, covariates, *each)


def _finding(
    fit: Fit, covariates: Sequence[str] | None, listed: Sequence[Hypothesis],
    unavailable: dict[str, str],
) -> Steps[Finding]:
    state = yield from search(fit, [*listed, *unlisted_hypotheses(fit, covariates)])
    odds = yield from odds_of(state)
    return Finding(state, odds, reach_verdict(state, odds), unavailable)


def unlisted_hypotheses(fit: Fit, covariates: Sequence[str] | None = None) -> list[Hypothesis]:
    """Everything that could be missing and that no model can hold by a name."""
    return [
        *unknown_hypotheses(fit, causes(fit.poses, covariates)),
        *_by_clock(_Clock.of(fit)),
        *plate_hypotheses(fit),
    ]


@dataclass(frozen=True)
class _Clock:
    """When the poses of ``fit`` were taken, their names and runs, and the constants: ``key``."""

    key: tuple[object, ...]
    fit: Fit = field(compare=False)

    @classmethod
    def of(cls, fit: Fit) -> "_Clock":
        poses = fit.poses
        times = [None if each is None else each.tobytes()
                 for each in (poses.time_s, poses.run_time_s)]
        return cls((*times, poses.label, poses.run, *vars(CONSTANTS).values()), fit)


@lru_cache(maxsize=4)  # sessions of one design are diagnosed by the thousand
def _by_clock(clock: _Clock) -> tuple[Hypothesis, ...]:
    """The hypotheses that know of a pose no more than when it was taken."""
    fit = clock.fit
    return (*step_hypotheses(fit), *bad_pose_hypotheses(fit), *wander_hypotheses(fit))
