"""The verdict for somebody who has never met the words: is it good, what is wrong, what next."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from pipeline.formatting import DISPLAY, count
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

LOG = "LOG.csv"  #: stands for the user's own file


@dataclass(frozen=True)
class Answer:
    """Three answers for one triad, and the commands that follow from them."""

    triad: str
    standing: str
    sign: str
    short: str
    good: str
    wrong: str
    next: str
    commands: tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """The whole session in one sentence."""

    standing: str
    sign: str
    says: str


def overall_verdict(answers: Sequence[Answer]) -> Verdict:
    """One sentence for the session."""
    if not answers:
        return Verdict("open", "?", "Only the plate was measured: no triad is in the "
                       "configuration yet.")
    names = " and ".join(answer.triad for answer in answers)
    wanting = [answer for answer in answers if answer.standing != "good"]
    if not wanting:
        return Verdict(
            "good", "✓",
            f"The calibration is good: what the model of the {names} leaves is the noise of the "
            f"measurements.",
        )
    fine = [answer.triad for answer in answers if answer.standing == "good"]
    says = "; ".join(f"the {answer.triad}: {answer.short}" for answer in wanting)
    so_far = f"The {' and the '.join(fine)} is good. " if fine else ""
    worst = "act" if any(answer.standing == "act" for answer in wanting) else "open"
    return Verdict(worst, "!" if worst == "act" else "?", f"{so_far}Not finished yet is {says}.")


def answer_for(result: TriadResult, outcome: Outcome, folder: str) -> Answer:
    """The three answers for one triad; ``folder`` is where its results are."""
    config = shlex.quote(str(outcome.config.source.path))
    words = result.diagnosis.explanation
    wrong = _nothing_wrong(result) if words.standing == "good" else words.says
    return Answer(
        result.triad, words.standing, words.sign, words.short, _is_it_good(result), wrong,
        f"{words.following}{'' if words.step in ('apply', 'add') else ', then'}:",
        _commands(result, config, shlex.quote(folder)),
    )


def _is_it_good(result: TriadResult) -> str:
    unit, factor = DISPLAY[result.triad]
    comparison = result.comparison
    noise = sqrt(float(np.mean(result.calibration.fit.equations.row_sd**2)))
    rms, loo = comparison.residual_rms * factor, comparison.loo_rms * factor
    if result.diagnosis.verdict == "nothing_missing":
        return (
            f"Yes. The {count(len(comparison.poses), 'pose')} lie {rms:.2g} {unit} (root mean "
            f"square) from the model, as their own noise of {noise * factor:.2g} {unit} lets one "
            f"expect. A pose that takes no part in the fit is predicted to {loo:.2g} {unit}."
        )
    times = comparison.residual_rms / noise
    return (
        f"{'Not yet' if times > 2 else 'Perhaps not'}. The {count(len(comparison.poses), 'pose')} "
        f"lie {rms:.2g} {unit} (root mean square) from the model, {times:.2g} times their own "
        f"noise of {noise * factor:.2g} {unit}."
    )


def _nothing_wrong(result: TriadResult) -> str:
    added = [e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading"]
    says = "Nothing that these poses can see."
    if added:
        says += f" The model holds {' and '.join(added)} besides bias, scale and misalignment."
    limits = [f"{each.name} {each.value:.2g} {each.unit}" for each in result.diagnosis.limits]
    if limits:
        says += f" At 95 % what was looked for is no larger than: {'; '.join(limits)}."
    blind = result.diagnosis.blind
    if blind:
        says += f" They cannot see {', '.join(blind)}; the boxes below say why."
    return says


def _commands(result: TriadResult, config: str, folder: str) -> tuple[str, ...]:
    """The commands that the next step takes."""
    step = result.diagnosis.explanation.step
    if step == "apply":
        return (f"pipeline apply {folder} {LOG} --output calibrated.csv",
                f"pipeline export {folder} --to arduino")
    if step == "add":
        return (f"pipeline add {config} {result.triad}.{result.diagnosis.name}",)
    return (f"pipeline {'diagnose' if step == 'define' else 'run'} {config}",)
