"""The search over sets of hypotheses: which sets explain the residual, and with what odds.

At the base every pair of effects is screened in closed form; where the best set does not explain
the rows at its refit, every three, and beside the best of each size every other way to fail. At the
likeliest solution, where the linearisation is right, the sets beside it are weighed again and the
best of these refitted in turn, until none that could be the best is without a refit. Sets of four
and more grow so. The shape of an effect is right for its own set alone.
"""

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations
from math import comb

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis, held
from calib.diagnosis.search.candidates import (
    BEST_OF_EACH_SIZE,
    LARGEST_LISTED,
    Candidates,
    Key,
    Members,
)
from calib.diagnosis.search.entry import Entry
from calib.diagnosis.search.imitation import imitation
from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.refit import Refit, beyond_nature, refit
from calib.diagnosis.search.table import Table
from calib.diagnosis.search.table_at import table_at
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray

MOST_SETS_OF_PLACES = 1000
"""Sets of bad poses, or steps, of one size; of more they grow from the best. A limit of time."""

ROUNDS = 6
"""Solutions at which sets are weighed again, at most. A limit of time."""

REFITTED = 4
"""Sets refitted in one round. A limit of time."""

WEIGHED_FIRST = 64
"""Sets that are weighed before the others, which cannot all reach them. A limit of time."""

GROWN = 3
"""Best sets whose neighbours are weighed again in one round. A limit of time."""


def search(base: Fit, hypotheses: Sequence[Hypothesis]) -> Posterior:
    """Search the sets of ``hypotheses`` for what the model of ``base`` lacks."""
    table = table_at(base, hypotheses)
    search = _Search(base, table, Candidates(hypotheses))
    search.screen_small()
    if search.posterior.is_nothing:
        return search.posterior
    search.refit_best(most=1)
    is_explained = search.is_explained
    if not is_explained:
        search.screen_effects(LARGEST_LISTED)
        search.refit_best(most=1)
        is_explained = search.is_explained
        search.screen_larger(1 if is_explained else LARGEST_LISTED)
    if is_explained:
        search.weigh_again()
    for _ in range(ROUNDS):
        if not (search.refit_best() or search.refit_with_one_less()):
            break
        search.weigh_again()
    return search.posterior


