"""From the sets of a search to probabilities: of each set, each effect, each class of effects.

A class holds what :mod:`calib.diagnosis.search.classes` finds that these poses do not separate.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.classes import aliases, alike, class_of, refit_alike, similar
from calib.diagnosis.search.sets import Entry, Search, with_refit

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
    masses : mapping of int to float
        Probability of every set, a bit for each of ``names``.
    names : tuple of str
    """

    nothing: float
    noise: float
    lead: Entry
    classes: tuple[Inclusion, ...]
    others: tuple[Inclusion, ...]
    masses: Mapping[int, float]
    names: tuple[str, ...]

    def mask(self, names: Iterable[str]) -> int:
        """The bits of these of :attr:`names`."""
        return sum(1 << self.names.index(name) for name in names)

    @cached_property
    def sets(self) -> tuple[tuple[tuple[str, ...], float], ...]:
        """The sets by their names in alphabetical order, with their probabilities, the most
        probable first.
        """
        by_names = [
            (tuple(sorted(name for i, name in enumerate(self.names) if mask >> i & 1)), mass)
            for mask, mass in self.masses.items()
        ]
        return tuple(sorted(by_names, key=lambda item: -item[1]))


def odds_of(state: Search) -> Odds:
    """The probabilities of a finished search."""
    lead = _refitted_lead(state)
    at_lead = state.table
    if lead.refit is not None:
        at_lead = state.table_of(lead.refit)
    state.tables.clear()
    places = {k: alike(state, at_lead, lead, k) for k in lead.members}
    for k in lead.members:
        refit_alike(state, lead, k, places[k])
    total = float(np.logaddexp.reduce([e.log_posterior for e in state.entries.values()]))
    nothing, noise = (float(np.exp(v - total)) for v in state.nothing)
    names = tuple(dict.fromkeys(h.name for h in state.hypotheses))
    bit = {name: 1 << i for i, name in enumerate(names)}
    first = {h.name: h for h in reversed(state.hypotheses)}
    masses = _masses(state, [bit[h.name] for h in state.hypotheses], total)
    alone = {name: sum(mass for key, mass in masses.items() if key & bit[name])
             for name in dict.fromkeys(
                 state.hypotheses[j].name for e in state.entries.values() for j in e.members)}
    classes = []
    for k in lead.members:
        members = class_of(state, at_lead, lead, k, places[k], alone)
        any_of = sum(bit[name] for name in members)
        inside = sum(mass for key, mass in masses.items() if key & any_of)
        classes.append(_inclusion(first[members[0]], members, inside))
    covered = {name for each in classes for name in each.members}
    rest = sorted((name for name in alone if name not in covered), key=lambda n: -alone[n])
    return Odds(
        nothing,
        noise,
        lead,
        tuple(classes),
        tuple(_inclusion(first[n], (n,), alone[n]) for n in rest),
        masses,
        names,
    )


def _refitted_lead(state: Search) -> Entry:
    """The leading set at its joint refit; one that its refit excludes leads no more."""
    while True:
        lead = _leading(state)
        if not lead.members:
            return lead
        again = with_refit(state, lead)
        if not state.is_refused(state.key(lead.members)):
            return again


def _masses(state: Search, bits: Sequence[int], total: float) -> dict[int, float]:
    """Probability of every set, those of the same names counted together, by its names' bits."""
    values = np.array([e.log_posterior for e in state.entries.values()])
    masses: dict[int, float] = {}
    for entry, share in zip(
        state.entries.values(), np.exp(values - total).tolist(), strict=True
    ):
        key = 0
        for j in entry.members:
            key |= bits[j]
        masses[key] = masses.get(key, 0.0) + share
    return masses


def _inclusion(first: Hypothesis, members: Sequence[str], probability: float) -> Inclusion:
    return Inclusion(first.name, tuple(members), float(probability), first.kind, first.follows)


def is_course(each: Hypothesis | Inclusion) -> bool:
    """Whether it says that the bias has a course in time, without the name of an effect."""
    return each.kind in COURSES or each.follows == "time_s"


def _leading(state: Search) -> Entry:
    """The most probable set of those that weigh most together: sets that differ only by effects
    which these poses cannot tell apart count together.
    """
    best = sorted(state.entries.values(), key=lambda e: -e.log_posterior)[:LEADING]
    others = float(np.logaddexp.reduce([e.log_posterior for e in best[1:]], initial=-np.inf))
    if not best[0].members and best[0].log_posterior > others:
        return best[0]  # nothing else looks like nothing, and all together weigh less
    alike_sets = [_alike(state, a, best) for a in best]
    mass = [float(np.logaddexp.reduce([b.log_posterior for b in each])) for each in alike_sets]
    return state.best(alike_sets[int(np.argmax(mass))])


def _alike(state: Search, a: Entry, others: Sequence[Entry]) -> list[Entry]:
    """Those of the ``others``, ``a`` among them, that differ from it by one effect at most, which
    these poses cannot tell from one of its own; in their order, so that sums of the same are equal.
    """
    same, apart = {a.members}, []
    inside = state.key(a.members)
    for b in others:
        if b is a:
            continue
        key = state.key(b.members)
        mine = [j for j in a.members if not state.bits[j] & key]
        theirs = [j for j in b.members if not state.bits[j] & inside]
        if not mine and not theirs:
            same.add(b.members)
        elif len(mine) == len(theirs) == 1:
            if is_course(state.hypotheses[mine[0]]) and is_course(state.hypotheses[theirs[0]]):
                same.add(b.members)
            else:
                apart.append((mine[0], theirs[0], b.members))
    for k in {mine for mine, _, _ in apart}:
        rest = [j for j in a.members if j != k]
        beside = [(j, b) for mine, j, b in apart if mine == k]
        which = [j for j, _ in beside]
        untold = {*aliases(state, state.table, k, which, rest),
                  *similar(state, state.table, k, which, rest)}
        same |= {members for j, members in beside if j in untold}
    return [b for b in others if b.members in same]
