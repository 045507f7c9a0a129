"""The search over sets of hypotheses: which sets explain the residual, and with what odds.

At the base every single hypothesis and every pair of effects is screened in closed form; the best
are refitted jointly. From the best solutions the search goes on to the sets beside them: one
hypothesis more, one less, or one exchanged, weighed at the solution itself, where the linearisation
is right, and the best of these refitted in turn, until no set beside the best one is better.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.beside import Beside, besides, pair_scores
from calib.diagnosis.search.evidence import nothing_log_density
from calib.diagnosis.search.refit import Refit
from calib.diagnosis.search.set_densities import set_densities
from calib.diagnosis.search.sets import OFTEN, Entry, Key, Search, is_nothing
from calib.diagnosis.search.sizes import within_nature
from calib.diagnosis.search.table_at import table_at
from calib.fit.least_squares.result import Fit

SCREENED = 4
"""Steps and bad poses that take part in the screen of pairs: the best of each. Chosen for time."""

BEHIND_SHARE = 0.1
"""Of the log odds that the best gains over nothing: a refit can make up as much, since the error of
the linearisation grows with the signal. A judgement."""

WEIGHED = 10
"""Sets beside a solution whose evidence is computed with every size averaged. Chosen for time."""


def search(base: Fit, hypotheses: Sequence[Hypothesis]) -> Search:
    """Search the sets of ``hypotheses`` for what the model of ``base`` lacks."""
    table = table_at(base, hypotheses)
    hypotheses = within_nature(table, hypotheses)
    (alone,) = besides(table, [()])
    nothing = nothing_log_density(table.chi2, table.dof)
    state = Search(base, hypotheses, table, alone, nothing, base.bounded_p_value)
    empty = float(np.logaddexp(*nothing))
    state.note(Entry((), empty, whole=True))
    _note_by_name(state, (), empty, alone, None)
    if is_nothing(state):
        return state
    _refit_singles(state)
    if not state.is_explained:
        _refit_pairs(state)
    for _ in range(CONSTANTS.expansions):
        following = _next_to_expand(state)
        if following is None:
            break
        _expand(state, following)
    return state


def _next_to_expand(state: Search) -> Entry | None:
    """The best set; while no refit explains the rows, also the best of those that were refitted.

    What is weighed far from its own solution may lead for long, and leads nowhere.
    """
    best = state.best()
    if state.key(best.members) not in state.expanded:
        return best
    if state.is_explained:
        return None
    whole = [
        e for key, e in state.entries.items()
        if e.refit is not None and e.whole and key not in state.expanded
    ]
    return state.best(whole) if whole else None


def _note_by_name(
    state: Search, members: Sequence[int], density: float, more: Beside, joint: Refit | None
) -> list[tuple[float, tuple[int, ...]]]:
    """Keep the sets of ``members`` and one more, shapes of one effect summed; return them."""
    far = CONSTANTS.far_signal**2 * len(state.table.residual)
    value = density + state.log_prior(members) + more.log_factor + state.table.log_prior
    inside = state.key(members)
    which = np.flatnonzero(value > state.standard - CONSTANTS.negligible)
    if not which.size or len(members) >= CONSTANTS.largest_set:
        return []
    # Those of one name side by side, the best first.
    which = which[np.lexsort((-which, -value[which], state.number[which]))]
    first = np.flatnonzero(np.diff(state.number[which], prepend=-1))
    best, totals = which[first].tolist(), np.logaddexp.reduceat(value[which], first).tolist()
    is_far = (more.drop[which[first]] > far).tolist()
    noted = []
    for j, total, beyond in zip(best, totals, is_far, strict=True):
        key = inside | state.bits[j]
        if key == inside or state.is_refused(key):
            continue
        larger = tuple(sorted((*members, j)))
        noted.append((total, larger))
        known = state.entries.get(key)
        if (known is None or not known.whole) and not (beyond and state.is_explained):
            state.entries[key] = Entry(larger, total, joint, False, beyond)
    return sorted(noted, reverse=True)


def _refit_singles(state: Search) -> None:
    """The best effects by themselves, at their refits.

    Once the best explains the rows, what could stand in its place is weighed at its solution, where
    the linearisation is right; what has a shape only a refit can weigh.
    """
    singles = [e for key, e in state.entries.items() if key and state.can_refit(e.members)]
    singles.sort(key=lambda e: -e.log_posterior)
    count, first = 0, None
    for entry in singles[: 3 * CONSTANTS.singles_refitted]:
        if first is not None:
            gain = first - state.nothing[0]
            if entry.log_posterior < first - max(CONSTANTS.behind, BEHIND_SHARE * gain):
                break
        if state.best().explains and not _has_shape(state, entry.members):
            continue
        again = state.refitted(entry.members)
        if again is None:
            continue
        state.note(again)
        first = entry.log_posterior if first is None else first
        count += 1
        if count == CONSTANTS.singles_refitted:
            break


def _has_shape(state: Search, members: Iterable[int]) -> bool:
    """Whether one of the members has a shape parameter: only a refit finds its value."""
    return any(state.hypotheses[j].shape is not None for j in members)


def _refit_pairs(state: Search) -> None:
    """The best of all pairs, at their refits, until the best of all sets explains the rows."""
    candidates = [
        j for j, h in enumerate(state.hypotheses)
        if h.kind == "listed" and not state.is_refused(state.bits[j])
    ]
    for kind in OFTEN:
        several = [j for j, h in enumerate(state.hypotheses) if h.kind == kind]
        several.sort(key=lambda j: -state.alone.log_factor[j])
        candidates += several[:SCREENED]
    pairs, scores = pair_scores(state.table, candidates)
    tried: set[Key] = set()
    count = 0
    for (i, j), score in zip(pairs, scores, strict=True):
        members = (int(i), int(j))
        key = state.key(members)
        if key in tried or not state.allowed(members):
            continue
        if state.best().explains or count == CONSTANTS.pairs_refitted or not np.isfinite(score):
            break
        if len(tried) == 2 * CONSTANTS.pairs_refitted:
            break
        tried.add(key)
        entry = state.refitted(members)
        if entry is not None:
            state.note(entry)
            count += 1


def _expand(state: Search, entry: Entry) -> None:
    """The sets beside one solution: one more, one exchanged, one less; the best are refitted."""
    state.expanded.add(state.key(entry.members))
    inside = [j for j in entry.members if state.can_refit([j])]
    joint = entry.refit if inside else None
    table = state.table
    if joint is not None:
        table = state.table_of(joint)
    members = entry.members
    smaller = [tuple(m for m in members if m != k) for k in members]
    values = set_densities(table, [members, *smaller])
    weighed = [(each, value) for each, value in zip([members, *smaller], values, strict=True)
               if np.isfinite(value)]
    beside = besides(table, [each for each, _ in weighed])
    ahead: list[tuple[float, tuple[int, ...]]] = []
    for (each, density), more in zip(weighed, beside, strict=True):
        if each and each != members:
            state.note(Entry(tuple(sorted(each)), density + state.log_prior(each)))
        ahead += _note_by_name(state, each, density, more, joint)
    ahead.sort(reverse=True)
    near = [chosen for rough, chosen in ahead[:WEIGHED]
            if rough >= state.standard - CONSTANTS.behind]
    values = set_densities(table, near)
    better = [(value + state.log_prior(chosen), chosen)
              for value, chosen in zip(values, near, strict=True)]
    for value, chosen in better:
        state.note(Entry(chosen, value, joint))
    _refit_best(state, better, joint, set(members))


def _refit_best(
    state: Search,
    weighed: list[tuple[float, tuple[int, ...]]],
    joint: Refit | None,
    inside: set[int],
) -> None:
    """Refit the sets that could be the best."""
    count = 0
    for value, members in sorted(weighed, reverse=True):
        if count == CONSTANTS.neighbours_refitted:
            break
        if value < state.standard - CONSTANTS.behind:
            break
        more = set(members) - inside
        # One more, small, is linear as it is, but for a shape.
        near = CONSTANTS.near if _has_shape(state, more) else 0.0
        if inside <= set(members) and value < state.standard - near:
            continue
        known = state.entries.get(state.key(members))
        if not state.can_refit(members) or (known is not None and known.whole):
            continue
        count += 1
        again = state.refitted(members, joint)
        if again is not None:
            state.note(again)
