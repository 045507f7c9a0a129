"""Which effects these poses do not separate beside the rest of a set: the classes of a verdict.

Aliases are never separated: their signatures agree to a canonical correlation over 0.99, and no
refit gave one of them away. Others are not separated at the size at hand: what the one leaves of
the other's signal is less than the noise, and the odds between their refits settle nothing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.sets import Entry, Search
from calib.diagnosis.search.steps import Steps
from calib.diagnosis.search.table import Table

REFUTED = 10.0
"""Log odds by which an alias falls short, at its own refit, to be no longer believed. Chosen as
far beyond any odds that the verdict names by; its half and double are not measured."""

SETTLED = float(np.log(CONSTANTS.credible / (1 - CONSTANTS.credible)))
"""Derived: log odds from which the data themselves tell two similar effects apart."""


def aliases(
    state: Search, table: Table, k: int, others: Sequence[int], beside: Sequence[int]
) -> list[int]:
    """Which of ``others`` these poses cannot tell from hypothesis ``k`` beside a set.

    ``table`` holds the signatures: those at the base are bent by what the base lacks, the more so
    the stronger it is, and no longer look the same.
    """
    on_reference = state.hypotheses[k].on_reference
    # An error of the reference is the common part of an error of the sensor that holds it.
    listed = [j for j in _listed(state, table, others)
              if table.seen[j] == table.seen[k] or on_reference]
    if not listed or table.is_blind(k) or state.hypotheses[k].kind != "listed":
        return []
    least = table.correlations(k, listed, beside)
    return [j for j, value in zip(listed, least, strict=True)
            if value > CONSTANTS.alias_correlation]


def similar(
    state: Search, table: Table, k: int, others: Sequence[int], beside: Sequence[int]
) -> list[int]:
    """Which of ``others`` leave, in the place of ``k``, no more of its signal than noise has.

    The most similar first.
    """
    listed = _listed(state, table, others)
    if not listed or table.is_blind(k) or state.hypotheses[k].kind != "listed":
        return []
    rms = table.unexplained(k, listed, beside)
    order = np.argsort(rms, kind="stable")
    return [listed[i] for i in order if rms[i] <= CONSTANTS.similar_within]


def _listed(state: Search, table: Table, which: Sequence[int]) -> list[int]:
    return [j for j in which if state.hypotheses[j].kind == "listed" and not table.is_blind(j)]


def alike(state: Search, table: Table, lead: Entry, k: int) -> dict[str, int]:
    """What may be in one class with member ``k`` of the leading set, one start of each shape.

    Of the similar those that a refit could bring near.
    """
    rest = [j for j in lead.members if j != k]
    inside = {state.hypotheses[j].name for j in lead.members}
    others = [j for j, h in enumerate(state.hypotheses) if h.name not in inside]
    places: dict[str, int] = {}
    for j in aliases(state, table, k, others, rest):
        places.setdefault(state.hypotheses[j].name, j)
    least = lead.log_posterior - CONSTANTS.behind
    for j in similar(state, table, k, others, rest):
        entry = state.entries.get(state.key((*rest, j)))
        if entry is not None and entry.log_posterior > least:
            places.setdefault(state.hypotheses[j].name, j)
    return places


def refit_alike(
    state: Search, lead: Entry, k: int, places: Mapping[str, int]
) -> Steps[None]:
    """The leading set with ``k`` exchanged for each of ``places``, at their refits."""
    if lead.refit is None:
        return
    rest = [j for j in lead.members if j != k]
    for j in places.values():
        members = (*rest, j)
        known = state.entries.get(state.key(members))
        if not state.can_refit(members) or (known is not None and known.whole):
            continue
        again = yield from state.refitted(members, lead.refit)
        if again is not None:
            state.note(again)


def class_of(
    state: Search, table: Table, lead: Entry, k: int, places: Mapping[str, int],
    probability: Mapping[str, float],
) -> tuple[str, ...]:
    """Member ``k`` and those of ``places`` that neither their refits nor the odds give away."""
    rest = [j for j in lead.members if j != k]
    same = {*aliases(state, table, k, [*places.values()], rest)}
    members = []
    for name, j in places.items():
        entry = state.entries.get(state.key((*rest, j)))
        behind = REFUTED if j in same else SETTLED
        if entry is not None and entry.log_posterior > lead.log_posterior - behind:
            members.append(name)
    members.sort(key=lambda n: -probability.get(n, 0.0))
    return (state.hypotheses[k].name, *members)
