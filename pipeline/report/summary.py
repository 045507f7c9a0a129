"""The verdict in words that need no statistics: is it good, what is wrong, what to do next."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from calib.diagnosis.verdict.explain import SIGNS
from calib.poses.attitudes import direction_name
from pipeline.console.run_text import aside_text, prediction_text
from pipeline.formatting import DISPLAY, count
from pipeline.report.rate_charts import COMPLETE, RateView
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

LOG = "LOG.csv"  #: placeholder for a file of the user
HOLDS_EFFECTS = "json"  #: format that stores added effects


@dataclass(frozen=True)
class Answer:
    """Three answers for one triad, and the commands for the next step."""

    triad: str
    standing: str
    sign: str
    short: str
    good: str
    wrong: str
    next: str
    commands: tuple[str, ...]


@dataclass(frozen=True)
class Headline:
    """The whole session in one or two sentences."""

    standing: str
    sign: str
    text: str


def overall_verdict(answers: Sequence[Answer], rates: Sequence[RateView] = ()) -> Headline:
    """The headline of the page; it states everything that a section below calls incomplete."""
    standings = {answer.standing for answer in answers}
    rates_text = _rates_text(rates)
    if rates_text or not answers:
        standings.add("open")
    worst = next(each for each in ("act", "open", "good") if each in standings)
    text = " ".join(filter(None, (_triads_text(answers), rates_text)))
    return Headline(worst, SIGNS[worst], text)


def _triads_text(answers: Sequence[Answer]) -> str:
    if not answers:
        return "Only the rate of the plate was measured: the configuration contains no triad yet."
    good = [answer.triad for answer in answers if answer.standing == "good"]
    incomplete = [answer for answer in answers if answer.standing != "good"]
    if not incomplete:
        names = " and the ".join(good)
        return f"The calibration is good: noise explains the residuals of the {names}."
    sentences = [f"The calibration of the {triad} is good." for triad in good]
    sentences += [f"The calibration of the {answer.triad} is not complete: {answer.short}."
                  for answer in incomplete]
    return " ".join(sentences)


def _rates_text(rates: Sequence[RateView]) -> str:
    """What the rate models lack, a sentence for each term; empty if they are complete."""
    settings: dict[str, list[str]] = {}
    for rate in rates:
        if rate.verdict != COMPLETE:
            settings.setdefault(rate.lacks, []).append(rate.name)
    return " ".join(
        f"The rate {'model' if len(names) == 1 else 'models'} of {' and '.join(names)} "
        f"{'lacks' if len(names) == 1 else 'lack'} "
        f"{term or 'a term that the clip does not determine'}."
        for term, names in settings.items()
    )


def answer_for(result: TriadResult, outcome: Outcome, folder: str) -> Answer:
    """The three answers for one triad; ``folder`` is where its results are."""
    config = shlex.quote(str(outcome.config.source.path))
    words = result.diagnosis.explanation
    standing, sign, short = words.standing, words.sign, words.short
    wrong = _nothing_wrong(result) if standing == "good" else words.text
    if standing == "good" and _lost_direction(result):
        standing, sign = "open", SIGNS["open"]
        short = "directions are missing among its poses"
    return Answer(
        result.triad, standing, sign, short, _is_it_good(result), f"{wrong}{_aside(result)}",
        f"{words.following}{'' if words.step in ('apply', 'add') else ', then'}:",
        _commands(result, config, shlex.quote(folder)),
    )


def _is_it_good(result: TriadResult) -> str:
    unit, factor = DISPLAY[result.triad]
    comparison = result.comparison
    noise = sqrt(float(np.mean(result.calibration.fit.equations.row_sd**2)))
    rms, loo = comparison.residual_rms * factor, comparison.loo_rms * factor
    if result.diagnosis.verdict == "nothing_missing":
        first = _lost_direction(result) or "Yes."
        return (
            f"{first} The RMS residual of the {count(len(comparison.poses), 'pose')} is {rms:.2g} "
            f"{unit}, and their own noise explains it (sd {noise * factor:.2g} {unit}). The "
            f"leave-one-out error, for a pose that takes no part in the fit, is {loo:.2g} {unit}. "
            f"{_prediction(result)}"
        )
    times = comparison.residual_rms / noise
    return (
        f"{'Not yet' if times > 2 else 'Perhaps not'}. The RMS residual of the "
        f"{count(len(comparison.poses), 'pose')} is {rms:.2g} {unit}, which is {times:.2g} times "
        f"their own noise (sd {noise * factor:.2g} {unit})."
    )


def _lost_direction(result: TriadResult) -> str:
    """Why the calibration is not good everywhere; empty where it is."""
    prediction = result.prediction
    if prediction is None or prediction.holds_everywhere:
        return ""
    return (
        f"Not in every direction: with {direction_name(prediction.worst_direction)} it knows a "
        f"magnitude {prediction.noise_worst / prediction.pose_sd:.2g} times worse than a single "
        f"pose there would show. Add poses there."
    )


def _prediction(result: TriadResult) -> str:
    """What the next log will err by, as a sentence."""
    if result.prediction is None:
        return "Only rest was measured: nothing is known of the gains."
    text = prediction_text(result)
    return f"{text[0].upper()}{text[1:]}."


def _nothing_wrong(result: TriadResult) -> str:
    added = [e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading"]
    text = "These poses show no missing effect."
    if added:
        text += f" The model contains {' and '.join(added)} besides bias, scale and misalignment."
    limits = [f"{each.name} {each.value:.2g} {each.unit}" for each in result.diagnosis.limits]
    if limits:
        text += f" At 95 % the effects are no larger than: {'; '.join(limits)}."
    blind = result.diagnosis.blind
    if blind:
        text += f" They cannot determine {', '.join(blind)}; the boxes below state the reasons."
    return text


def _aside(result: TriadResult) -> str:
    """The logged columns that were not taken for causes, as a sentence; empty without any."""
    columns = result.diagnosis.aside
    if not columns:
        return ""
    text = aside_text(columns)
    return f" {text[0].upper()}{text[1:]}."


def _commands(result: TriadResult, config: str, folder: str) -> tuple[str, ...]:
    """The commands that the next step takes."""
    step = result.diagnosis.explanation.step
    if step == "apply":
        base_only = all(e.acts_on == "reading" for e in result.calibration.fit.model.effects)
        return (f"pipeline apply {folder} {LOG} --output calibrated.csv",
                f"pipeline export {folder} --to {'arduino' if base_only else HOLDS_EFFECTS}")
    if step == "add":
        return (f"pipeline add {config} {result.triad}.{result.diagnosis.name}",)
    return (f"pipeline {'diagnose' if step == 'define' else 'run'} {config}",)
