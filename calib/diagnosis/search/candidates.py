"""Sets of hypotheses that are weighed: all small ones, and those next to a solution."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.table import Table
from calib.poses.imu_log import FloatArray

Members = tuple[int, ...]
Key = int
"""The names of the members of a set: a bit for each."""

LARGEST_LISTED = 3
"""Effects of a set that is enumerated; larger ones grow from the best. A limit of time."""

BEST_OF_EACH_SIZE = 3
"""Sets of effects, of each size, beside which everything else is weighed. A limit of time."""

MOST_UNLISTED = 2
"""Members of a set that no model can contain: noise, unknown functions. A limit of time."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """The m hypotheses as members of sets."""

    hypotheses: Sequence[Hypothesis]

    @cached_property
    def bits(self) -> list[Key]:
        """The set of every hypothesis alone: steps and bad poses by their place, others by name."""
        labels = [(h.name, h.detail if h.is_placed else "") for h in self.hypotheses]
        place = {label: i for i, label in enumerate(dict.fromkeys(labels))}
        return [1 << place[label] for label in labels]

    def key(self, members: Iterable[int]) -> Key:
        """The names of the members."""
        key = 0
        for j in members:
            key |= self.bits[j]
        return key

    def log_prior(self, sets: Sequence[Members]) -> FloatArray:
        """Log odds of the members of each set before the data, (B,), no unit."""
        each = self._log_priors
        return np.array([sum([each[j] for j in members]) for members in sets])

    @cached_property
    def _log_priors(self) -> list[float]:
        return [h.log_prior for h in self.hypotheses]

    @cached_property
    def without_effect(self) -> Key:
        """The names that no model can contain, not even during a refit."""
        return self.key(j for j, h in enumerate(self.hypotheses) if h.effect is None)

    def listed(self, table: Table, singles: FloatArray) -> list[int]:
        """One hypothesis for every effect that is seen, at the likeliest of its shapes; ascending.
        """
        best: dict[str, int] = {}
        for j, h in enumerate(self.hypotheses):
            if h.kind == "listed" and h.course is None and not table.is_blind(j):
                known = best.setdefault(h.name, j)
                if singles[j] > singles[known]:
                    best[h.name] = j
        return sorted(best.values())

    def placed(self, table: Table) -> tuple[list[int], ...]:
        """Every pose that these rows can separate from the others, and every visible step."""
        return tuple([j for j, h in enumerate(self.hypotheses)
                      if h.is_placed and h.kind == kind and not table.is_blind(j)]
                     for kind in ("bad_pose", "listed"))

    def one_more(self, table: Table, members: Members, which: Iterable[int]) -> Iterator[Members]:
        """``members`` and one more of ``which``; no third of what no model can contain."""
        inside, blind = self.key(members), (table.seen == 0).tolist()
        if (inside & self.without_effect).bit_count() >= MOST_UNLISTED:
            inside |= self.without_effect
        for j in which:
            if not blind[j] and not inside & self.bits[j]:
                yield tuple(sorted((*members, j)))

    def beside(self, table: Table, members: Members, every: Sequence[int]) -> Iterator[Members]:
        """The sets beside one: a member of ``every`` more, one less, or one exchanged."""
        yield from self.one_more(table, members, every)
        for k in members:
            rest = tuple(j for j in members if j != k)
            yield rest
            yield from self.one_more(table, rest, every)
