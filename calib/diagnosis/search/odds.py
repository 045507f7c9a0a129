"""From the sets of a search to probabilities: of each set, each effect, each class of effects.

A class holds what :mod:`calib.diagnosis.search.classes` finds that these poses do not separate.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.classes import aliases, alike, class_of, refit_alike, similar
from calib.diagnosis.search.sets import Entry, Key, Search, with_refit
from calib.diagnosis.search.steps import Steps, table_at

LEADING = 6
"""Sets among which the leading one is looked for, those of one class counted together: a
limit of time."""

COURSES = ("jump", "wander")
"""Kinds that say, like an unknown function of time: the bias has a course in time."""


@dataclass(frozen=True)
class Inclusion:
    """A class of effects and the probability that one of them is missing.

    Attributes
    ----------
    name : str
        Its most probable member.
    members : tuple of str
        All, ``name`` first.
    probability : float
    kind : str
        That of the hypothesis ``name``, or ``noise``.
    follows : str or None
        What ``name`` is a function of where it is an unknown function.
    """

    name: str
    members: tuple[str, ...]
    probability: float
    kind: str
    follows: str | None = None


@dataclass(frozen=True, eq=False)
class Odds:
    """The outcome of a search in probabilities.

    Parameters
    ----------
    nothing, noise : float
        Probability that nothing is missing, and that the noise alone is larger than stated.
    lead : Entry
        The leading set, at its joint refit where it has one.
    classes : tuple of Inclusion
        One for each member of the leading set, in the order of their names in ``lead``.
    others : tuple of Inclusion
        What else may be missing, the most probable first.
    sets : tuple of (tuple of str, float)
        The sets with their probabilities, the most probable first.
    """

    nothing: float
    noise: float
    lead: Entry
    classes: tuple[Inclusion, ...]
    others: tuple[Inclusion, ...]
    sets: tuple[tuple[tuple[str, ...], float], ...]


def odds_of(state: Search) -> Steps[Odds]:
    """The probabilities of a finished search."""
    lead = _leading(state)
    if lead.members:
        lead = yield from with_refit(state, lead)
    at_lead = state.table
    if lead.refit is not None:
        at_lead = yield from table_at(lead.refit.fit, state.hypotheses, lead.refit.names)
    places = {k: alike(state, at_lead, lead, k) for k in lead.members}
    for k in lead.members:
        yield from refit_alike(state, lead, k, places[k])
    total = float(np.logaddexp.reduce([e.log_posterior for e in state.entries.values()]))
    nothing, noise = (float(np.exp(v - total)) for v in state.nothing)
    shares = {key: float(np.exp(e.log_posterior - total)) for key, e in state.entries.items()}
    by_name = {
        key: frozenset(state.hypotheses[j].name for j in state.entries[key].members)
        for key in shares
    }
    first = {h.name: h for h in reversed(state.hypotheses)}
    alone = _by_name(shares, by_name)
    classes = []
    for k in lead.members:
        members = class_of(state, at_lead, lead, k, places[k], alone)
        inside = sum(share for key, share in shares.items() if by_name[key] & set(members))
        classes.append(_inclusion(first[members[0]], members, inside))
    covered = {name for each in classes for name in each.members}
    rest = sorted((name for name in alone if name not in covered), key=lambda n: -alone[n])
    return Odds(
        nothing,
        noise,
        lead,
        tuple(classes),
        tuple(_inclusion(first[n], (n,), alone[n]) for n in rest),
        tuple(sorted(_sets(shares, by_name).items(), key=lambda item: -item[1])),
    )


def _by_name(shares: dict[Key, float], by_name: dict[Key, frozenset[str]]) -> dict[str, float]:
    """Probability of every name to be in the model."""
    total: dict[str, float] = {}
    for key, share in shares.items():
        for name in by_name[key]:
            total[name] = total.get(name, 0.0) + share
    return total


def _sets(
    shares: dict[Key, float], by_name: dict[Key, frozenset[str]]
) -> dict[tuple[str, ...], float]:
    total: dict[tuple[str, ...], float] = {}
    for key, share in shares.items():
        names = tuple(sorted(by_name[key]))
        total[names] = total.get(names, 0.0) + share
    return total


def _inclusion(first: Hypothesis, members: Sequence[str], probability: float) -> Inclusion:
    return Inclusion(first.name, tuple(members), float(probability), first.kind, first.follows)


def is_course(each: Hypothesis | Inclusion) -> bool:
    """Whether it says that the bias has a course in time, without the name of an effect."""
    return each.kind in COURSES or each.follows == "time_s"


def _leading(state: Search) -> Entry:
    """The most probable set, sets counted together that differ by aliases only."""
    best = sorted(state.entries.values(), key=lambda e: -e.log_posterior)[:LEADING]
    others = float(np.logaddexp.reduce([e.log_posterior for e in best[1:]], initial=-np.inf))
    if not best[0].members and best[0].log_posterior > others:
        return best[0]  # nothing else looks like nothing, and all together weigh less
    mass = [
        float(np.logaddexp.reduce([b.log_posterior for b in best if _alike(state, a, b)]))
        for a in best
    ]
    return best[int(np.argmax(mass))]


def _alike(state: Search, a: Entry, b: Entry) -> bool:
    """Whether two sets differ by one effect that these poses cannot tell from another at most."""
    if a is b:
        return True
    mine = [j for j in a.members if state.label(j) not in state.key(b.members)]
    theirs = [j for j in b.members if state.label(j) not in state.key(a.members)]
    if not mine and not theirs:
        return True
    if len(mine) != 1 or len(theirs) != 1:
        return False
    if all(is_course(state.hypotheses[j]) for j in (*mine, *theirs)):
        return True
    rest = [j for j in a.members if j not in mine]
    return bool(aliases(state, state.table, mine[0], theirs, rest)
                or similar(state, state.table, mine[0], theirs, rest))
