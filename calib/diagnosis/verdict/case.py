"""A verdict with its fit, and the phrases that several verdicts share."""

from collections.abc import Sequence
from dataclasses import dataclass

from calib.diagnosis.next_measurement.advice import Advice, pose_in_words
from calib.diagnosis.verdict.decision import Code, Verdict
from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import readable
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.validation.prediction import Prediction


@dataclass(frozen=True, eq=False)
class Case:
    """One verdict with all that its text says."""

    fit: Fit
    verdict: Verdict
    ranking: Sequence[Candidate]
    p_value: float
    advice: Advice | None
    prediction: Prediction | None

    @property
    def misfit(self) -> str:
        """Chi-square over its degrees of freedom, and the basis of the verdict.

        The basis is the probability of the residual or, if noise alone would explain its size, the
        fall of chi-square by the named hypothesis.
        """
        chi2 = float(self.fit.weight @ self.fit.rows.residual**2)
        dof = self.fit.dof
        text = f"chi²/dof {chi2 / max(dof, 1):.3g} with {dof} degrees of freedom"
        if self.verdict.name == "bias_wander" and self.p_value >= MISFIT_P_VALUE:
            return f"{text}, which noise alone can make; but poses that follow each other err alike"
        if self.rests_on_size:
            chance = f"p = {self.p_value:.2g}" if self.p_value > 1e-300 else "p below 1e-300"
            if times := self.fit.sds_too_large:
                chance += f": the poses scatter {times:.2g} times less than their sds"
            return f"{text}, {chance}"
        shown = [each for each in self.ranking if each.kind != "noise"]
        best = next((each for each in shown if each.name == self.verdict.name), *shown[:1])
        return (f"{text}, which noise alone can make; but with "
                f"{readable(best.name, best.follows)} chi² falls from {chi2:.3g} to "
                f"{max(chi2 - best.chi2_drop, 0.0):.3g}")

    @property
    def noise_explains(self) -> str:
        """What the poses' own noise has to do with the residual, where nothing is missing."""
        if self.p_value >= MISFIT_P_VALUE:
            return f"the poses' own noise explains the residual ({self.misfit})"
        sessions = float(f"{1 / self.p_value:.1e}")
        return (f"no cause explains the residual better than the poses' own noise, which makes one "
                f"so large in one session of {sessions:.0f} ({self.misfit})")

    @property
    def rests_on_size(self) -> bool:
        """Whether the verdict depends on the size of the residual, not on its shape."""
        return (self.verdict.code in (Code.NOTHING_MISSING, Code.NOISE)
                or self.p_value < MISFIT_P_VALUE
                or all(each.kind == "noise" for each in self.ranking))

    def named(self, labels: Sequence[str]) -> list[str]:
        """Poses by their files and attitudes."""
        return [pose_in_words(self.fit, label) for label in labels]