class _Search:
    """The sets of one search with what they weigh, by the names of their members."""

    def __init__(self, base: Fit, table: Table, candidates: Candidates) -> None:
        self.base, self.table, self.candidates = base, table, candidates
        self.nothing = table.noise.nothing(table.chi2)
        self.singles, self.drop = table.singles()
        self.entries: dict[Key, Entry] = {0: Entry((), float(np.logaddexp(*self.nothing)))}
        self.seen = np.flatnonzero(table.seen).tolist()
        self.refused: set[Key] = set()
        self.beyond: dict[str, float] = {}
        self.solution: Refit | None = None
        self.at_solution: Table = table
        self.weighed: set[Members] = set()  # at the likeliest solution

    @property
    def posterior(self) -> Posterior:
        """What the search knows so far."""
        every = [*self.entries.values()]
        every += filter(None, (imitation(self.table, self.candidates, e) for e in every))
        least = max(e.log_posterior for e in every) - CONSTANTS.negligible
        entries = tuple(e for e in every
                        if e.log_posterior > least or e.refit is not None or not e.members)
        return Posterior(
            self.base, self.table, self.candidates, entries, self.nothing,
            self.singles - np.logaddexp(*self.nothing), self.drop, self.beyond,
            self.solution, self.at_solution,
        )

    @property
    def is_explained(self) -> bool:
        """Whether the best set of effects explains the rows at its own refit."""
        best = max((e for k, e in self.entries.items() if not k & self.candidates.without_effect),
                   key=lambda e: e.log_posterior)
        return best.explains

    def screen_small(self) -> None:
        """Weigh every hypothesis alone and every pair of effects."""
        alone = [(j,) for j in self.seen]
        self._note(alone, self.singles[self.seen] + self.candidates.log_prior(alone), -np.inf)
        self.screen_effects(2)

    def screen_effects(self, count: int) -> None:
        """Weigh every set of ``count`` effects."""
        self._weigh(self.table, [*combinations(self._listed, count)])

    def screen_larger(self, largest: int) -> None:
        """Weigh sets of bad poses and of steps, and everything beside the best of each size.

        What stands beside sets of more than ``largest`` effects is weighed at their solution.
        """
        for count in range(2, LARGEST_LISTED + 1):
            for placed in self.candidates.placed(self.table):
                self._weigh(self.table, self._of_places(placed, count))
        listed = {*self._listed}
        best = sorted((e for e in self.entries.values() if listed.issuperset(e.members)),
                      key=lambda e: -e.log_posterior)
        self._weigh(self.table, sorted({
            larger for count in range(1, largest + 1)
            for e in [e for e in best if len(e.members) == count][:BEST_OF_EACH_SIZE]
            for larger in self.candidates.one_more(self.table, e.members, self.seen)
        }))

    def _of_places(self, placed: Sequence[int], count: int) -> Sequence[Members]:
        """Sets of ``count`` bad poses or steps: all where they are few, as one hides the next."""
        if comb(len(placed), count) <= MOST_SETS_OF_PLACES:
            return [*combinations(placed, count)]
        fewer = [e for e in self.entries.values()
                 if len(e.members) == count - 1 and {*placed}.issuperset(e.members)]
        fewer.sort(key=lambda e: -e.log_posterior)
        return sorted({larger for e in fewer[:GROWN]
                       for larger in self.candidates.one_more(self.table, e.members, placed)})

    @cached_property
    def _listed(self) -> list[int]:
        return self.candidates.listed(self.table, self.singles)

    def weigh_again(self) -> None:
        """Weigh at the likeliest solution what is near the best, and what is beside the best.

        What no model can contain is weighed at the base: alone it has no other solution.
        """
        solution = max((e for e in self.entries.values() if e.refit is not None),
                       key=lambda e: e.log_posterior, default=None)
        if solution is None or solution.refit is None:
            return
        if solution.refit is not self.solution:
            self.solution, self.weighed = solution.refit, set()
            self.at_solution = table_at(
                solution.refit.fit, self.candidates.hypotheses, solution.refit.names)
        best = sorted(self.entries.values(), key=lambda e: -e.log_posterior)
        near = [e for e in best if e.log_posterior > best[0].log_posterior - CONSTANTS.negligible]
        sets = {e.members for e in near}
        if best[0].explains:  # beside a larger set one more is of second order
            best = [e for e in near if len(e.members) <= len(best[0].members)]
        for entry in best[:GROWN]:
            sets |= {*self.candidates.beside(self.at_solution, entry.members, self.seen)}
        sets -= {()}
        fresh = {self.candidates.key(members) for members in sets - self.weighed}
        self.weighed |= sets
        unfit = self.candidates.without_effect
        at_base = {key for key in fresh if not key & ~unfit}
        for table, keys in (self.at_solution, fresh - at_base), (self.table, at_base):
            self._weigh(table, sorted(
                members for members in self.weighed if self.candidates.key(members) in keys))

    def _weigh(self, table: Table, sets: Sequence[Members]) -> None:
        """Note the log posterior of ``sets`` at ``table``."""
        open_ones = [members for members in sets if self._is_open(self.candidates.key(members))]
        if not open_ones:
            return
        prior = self.candidates.log_prior(open_ones)
        batch = table.batch(open_ones)
        values = batch.at_most() + prior
        likeliest = np.argsort(-values, kind="stable")
        least = -np.inf
        for some in (likeliest[:WEIGHED_FIRST], likeliest[WEIGHED_FIRST:]):
            some = some[values[some] > least]
            values[some] = (batch.averaged(some) + prior)[some]
            least = max(least, float(values[some].max(initial=-np.inf)) - CONSTANTS.negligible)
        self._note(open_ones, values, least)

    def _note(self, sets: Sequence[Members], values: FloatArray, least: float) -> None:
        """Keep what ``sets`` weigh, those of the same names together.

        What weighs less than ``least`` and is not known yet is not kept.
        """
        of_key: dict[Key, list[tuple[float, Members]]] = {}
        for members, value in zip(sets, values.tolist(), strict=True):
            key = self.candidates.key(members)
            if value > least or (key in self.entries and value > -np.inf):
                of_key.setdefault(key, []).append((value, members))
        for key, weighed in of_key.items():
            value, members = max(weighed)
            if len(weighed) > 1:
                value = float(np.logaddexp.reduce([each for each, _ in weighed]))
            self.entries[key] = Entry(members, value)

    def _is_open(self, key: Key) -> bool:
        """Whether a set is neither refused nor weighed at its own refit."""
        known = self.entries.get(key)
        return (known is None or known.refit is None) and not self._is_refused(key)

    def _is_refused(self, key: Key) -> bool:
        return key in self.refused or any(
            one & key for one in self.refused if one.bit_count() == 1)

    def refit_best(self, most: int = REFITTED) -> bool:
        """Refit the likeliest sets that have no refit yet, so many at ``most``; whether any was.

        Where a smaller set has one, the linearisation is right, and one more member that is small
        is linear as it is.
        """
        unfit = self.candidates.without_effect
        best = max(e.log_posterior for k, e in self.entries.items() if not k & unfit)
        least = best + np.log(CONSTANTS.least_listed) - CONSTANTS.near
        whole = [k for k, e in self.entries.items() if e.refit is not None]
        open_ones = [
            e for k, e in self.entries.items()
            if (e.log_posterior > least or (self.solution is None and len(e.members) == 1))
            and e.members and e.refit is None and not k & unfit
            and self.table.seen[[*e.members]].sum() <= self.table.dof - CONSTANTS.fewest_dof
            and (e.log_posterior > best - CONSTANTS.near
                 or not any(part & k == part for part in whole))
        ]
        open_ones.sort(key=lambda e: -e.log_posterior)
        for entry in open_ones[:most]:
            self._refit(entry.members)
        return bool(open_ones)

    def refit_with_one_less(self) -> bool:
        """Refit the sets that lack one member of the solution and keep a shape; whether any was.

        The shape stands where that member left it: what lies beside it at that shape says little
        of the set without, and a straight line beside a slow warm-up would never be missed.
        """
        if self.solution is None:
            return False
        best = next(e for e in self.entries.values() if e.refit is self.solution)
        smaller = [
            members for members in combinations(best.members, len(best.members) - 1)
            if members and self._is_open(self.candidates.key(members))
            and any(self.candidates.hypotheses[j].shape is not None for j in members)
        ]
        for members in smaller:
            self._refit(members)
        return bool(smaller)

    def _refit(self, members: Members) -> None:
        """Weigh a set at its own joint refit.

        Where the rows have no such solution, or one that no sensor has, it is refused.
        """
        key = self.candidates.key(members)
        chosen = [self.candidates.hypotheses[j] for j in members]
        joint = refit(self.base, [self._effect(j) for j in members])
        beyond = {} if joint is None else beyond_nature(joint)
        if joint is None or beyond:
            if joint is not None and len(members) == 1 and 2 * joint.fit.chi2 < self.base.chi2:
                self.beyond |= beyond
            self.refused.add(key)
            self.entries = {k: e for k, e in self.entries.items() if not self._is_refused(k)}
            return
        table = table_at(joint.fit, chosen, joint.names)
        value = float(table.batch([range(len(members))]).averaged()[0])
        value += float(self.candidates.log_prior([members])[0]) + joint.log_shape_width
        value += sum(float(np.log(len(h.effect.shape.starts))) for h in chosen
                     if h.effect is not None and h.effect.shape is not None)
        self.entries[key] = Entry(members, value, joint)

    def _effect(self, j: int) -> Effect:
        h = self.candidates.hypotheses[j]
        effect = held(h, j)
        if h.shape is None:
            return effect
        known = None if self.solution is None else self.solution.fit.shapes.get(h.name)
        return effect.from_shape(h.shape if known is None else known)
