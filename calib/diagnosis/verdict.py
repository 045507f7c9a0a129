"""The verdict on a ranking: is anything missing, what, and can these data tell.

In this order: nothing; two effects at once, where no single one explains the rows; a listed effect
that is sure; a shape that no listed effect has; and where several remain, all that are credible.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses import Hypothesis, jump_hypothesis, unknown_hypotheses
from calib.diagnosis.ranking import PRIOR_NONE, Candidate, key_of
from calib.diagnosis.refit import FEWEST_DOF, judge, parameters_of, refit_pairs
from calib.diagnosis.signature import Projector
from calib.effects.effect import Effect
from calib.fit.result import MISFIT_P_VALUE as ADEQUATE_P_VALUE
from calib.fit.result import Fit

MISFIT_P_VALUE = 1e-3
SURE = 0.9
FEW_DOF, SURE_OF_FEW = 15, 0.95
"""Where few rows are left to contradict a name, more is asked of it, and that it explains them."""

CREDIBLE = 0.95
FOLLOWS_EVIDENCE = 3.0
"""Log Bayes factor, 20 to 1, from which a misfit is said to follow a covariate."""

FOLLOWS_TIME = ("time_s", "jump")
NEAREST_LISTED = ("bias_drift", "warm_up")
"""What a drift of unlisted shape is compared with in its group: the listed drifts of the bias, the
likelier first."""

REFUTED = 10.0
"""Log evidence by which an alias falls short, at its own refit, to be no longer believed."""

DOUBT = 2 * float(np.log(200.0))
"""Difference of scores below which a rival pair is not ruled out: odds of 200 to 1."""

STRONG = 4.0
"""Chi-square per degree of freedom from which two effects at once are looked for."""


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


@dataclass(frozen=True, eq=False)
class Judge:
    """Decides on one ranking; see the module's docstring for the order of the questions.

    ``own`` are the users' effects among the candidates.
    """

    fit: Fit
    every: Sequence[Hypothesis]
    ranking: Sequence[Candidate]
    log_p: dict[str, float]
    p_value: float
    own: Sequence[Effect] = ()

    def reach(self) -> Verdict:
        """The verdict, by the first of the module's questions that has an answer."""
        if is_nothing(self.log_p, self.p_value):
            return Verdict("nothing_missing")
        top = self.every[0]
        if self.fit.chi2 > STRONG * self.fit.dof:
            pair = self._by_pair()
            if pair is not None:
                return pair
        if top.kind == "listed":
            return self._by_evidence(top)
        if top.kind in ("unknown", "jump"):
            return self._unknown(top)
        return Verdict(top.kind, top.detail or None)

    @property
    def _none(self) -> float:
        return float(np.exp(self.log_p["none"]))

    @property
    def _listed(self) -> list[Hypothesis]:
        """The listed effects, the most probable first."""
        return [h for h in self.every if h.kind == "listed"]

    def _group(self, name: str) -> tuple[str, ...]:
        """``name`` and its aliases, less those that their own refits give away.

        Aliases agree to a few per cent of their signal. Where that is many times the noise, a
        refit that falls far short is no alias any more, and neither is one without a solution.
        """
        aliases = next(c.aliases for c in self.ranking if c.name == name and c.kind == "listed")
        least = self.log_p[name] - REFUTED
        return (name, *(alias for alias in aliases if self.log_p[alias] > least))

    def _by_evidence(self, top: Hypothesis) -> Verdict:
        group = self._group(top.name)
        mass = sum(float(np.exp(self.log_p[name])) for name in group)
        few = self.fit.dof < FEW_DOF
        sure = SURE_OF_FEW if few else SURE
        contradicted = few and top.after is not None and not _explains(top.after)
        is_sure = mass >= sure * (1 - self._none) and self._none < 1 - SURE
        if is_sure and self._carried(top) and not contradicted:
            return Verdict("effect", top.name, group)
        return Verdict("ambiguous", group=self._credible())

    def _carried(self, hypothesis: Hypothesis) -> bool:
        """Whether a fit with this effect would leave something to check it with."""
        return self.fit.dof - parameters_of(hypothesis) >= FEWEST_DOF

    def _credible(self) -> tuple[str, ...]:
        """The smallest set of hypotheses that holds most of what is not "nothing"."""
        names, mass = [], 0.0
        for h in self.every:
            names.append(key_of(h))
            mass += float(np.exp(self.log_p[key_of(h)]))
            if mass >= CREDIBLE * (1 - self._none):
                break
        return tuple(names)

    def _unknown(self, top: Hypothesis) -> Verdict:
        """A shape that no listed effect has; a drift of the bias has it where it leaves none."""
        probability = float(np.exp(self.log_p[key_of(top)]))
        if probability >= 0.5 * (1 - self._none):
            if top.name not in FOLLOWS_TIME:
                return Verdict("unknown", top.name)
            drifts = [h for h in self._listed if h.name in NEAREST_LISTED]
            enough = next((h for h in drifts if _leaves_no_drift(h)), None)
            if enough is not None and self._carried(enough):
                return Verdict("effect", enough.name, self._group(enough.name))
            return Verdict("unknown", top.name, tuple(h.name for h in drifts))
        return Verdict("ambiguous", group=self._credible())

    def _by_pair(self) -> Verdict | None:
        """Two effects at once, where no single one explains the rows and a pair does.

        Both are named where no other pair would do, else the one that all such pairs have.
        """
        refits = [(h, h.after) for h in self._listed if h.after is not None]
        if not refits or any(_explains(found) for _, found in refits):
            return None
        if not self._carried(self._listed[0]):
            return None  # the likeliest has too many parameters for a refit that could clear it
        pairs = refit_pairs(self.fit, [h for h, _ in refits], self.own)
        if not pairs or pairs[0].p_value < ADEQUATE_P_VALUE:
            return None
        possible = [pair for pair in pairs if pair.score - pairs[0].score < DOUBT]
        common = set.intersection(*(set(pair.names) for pair in possible))
        order = [h for h in self._listed if h.name in common]  # explains more on its own: first
        if not order:
            return None
        name = order[0].name
        return Verdict("effect", name, self._group(name), next(iter(common - {name}), None))


def is_nothing(log_p: dict[str, float], p_value: float) -> bool:
    """Whether the poses' own noise is the best explanation of the residual."""
    none = log_p["none"]
    likely = none >= np.log(PRIOR_NONE) and p_value > MISFIT_P_VALUE
    return bool(likely or (none > np.log(1 - CREDIBLE) and none == max(log_p.values())))


def _leaves_no_drift(listed: Hypothesis) -> bool:
    """Whether nothing follows time any more once this drift is fitted: then it has the shape."""
    if listed.after is None or listed.log_evidence < FOLLOWS_EVIDENCE:
        return False
    projector = Projector(listed.after)
    left = [h for h in unknown_hypotheses(listed.after, projector) if h.name in FOLLOWS_TIME]
    jump = jump_hypothesis(listed.after, projector)
    return all(h.log_evidence < FOLLOWS_EVIDENCE for h in (*left, *([jump] if jump else [])))


def _explains(found: Fit) -> bool:
    return judge(found).p_value >= ADEQUATE_P_VALUE
