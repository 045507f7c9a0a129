"""Which effects these poses do not separate beside the rest of a set: the classes of a verdict.

Aliases are never separated: their signatures agree to a canonical correlation over 0.99, and no
refit gave one of them away. Similar effects, such as a drift and a bias that follows a temperature
which rises with time, are not separated while the odds between their refits settle nothing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.search.sets import Entry, Search
from calib.diagnosis.search.table import Table

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
    others = [j for j in others if table.seen[j] == table.seen[k] or on_reference]
    listed = _listed(state, table, others)
    if not listed or table.is_blind(k) or state.hypotheses[k].kind != "listed":
        return []
    least = table.correlations(k, listed, beside)
    return [j for j, value in zip(listed, least, strict=True)
            if value > CONSTANTS.alias_correlation]


def similar(
    state: Search, table: Table, k: int, others: Sequence[int], beside: Sequence[int]
) -> list[int]:
    """Which of ``others`` would, in the place of ``k``, leave nearly nothing of its signal."""
    listed = _listed(state, table, others)
    if not listed or table.is_blind(k) or state.hypotheses[k].kind != "listed":
        return []
    shared = table.shared_signal(k, listed, beside)
    order = np.argsort(-shared, kind="stable")
    return [listed[i] for i in order if shared[i] > CONSTANTS.similar_signal]


def _listed(state: Search, table: Table, which: Sequence[int]) -> list[int]:
    return [j for j in which if state.hypotheses[j].kind == "listed" and not table.is_blind(j)]


def _rest(table: Table, lead: Entry, k: int) -> tuple[list[int], list[int]]:
    """The other members, and those of them that ``k`` is compared beside.

    None where they leave so few rows that any effect would look like any other there.
    """
    rest = [j for j in lead.members if j != k]
    spare = table.dof - table.space(rest).shape[1] - int(table.seen[k])
    return rest, rest if spare >= CONSTANTS.fewest_dof else []


def alike(state: Search, table: Table, lead: Entry, k: int) -> dict[str, int]:
    """What may be in one class with member ``k`` of the leading set, one start of each shape.

    Of the similar those that a refit could bring near.
    """
    rest, beside = _rest(table, lead, k)
    inside = {state.hypotheses[j].name for j in lead.members}
    others = [j for j, h in enumerate(state.hypotheses) if h.name not in inside]
    places: dict[str, int] = {}
    for j in aliases(state, table, k, others, beside):
        places.setdefault(state.hypotheses[j].name, j)
    least = lead.log_posterior - CONSTANTS.behind
    for j in similar(state, table, k, others, beside):
        entry = state.entries.get(state.key((*rest, j)))
        if entry is not None and entry.log_posterior > least:
            places.setdefault(state.hypotheses[j].name, j)
    return places


def refit_alike(
    state: Search, lead: Entry, k: int, places: Mapping[str, int]
) -> None:
    """The leading set with ``k`` exchanged for each of ``places``, at their refits."""
    if lead.refit is None:
        return
    rest = [j for j in lead.members if j != k]
    for j in places.values():
        members = (*rest, j)
        known = state.entries.get(state.key(members))
        if not state.can_refit(members) or (known is not None and known.whole):
            continue
        again = state.refitted(members, lead.refit)
        if again is not None:
            state.note(again)


def class_of(
    state: Search, table: Table, lead: Entry, k: int, places: Mapping[str, int],
    probability: Mapping[str, float],
) -> tuple[str, ...]:
    """Member ``k`` and those of ``places`` that neither their refits nor the odds give away."""
    rest, beside = _rest(table, lead, k)
    same = {*aliases(state, table, k, [*places.values()], beside)}
    members = []
    for name, j in places.items():
        entry = state.entries.get(state.key((*rest, j)))
        behind = CONSTANTS.refuted if j in same else SETTLED
        if entry is not None and entry.log_posterior > lead.log_posterior - behind:
            members.append(name)
    members.sort(key=lambda n: -probability.get(n, 0.0))
    return (state.hypotheses[k].name, *members)
