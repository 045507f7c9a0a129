"""From the sets of a search to probabilities: of each set, each effect, each class of effects.

Two effects that replace each other in sets which are both believed are one class, and so are two
that leave the same in the rows: these data do not tell them apart.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.candidates import Candidates
from calib.diagnosis.search.entry import Entry, Inclusion
from calib.diagnosis.search.refit import Refit
from calib.diagnosis.search.table import Table
from calib.diagnosis.search.table_at import table_at
from calib.diagnosis.search.what_errs import what_errs
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Posterior:
    """The outcome of a search in probabilities.

    Parameters
    ----------
    base : Fit
    table : Table
        Of all hypotheses at the base.
    candidates : Candidates
    entries : tuple of Entry
    log_nothing : tuple of float
        Log densities of the empty set with the stated and with larger noise.
    log_factor, drop : array, shape (m,)
        Of each hypothesis alone at the base: the log Bayes factor against nothing, -inf where it
        is blind, and what it takes off chi-square.
    beyond : mapping of str to float
        Effects that would explain most of the misfit at a size that no part has, and how many times
        the largest that is.
    solution, at_solution
        The refit at which the sets were weighed last, and the table of all hypotheses there.
    """

    base: Fit
    table: Table
    candidates: Candidates
    entries: tuple[Entry, ...]
    log_nothing: tuple[float, float]
    log_factor: FloatArray
    drop: FloatArray
    beyond: Mapping[str, float]
    solution: Refit | None
    at_solution: Table

    @property
    def hypotheses(self) -> Sequence[Hypothesis]:
        """All that was weighed."""
        return self.candidates.hypotheses

    @property
    def p_value(self) -> float:
        """Whether the poses' own noise explains the residual of the base."""
        return self.base.bounded_p_value

    @cached_property
    def _log_total(self) -> float:
        return float(np.logaddexp.reduce([e.log_posterior for e in self.entries]))

    def mass(self, entry: Entry) -> float:
        """Probability of a set."""
        return float(np.exp(entry.log_posterior - self._log_total))

    @property
    def nothing(self) -> float:
        """Probability that nothing is missing and the stated noise holds."""
        return float(np.exp(self.log_nothing[0] - self._log_total))

    @property
    def noise(self) -> float:
        """Probability that the noise alone is larger than stated."""
        return float(np.exp(self.log_nothing[1] - self._log_total))

    @property
    def is_nothing(self) -> bool:
        """Whether the poses' own noise is the best explanation of the residual."""
        return (self.nothing >= CONSTANTS.prior_nothing
                and self.p_value > CONSTANTS.misfit_p_value)

    @property
    def likeliest_fit(self) -> Fit:
        """The refit of the likeliest set that has one; the base without any."""
        return self.base if self.solution is None else self.solution.fit

    @cached_property
    def ordered(self) -> tuple[Entry, ...]:
        """The sets, the most probable first."""
        return tuple(sorted(self.entries, key=lambda e: (-e.log_posterior, e.members)))

    @cached_property
    def credible(self) -> tuple[Entry, ...]:
        """The fewest sets that hold ``CONSTANTS.least_offered`` of the probability."""
        inside, total = [], 0.0
        for entry in self.ordered:
            inside.append(entry)
            total += self.mass(entry)
            if total >= 1 - CONSTANTS.least_offered:
                break
        return tuple(inside)

    def names(self, entry: Entry) -> frozenset[str]:
        """The names of the members of a set."""
        return frozenset(self.hypotheses[j].name for j in entry.members)

    @cached_property
    def _masses(self) -> tuple[tuple[frozenset[str], float], ...]:
        return tuple((self.names(e), self.mass(e)) for e in self.entries)

    def any_of(self, names: Iterable[str]) -> float:
        """Probability that one of ``names`` is in the model."""
        some = frozenset(names)
        return sum(mass for inside, mass in self._masses if some & inside)

    @cached_property
    def lead(self) -> Entry:
        """The likeliest set of those that weigh most together: sets that differ by one exchange
        count together.
        """
        best = self.credible
        if not best[0].members and self.mass(best[0]) >= CONSTANTS.prior_nothing:
            return best[0]
        sets = [(len(e.members), self.names(e), self.mass(e)) for e in best]
        weight = [sum(mass for size, theirs, mass in sets
                      if size == count and len(mine - theirs) <= 1) for count, mine, _ in sets]
        least = max(weight) * (1 - 1e-9)
        return next(e for e, total in zip(best, weight, strict=True) if total > least)

    @cached_property
    def classes(self) -> tuple[Inclusion, ...]:
        """One class for each member of the leading set, in its order.

        A line in a logged column and any function of it are one, where it is not sure without.
        """
        lead, first = self.names(self.lead), self.first
        weight: dict[tuple[str, str], float] = {}
        for names, mass in self._masses:
            lost, more = lead - names, names - lead
            if len(lost) == len(more) == 1:
                (mine,), (theirs,) = lost, more
                weight[mine, theirs] = weight.get((mine, theirs), 0.0) + mass
        rivals = {name: {theirs for (mine, theirs), mass in weight.items()
                         if mine == name and first[mine].in_catalogue and first[theirs].in_catalogue
                         and mass >= _least_of_rivals(first[mine], first[theirs])}
                  for name in lead}
        classes = []
        for j in self.lead.members:
            name = self.hypotheses[j].name
            others = {*rivals[name], *self._aliases(j)}
            if self.any_of({name, *others}) < CONSTANTS.sure:
                others |= {theirs for (mine, theirs), mass in weight.items()
                           if mine == name and _is_line_of(first[mine], first[theirs])
                           and mass >= CONSTANTS.least_offered}
            members = (name, *sorted(others, key=lambda n: (-self.any_of([n]), n)))
            classes.append(self._inclusion(name, members, min(self.any_of(members), 1.0)))
        return tuple(dict.fromkeys(classes))

    def _aliases(self, j: int) -> set[str]:
        """What looks the same as member ``j`` of the leading set, and no refit of it refuted."""
        lead, name = self.names(self.lead), self.hypotheses[j].name
        if self.hypotheses[j].kind != "listed":
            return set()
        table, which = self._at_lead
        listed = [i for i, k in enumerate(which) if self.hypotheses[k].kind == "listed"
                  and self.hypotheses[k].name not in lead]
        same = {self.hypotheses[which[i]].name for i in table.aliases(which.index(j), listed)}
        least = self.lead.log_posterior - CONSTANTS.negligible
        believed = [self.names(e) for e in self.entries if e.log_posterior > least]
        return {other for other in same if (lead - {name}) | {other} in believed}

    @cached_property
    def others(self) -> tuple[Inclusion, ...]:
        """What else may be missing, the most probable first."""
        covered = {name for each in self.classes for name in each.members}
        alone: dict[str, float] = {}
        for inside, mass in self._masses:
            for name in inside - covered:
                alone[name] = alone.get(name, 0.0) + mass
        each = [self._inclusion(n, (n,), min(p, 1.0)) for n, p in alone.items()]
        return tuple(sorted(each, key=lambda i: (-i.probability, i.name)))

    @cached_property
    def inclusion(self) -> tuple[Inclusion, ...]:
        """Every class that may be missing with its probability, the most probable first."""
        every = sorted((*self.classes, *self.others), key=lambda each: -each.probability)
        return tuple(i for i in every if i.probability >= CONSTANTS.least_listed)

    @cached_property
    def sets(self) -> tuple[tuple[tuple[str, ...], float], ...]:
        """The sets by their names in alphabetical order, with their probabilities, the most
        probable first.
        """
        masses: dict[tuple[str, ...], float] = {}
        for entry in self.ordered:
            names = tuple(sorted(self.names(entry)))
            masses[names] = masses.get(names, 0.0) + self.mass(entry)
        return tuple(sorted(masses.items(), key=lambda item: -item[1]))

    @cached_property
    def _at_lead(self) -> tuple[Table, list[int]]:
        """The table of the listed hypotheses at the leading set's refit, and which they are.

        Signatures at the base are bent by what it lacks.
        """
        joint = self.lead.refit
        if joint is None or joint is self.solution:
            return self.at_solution if joint else self.table, [*range(len(self.hypotheses))]
        which = [k for k, h in enumerate(self.hypotheses) if h.kind == "listed"]
        return table_at(joint.fit, [self.hypotheses[k] for k in which], joint.names), which

    @cached_property
    def first(self) -> dict[str, Hypothesis]:
        """The first hypothesis of every name."""
        return {h.name: h for h in reversed(self.hypotheses)}

    def _inclusion(self, name: str, members: Sequence[str], probability: float) -> Inclusion:
        h = self.first[name]
        errs = (self.what_errs(name)
                if h.follows is not None and probability >= CONSTANTS.least_offered else "")
        return Inclusion(
            name, tuple(members), probability, h.kind, h.follows, self._details(name), errs)

    def what_errs(self, name: str) -> str:
        """What the unknown function ``name`` is of the reading; empty where that is not sure."""
        likeliest = next(e.members for e in self.ordered if name in self.names(e))
        return what_errs(self.at_solution, self.candidates, likeliest, name)

    def _details(self, name: str) -> tuple[str, ...]:
        """Poses or times of ``name`` in the likeliest set that has it, if it is not an effect."""
        if not self.first[name].is_placed:
            return ()
        for entry in (self.lead, *self.ordered):
            told = tuple(self.hypotheses[j].detail for j in entry.members
                         if self.hypotheses[j].name == name)
            if told:
                return told
        return ()


def _is_line_of(a: Hypothesis, b: Hypothesis) -> bool:
    """Whether one is a line in a logged column of which the other is an unknown function."""
    columns = {None if each.effect is None else each.effect.names_column for each in (a, b)}
    return bool(({a.follows, b.follows} & columns) - {None})


def _least_of_rivals(a: Hypothesis, b: Hypothesis) -> float:
    """Probability from which one in the place of the other is of its class.

    What happened once looks a little like anything at some time, but for what is drawn: a course
    of chance holds any step.
    """
    if "drawn" not in (a.kind, b.kind) and (a.is_placed or b.is_placed):
        return CONSTANTS.least_offered
    return CONSTANTS.least_listed
