"""The sets of hypotheses that a search has weighed, and their joint refits."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis, held
from calib.diagnosis.search.beside import Beside
from calib.diagnosis.search.refit import Refit, refit
from calib.diagnosis.search.set_densities import set_densities
from calib.diagnosis.search.sizes import exceeds_nature
from calib.diagnosis.search.table import Table
from calib.diagnosis.search.table_at import table_at
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray, IntArray

Key = int
"""The names of the members of a set: a bit for each."""

OFTEN = ("jump", "bad_pose")
"""Kinds of which a set may hold several."""


class Entry(NamedTuple):
    """One set of hypotheses: its members' indices and its log posterior, not normalised.

    ``refit`` is the joint refit of its effects; ``whole`` whether that holds all its members.
    ``is_far`` says that it was weighed so far from its own solution that the linearisation only
    screens.
    """

    members: tuple[int, ...]
    log_posterior: float
    refit: Refit | None = None
    whole: bool = False
    is_far: bool = False

    @property
    def explains(self) -> bool:
        """Whether the joint refit of all its members explains the rows."""
        return self.whole and self.refit is not None and self.refit.explains


@dataclass(eq=False)
class Search:
    """The state of one search over ``hypotheses`` about ``base``.

    ``table`` and ``alone`` are those at the base; ``entries`` the sets by the names of their
    members, ``refused`` those without a joint solution; ``nothing`` the log densities of the empty
    set with the stated and with larger noise; ``is_explained`` whether a refit explains the rows.
    ``standard`` is the log posterior of the best set at its own solution: what others are measured
    against; ``tables`` are those at joint refits, for as long as the search goes on.
    """

    base: Fit
    hypotheses: Sequence[Hypothesis]
    table: Table
    alone: Beside
    nothing: tuple[float, float]
    p_value: float
    entries: dict[Key, Entry] = field(default_factory=dict)
    refused: set[Key] = field(default_factory=set)
    expanded: set[Key] = field(default_factory=set)
    refused_alone: Key = 0
    tables: dict[Refit, Table] = field(default_factory=dict)
    is_explained: bool = False
    standard: float = -np.inf

    @cached_property
    def leverage(self) -> FloatArray:
        """Share of itself that each row keeps in the base, (r,)."""
        return np.asarray((self.table.projector.model**2).sum(axis=1))

    @cached_property
    def number(self) -> IntArray:
        """Which of the names each hypothesis has: steps and bad poses one with their place, (m,).
        """
        labels = [(h.name, h.detail if h.kind in OFTEN else "") for h in self.hypotheses]
        place = {label: i for i, label in enumerate(dict.fromkeys(labels))}
        return np.array([place[label] for label in labels], int)

    @cached_property
    def bits(self) -> list[Key]:
        """The set of every hypothesis alone."""
        return [1 << i for i in self.number.tolist()]

    def key(self, members: Iterable[int]) -> Key:
        """Names of the members; steps and bad poses by their place."""
        key = 0
        for j in members:
            key |= self.bits[j]
        return key

    def log_prior(self, members: Iterable[int]) -> float:
        """Log odds of the members before the data."""
        return float(sum(self.hypotheses[j].log_prior for j in members))

    def note(self, entry: Entry) -> None:
        """Keep ``entry``, unless the same set is known from a refit of all its members."""
        key = self.key(entry.members)
        if self.is_refused(key) or (entry.is_far and self.is_explained):
            return
        if entry.explains and not self.is_explained:
            self.is_explained = True
            near = {k: e for k, e in self.entries.items() if not e.is_far}
            self.entries = near
        known = self.entries.get(key)
        if known is None or not known.whole or entry.whole:
            self.entries[key] = entry
        if entry.whole:
            self.standard = max(e.log_posterior for e in self.entries.values() if e.whole)

    def is_refused(self, key: Key) -> bool:
        """Whether the rows have no solution with these members, or with one of them alone."""
        return bool(key & self.refused_alone) or key in self.refused

    def table_of(self, joint: Refit) -> Table:
        """The table of all hypotheses at a joint refit, whose effects are on trial."""
        known = self.tables.get(joint)
        if known is None:
            known = self.tables[joint] = table_at(
                joint.fit, self.hypotheses, joint.names
            )
        return known

    def refuse(self, key: Key) -> None:
        """Take a set out of the search; of a single member, every set that holds it."""
        if key.bit_count() == 1:
            self.refused_alone |= key
        self.exclude(key)

    def exclude(self, key: Key) -> None:
        """Take this set out of the search."""
        self.refused.add(key)
        self.entries.pop(key, None)

    def best(self, entries: Iterable[Entry] | None = None) -> Entry:
        """The most probable set."""
        return max(entries or self.entries.values(), key=lambda entry: entry.log_posterior)

    def allowed(self, members: Sequence[int]) -> bool:
        """Whether the members can stand in one set: no effect twice, not too many."""
        key = self.key(members)
        if not key.bit_count() == len(members) <= CONSTANTS.largest_set:
            return False
        return not self.is_refused(key)

    def refitted(
        self, members: Sequence[int], start: Refit | None = None
    ) -> Entry | None:
        """The set of ``members`` at its joint refit.

        None where it would leave too few degrees of freedom to check it with; or where the rows
        have no such solution, or one that nature does not have: then the set is out of the search.
        """
        effects = [self._effect(j, start) for j in members]
        if self.base.dof - sum(int(self.table.seen[j]) for j in members) < CONSTANTS.fewest_dof:
            return None
        joint = refit(self.base, effects)
        if joint is None:
            self.refuse(self.key(members))
            return None
        if exceeds_nature(joint):
            self.exclude(self.key(members))
            return None
        chosen = [self.hypotheses[j] for j in members]
        table = table_at(joint.fit, chosen, joint.names)
        (density,) = set_densities(table, [range(len(members))])
        prior = self.log_prior(members) + joint.log_shape_width
        prior += sum(
            float(np.log(len(h.effect.shape.starts)))
            for h in chosen
            if h.effect is not None and h.effect.shape is not None
        )
        return Entry(tuple(sorted(members)), density + prior, joint, whole=True)

    def _effect(self, j: int, start: Refit | None) -> Effect:
        h = self.hypotheses[j]
        effect = held(h, j)
        if h.shape is None:
            return effect
        known = None if start is None else start.fit.shapes.get(h.name)
        return effect.from_shape(h.shape if known is None else known)

    def can_refit(self, members: Iterable[int]) -> bool:
        """Whether a model can hold all members for the length of a refit."""
        return all(self.hypotheses[j].effect is not None for j in members)


def is_nothing(state: Search) -> bool:
    """Whether the poses' own noise is the best explanation of the residual."""
    total = float(np.logaddexp.reduce([e.log_posterior for e in state.entries.values()]))
    likely = state.nothing[0] - total >= np.log(CONSTANTS.prior_nothing)
    return bool(likely and state.p_value > CONSTANTS.misfit_p_value)


def _largest_part(state: Search, members: Sequence[int]) -> Refit | None:
    """The joint refit of the most of ``members``, the likeliest of equally many, if there is one.
    """
    parts = [e for e in state.entries.values()
             if e.whole and e.refit is not None and {*e.members} <= {*members}]
    best = max(parts, key=lambda e: (len(e.members), e.log_posterior), default=None)
    return None if best is None else best.refit


def with_refit(state: Search, entry: Entry) -> Entry:
    """``entry`` with the joint refit of those of its members that a model can hold.

    Where the rows have none it is out of the search.
    """
    if entry.whole:
        return entry
    inside = tuple(j for j in entry.members if state.can_refit([j]))
    if not inside:
        return entry._replace(refit=None)
    known = state.entries.get(state.key(inside))
    if known is not None and known.whole:
        again: Entry | None = known
    else:
        again = state.refitted(inside, entry.refit)
    if again is None and state.is_refused(state.key(inside)):
        state.exclude(state.key(entry.members))
    if again is None:
        return entry._replace(refit=_largest_part(state, inside))
    state.note(again)
    return again if len(inside) == len(entry.members) else entry._replace(refit=again.refit)
