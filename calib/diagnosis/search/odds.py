"""From the sets of a search to probabilities: of each set, each effect, each class of effects.

A class holds the effects that these poses cannot separate beside the rest of the leading set: their
signatures agree to a canonical correlation over 0.99, and no refit gave one of them away.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.sets import Entry, Key, Search, with_refit
from calib.diagnosis.search.table import Table

LEADING = 6
"""Sets among which the leading one is looked for, those of one class counted together: a
limit of time."""

REFUTED = 10.0
"""Log odds by which an alias falls short, at its own refit, to be no longer believed. Chosen as
far beyond any odds that the verdict names by; its half and double are not measured."""

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


def odds_of(state: Search) -> Odds:
    """The probabilities of a finished search."""
    lead = _leading(state)
    if lead.members:
        lead = with_refit(state, lead)
    at_lead = state.table if lead.refit is None else Table(
        lead.refit.fit, state.hypotheses, lead.refit.names)
    alike = {k: _alias_names(state, at_lead, lead, k) for k in lead.members}
    for k in lead.members:
        _refit_aliases(state, lead, k, alike[k])
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
        members = _class_of(state, lead, k, alike[k], alone)
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
    return bool(aliases(state, state.table, mine[0], theirs, rest))


def aliases(
    state: Search, table: Table, k: int, others: Sequence[int], beside: Sequence[int]
) -> list[int]:
    """Which of ``others`` these poses cannot tell from hypothesis ``k`` beside a set.

    ``table`` holds the signatures: those at the base are bent by what the base lacks, the more so
    the stronger it is, and no longer look the same.
    """
    listed = [
        j for j in others
        if state.hypotheses[j].kind == "listed" and not table.is_blind(j)
        and (table.seen[j] == table.seen[k] or _is_reference(state.hypotheses[k]))
    ]
    if not listed or table.is_blind(k) or state.hypotheses[k].kind != "listed":
        return []
    least = table.correlations(k, listed, beside)
    return [j for j, value in zip(listed, least, strict=True)
            if value > CONSTANTS.alias_correlation]


def _is_reference(hypothesis: Hypothesis) -> bool:
    """An error of the reference is the common part of an error of the sensor that holds it."""
    return hypothesis.on_reference


def _alias_names(state: Search, table: Table, lead: Entry, k: int) -> dict[str, int]:
    """The aliases of member ``k`` beside the rest of the leading set, one start of each shape."""
    rest = [j for j in lead.members if j != k]
    inside = {state.hypotheses[j].name for j in lead.members}
    others = [j for j, h in enumerate(state.hypotheses) if h.name not in inside]
    places: dict[str, int] = {}
    for j in aliases(state, table, k, others, rest):
        places.setdefault(state.hypotheses[j].name, j)
    return places


def _refit_aliases(state: Search, lead: Entry, k: int, alike: Mapping[str, int]) -> None:
    """The leading set with ``k`` exchanged for each that is ``alike``, at their refits."""
    if lead.refit is None:
        return
    rest = [j for j in lead.members if j != k]
    for j in alike.values():
        members = (*rest, j)
        known = state.entries.get(state.key(members))
        if not state.can_refit(members) or (known is not None and known.whole):
            continue
        again = state.refitted(members, lead.refit)
        if again is not None:
            state.note(again)


def _class_of(
    state: Search, lead: Entry, k: int, alike: Mapping[str, int], probability: dict[str, float]
) -> tuple[str, ...]:
    """Member ``k`` and those ``alike``, less those that their own refits give away."""
    name = state.hypotheses[k].name
    rest = [j for j in lead.members if j != k]
    members = []
    for other, j in alike.items():
        entry = state.entries.get(state.key((*rest, j)))
        if entry is not None and entry.log_posterior > lead.log_posterior - REFUTED:
            members.append(other)
    members.sort(key=lambda n: -probability.get(n, 0.0))
    return (name, *members)
