"""The verdict on a ranking: is anything missing, what, and can these data tell.

In this order: nothing; what joint refits of the leading effects decide; what the evidence decides;
a shape that no listed effect has; and where several remain, all that are credible.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.fit import Fit
from calib.hypotheses import Hypothesis
from calib.ranking import PRIOR_NONE, Candidate, key_of
from calib.refit import (
    ADEQUATE_P_VALUE,
    FEWEST_DOF,
    SINGLES,
    Refit,
    parameters_of,
    refit_pairs,
    refit_singles,
)

MISFIT_P_VALUE = 1e-3
SURE = 0.9
CREDIBLE = 0.95
FOLLOWS_TIME = ("time_s", "jump")
NEAREST_LISTED = ("bias_drift", "warm_up")
"""What a drift of unlisted shape is compared with in its group: the listed drifts of the bias."""

REFUTED = 20.0
"""Difference of scores (as of chi-square) beyond which one alias is no longer believed."""

DOUBT = 2 * float(np.log(200.0))
"""Difference of scores below which a rival is not ruled out: odds of 200 to 1."""

STRONG = 4.0
"""Above this chi-square per degree of freedom the columns, linearised at a biased fit, mislead."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """``code`` is one of nothing_missing, effect, ambiguous, unknown, bad_pose, noise.

    ``name`` is the effect, column or pose it speaks of; ``group`` all that cannot be told from it,
    or all that an ambiguous verdict leaves open; ``partner`` a second effect found with the first.
    """

    code: str
    name: str | None = None
    group: tuple[str, ...] = ()
    partner: str | None = None
    after: Refit | None = None


@dataclass(frozen=True, eq=False)
class Judge:
    """Decides on one ranking; see the module's docstring for the order of the questions."""

    fit: Fit
    every: Sequence[Hypothesis]
    ranking: Sequence[Candidate]
    log_p: dict[str, float]
    p_value: float

    def reach(self) -> Verdict:
        """The verdict, by the first of the module's questions that has an answer."""
        none = float(np.exp(self.log_p["none"]))
        if (none >= PRIOR_NONE and self.p_value > MISFIT_P_VALUE) or (
            none > 1 - CREDIBLE and none == max(np.exp(v) for v in self.log_p.values())
        ):
            return Verdict("nothing_missing")
        top = self.every[0]
        refits: list[Refit] = []
        if self.fit.chi2 > STRONG * self.fit.dof and none < 1 - SURE:
            refits = refit_singles(self.fit, self._listed)
            judged = self._by_refit(refits) if refits else None
            if judged is not None:
                return judged
        if top.kind == "listed":
            return self._by_evidence(top, none, refits)
        if top.kind in ("unknown", "jump"):
            return self._unknown(top, none)
        return Verdict(top.kind, top.detail or None)

    def _group(self, name: str) -> tuple[str, ...]:
        aliases = next(c.aliases for c in self.ranking if c.name == name and c.kind == "listed")
        return (name, *aliases)

    @property
    def _listed(self) -> list[Hypothesis]:
        """The listed effects, the most probable first."""
        return [h for h in self.every if h.kind == "listed"]

    def _by_evidence(self, top: Hypothesis, none: float, refits: Sequence[Refit]) -> Verdict:
        group = self._group(top.name)
        mass = sum(float(np.exp(self.log_p[name])) for name in group)
        sure = mass >= SURE * (1 - none) and none < 1 - SURE
        if sure and self._carried(top) and not self._refuted(top.name, refits):
            return Verdict("effect", top.name, group)
        return Verdict("ambiguous", group=self._credible(none))

    def _carried(self, hypothesis: Hypothesis) -> bool:
        """Whether a fit with this effect would leave something to check it with."""
        return self.fit.dof - parameters_of(hypothesis) >= FEWEST_DOF

    def _refuted(self, name: str, refits: Sequence[Refit]) -> bool:
        """Whether a joint refit with ``name`` falls short where another explains the rows."""
        own = next((r for r in refits if r.names == (name,)), None)
        return own is not None and not _is_rival(own, refits[0])

    def _credible(self, none: float) -> tuple[str, ...]:
        """The smallest set of hypotheses that holds most of what is not "nothing"."""
        names, mass = [], 0.0
        for h in self.every:
            names.append(key_of(h))
            mass += float(np.exp(self.log_p[key_of(h)]))
            if mass >= CREDIBLE * (1 - none):
                break
        return tuple(names)

    def _unknown(self, top: Hypothesis, none: float) -> Verdict:
        probability = float(np.exp(self.log_p[key_of(top)]))
        if probability >= 0.5 * (1 - none):
            nearest = NEAREST_LISTED if top.name in FOLLOWS_TIME else ()
            return Verdict("unknown", top.name, nearest)
        return Verdict("ambiguous", group=self._credible(none))

    def _by_refit(self, singles: Sequence[Refit]) -> Verdict | None:
        """The verdict by joint refits of the leading listed effects, None where undecided."""
        best = singles[0]
        if not self._carried(self._listed[0]):
            return None  # the likeliest has too many parameters for a refit that could clear it
        if best.p_value >= ADEQUATE_P_VALUE:
            group = self._told_apart(best, singles)
            if any(r.names[0] not in group and _is_rival(r, best) for r in singles):
                return None
            return Verdict("effect", best.names[0], group, None, best)
        pairs = refit_pairs(self.fit, self._listed, singles)
        if not pairs or pairs[0].p_value < ADEQUATE_P_VALUE:
            return None
        return self._by_pair(pairs, singles)

    def _by_pair(self, pairs: Sequence[Refit], singles: Sequence[Refit]) -> Verdict | None:
        """Two effects at once: both where no other pair would do, else the one all have."""
        possible = [pair for pair in pairs if _is_rival(pair, pairs[0])]
        common = set.intersection(*(set(pair.names) for pair in possible))
        order = [r for r in singles if r.names[0] in common]  # more explained on its own: first
        if not order:
            return None
        name = order[0].names[0]
        partner = next(iter(common - {name}), None)
        return Verdict("effect", name, self._group(name), partner, order[0])

    def _told_apart(self, best: Refit, singles: Sequence[Refit]) -> tuple[str, ...]:
        """The group of ``best`` less the aliases that its size gives away.

        Aliases agree to a few per cent of their signal. Where that is many times the noise and
        the best of them explains the rows, a refit that falls far short is no alias any more, and
        neither is one that turned out to be no solution at all.
        """
        if best.p_value < ADEQUATE_P_VALUE:
            return self._group(best.names[0])
        refuted = {
            r.names[0]
            for r in singles
            if r.p_value < ADEQUATE_P_VALUE and r.score - best.score > REFUTED
        }
        refuted |= {h.name for h in self._listed[:SINGLES]} - {r.names[0] for r in singles}
        return tuple(name for name in self._group(best.names[0]) if name not in refuted)


def _is_rival(refit: Refit, best: Refit) -> bool:
    """Whether ``refit`` would do in place of ``best``: it explains the rows, or nearly as well."""
    return refit.p_value >= ADEQUATE_P_VALUE or refit.score - best.score < DOUBT
