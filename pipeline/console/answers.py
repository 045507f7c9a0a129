"""Is it good, what is wrong, what to do next: one source for the terminal and for the report.

Each triad has an answer, and so have the clips of the plate where their rate models lack a term.
The headline of the report, its sections and the last lines of ``pipeline run`` are made of these.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

import numpy as np

from calib.consistency.clock_ratio import ClockRatio
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.explanation import Standing, Step
from calib.diagnosis.verdict.wording import enumeration
from calib.fit.least_squares.drawn_sizes import times_stated
from calib.poses.runs.reference_runs import GRAVITY
from calib.rounding import two_digits
from pipeline.console.parameter_text import prediction_text
from pipeline.console.rate_text import RateVerdict, rate_verdict, reasons_of
from pipeline.console.run_text import aside_text, loo_by_noise
from pipeline.exclusion import exclude_command
from pipeline.next_change import may_follow_a_column
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, count
from pipeline.text.names import command, word
from pipeline.text.untold import untold_notes

LOG = "LOG --output FILE"  #: placeholders for files of the user
NEW_FILES = "; then bring the new logs into the session:"  #: end of a step that records poses
NEW_CLIPS = "; name the clips in the configuration, then:"  #: end of one that films those there are
RATES = "plate rates"  #: subject of the answer on the clips
ALONG_A_COLUMN = ("See first whether the error rather follows a logged column or a run, and add "
                  "the step where it follows neither")
"""Next step where a step in time is named that may be one along a logged column."""
WORST_FIRST: tuple[Standing, ...] = ("act", "open", "good")


@dataclass(frozen=True)
class Answer:
    """Three answers for one triad or for the plate rates, and the commands for the next step.

    ``step`` is the kind of the next step.
    """

    subject: str
    standing: Standing
    short: str
    good: str
    wrong: str
    next: str
    step: Step
    commands: tuple[str, ...]


@dataclass(frozen=True)
class Headline:
    """Summary of the session in one or two sentences."""

    standing: Standing
    text: str


def answers_of(outcome: Outcome, folder: str) -> tuple[Answer, ...]:
    """The answers on a session, the worst first; ``folder`` is that of its results."""
    config = outcome.config.source.path
    answers = [triad_answer(outcome, result, folder) for result in outcome.triads]
    rates = (clocks_answer(outcome.recordings.clocks, config)
             or rates_answer([*map(rate_verdict, outcome.rates.values())], config))
    if rates is not None:
        answers.append(rates)
    return tuple(sorted(answers, key=lambda answer: (
        WORST_FIRST.index(answer.standing), answer.step != "add")))


def headline(answers: Sequence[Answer]) -> Headline:
    """Summary of all answers; it states everything that one of them calls incomplete."""
    triads = [answer for answer in answers if answer.subject != RATES]
    standings = {answer.standing for answer in answers} or {"open"}
    worst = next(standing for standing in WORST_FIRST if standing in standings)
    rates = [answer for answer in answers if answer.subject == RATES]
    is_sure = all(answer.step != "record" for answer in rates)
    return Headline(worst, " ".join([_triads_text(triads, is_sure),
                                     *(answer.short for answer in rates)]))


def _triads_text(answers: Sequence[Answer], is_sure: bool) -> str:
    """Summary of the triads; ``is_sure`` where nothing contradicts the rates of the plate."""
    if not answers:
        return "Only the rate of the plate was measured: the configuration contains no triad yet."
    good = [answer.subject for answer in answers if answer.standing == "good"]
    incomplete = [answer for answer in answers if answer.standing != "good"]
    if not incomplete:
        names = " and the ".join(good)
        is_good = "The calibration is good: noise" if is_sure else "Noise"
        return f"{is_good} explains the residuals of the {names}."
    sentences = [f"The calibration of the {answer.subject} is not complete: {answer.short}."
                 for answer in incomplete]
    sentences += [f"The calibration of the {triad} is good." for triad in good]
    return " ".join(sentences)


# --- the plate rates -----------------------------------------------------------------------------


def clocks_answer(clocks: Mapping[str, ClockRatio], config: Path) -> Answer | None:
    """The answer on the plate settings whose rate gravity contradicts in the logs; None without."""
    told = {name: ratio for name, ratio in clocks.items() if ratio.contradicts}
    if not told:
        return None
    largest = 100 * max(abs(ratio.difference) for ratio in told.values())
    one = len(told) == 1
    short = (f"The {'rate' if one else 'rates'} of {enumeration([*told], 'and')} "
             f"{'contradicts' if one else 'contradict'} the logs by {largest:.2g} %, and the "
             f"scale of the gyroscope may be off by that.")
    filmed = any(ratio.filmed for ratio in told.values())
    return Answer(
        RATES, "open", short,
        "Not certain: gravity goes round in the accelerometer at another rate.",
        " ".join(ratio.warning(f"rate.{name}") for name, ratio in told.items()),
        "Film the plate in every pose; then:" if filmed else
        "Film the plate with the sensor on it, or state the rate at which it turned; then:",
        "record", (command("run", config),))


def rates_answer(verdicts: Sequence[RateVerdict], config: Path) -> Answer | None:
    """The answer on all plate settings, with one command for all that their rate models lack; None
    where they lack nothing."""
    lacking = [verdict for verdict in verdicts if not verdict.complete]
    if not lacking:
        return None
    short = " ".join(_lacking_sentences(lacking))
    wrong = " ".join([short, *reasons_of(lacking)])
    if all(verdict.in_the_rate for verdict in lacking):
        wrong += (" The stated rates do not depend on it, because every rate is fitted together "
                  "with these waves.")
    targets = [target for verdict in lacking for target in verdict.targets]
    commands = (command("add", config, *targets),) if targets else ()
    worst = max(lacking, key=lambda verdict: verdict.rms_deg)
    good = (f"The rates are measured. The angle residual of the clips still has a shape; the "
            f"largest is {worst.rms_deg:.2g}° RMS ({worst.setting}).")
    return Answer(
        RATES, "open", short, good, wrong,
        "Add all that they lack at once; the phase residuals are printed before and after, and "
        "that is enough:" if commands else
        "Test the terms in the section on the plate rates.",
        "add" if commands else "discover", commands)


def _lacking_sentences(lacking: Sequence[RateVerdict]) -> Iterator[str]:
    """Terms that the rate models lack, a sentence for each."""
    settings: dict[str, list[str]] = {}
    for verdict in lacking:
        settings.setdefault(_lack_of(verdict), []).append(verdict.setting)
    for lack, names in settings.items():
        models = "model" if len(names) == 1 else "models"
        yield (f"The rate {models} of {enumeration(names, 'and')} "
               f"{'lacks' if len(names) == 1 else 'lack'} {lack}.")


def _lack_of(verdict: RateVerdict) -> str:
    """What one rate model lacks, in words."""
    if verdict.one_of:
        return f"{enumeration(verdict.one_of, 'or')}, which its clip does not tell apart"
    return enumeration(verdict.lacks, "and") or "a term that the clip does not determine"


# --- a triad -------------------------------------------------------------------------------------


def triad_answer(outcome: Outcome, result: TriadResult, folder: str) -> Answer:
    """The three answers for one triad."""
    words = result.diagnosis.explanation
    at_once = words.step in ("apply", "add") or result.diagnosis.verdict is Code.BAD_POSE
    films = NEW_CLIPS if result.diagnosis.verdict is Code.NOISE else NEW_FILES
    end = ":" if at_once else films if words.step == "record" else ", then:"
    return Answer(
        result.triad, words.standing, words.short,
        f"{_is_it_good(result)}{_by_gravity(outcome, result)}",
        f"{_nothing_wrong(result) if words.standing == 'good' else words.text}{_aside(result)}",
        f"{ALONG_A_COLUMN if _is_sought_first(outcome, result) else words.following}{end}",
        words.step,
        _commands(outcome, result, folder),
    )


def _is_it_good(result: TriadResult) -> str:
    unit, factor = DISPLAY[result.triad]
    comparison = result.comparison
    fit = result.calibration.fit
    noise = sqrt(float(np.mean(fit.equations.row_sd**2)))
    rms, loo = comparison.residual_rms * factor, comparison.loo_rms * factor
    standing, verdict = result.diagnosis.explanation.standing, result.diagnosis.verdict
    if verdict is Code.NOTHING_MISSING:
        first = ((_mostly_unseen(result) or "Yes.") if standing == "good" else
                 f"Not entirely: {result.diagnosis.explanation.short}.")
        return (
            f"{first} The RMS residual of the {count(len(comparison.poses), 'pose')} is {rms:.2g} "
            f"{unit}, and their own noise has an sd of {two_digits(noise * factor)} {unit}. "
            f"The leave-one-out error, for a pose that takes no part in the fit, is "
            f"{two_digits(loo)} {unit}{loo_by_noise(result)}. "
            f"{_prediction(result)}"
        )
    times = times_stated(fit) if verdict is Code.NOISE else sqrt(fit.chi2 / fit.dof)
    size = (f"{two_digits(times)} times what their own noise leaves" if times > 1 else
            "no larger than their own noise: what is wrong shows in the shape of the residuals")
    return (
        f"{'Not yet' if standing == 'act' else 'Perhaps not'}. The RMS residual of the "
        f"{count(len(comparison.poses), 'pose')} is {two_digits(rms)} {unit}, {size}."
    )


def _by_gravity(outcome: Outcome, result: TriadResult) -> str:
    """How to make the scale more certain, as a sentence, where no latitude is stated."""
    site, reference = outcome.config.site, result.calibration.fit.poses.reference
    if (result.prediction is None or GRAVITY not in reference.common_names
            or (site is not None and site.latitude_deg is not None)):
        return ""
    sd = float(np.abs(reference.common[:, reference.common_names.index(GRAVITY)]).max())
    if 2 * sd**2 < result.prediction.sd_median**2:
        return ""
    unit, factor = DISPLAY[result.triad]
    return (f" Most of that is gravity, which is known to {two_digits(sd * factor)} {unit}: state "
            f"your latitude (`site: {{latitude_deg: ...}}`) and run again.")


def _mostly_unseen(result: TriadResult) -> str:
    """A sentence if the calibration depends on effects that no pose has measured, else empty."""
    prediction = result.prediction
    if prediction is None or not prediction.is_mostly_unseen:
        return ""
    names = enumeration(list(prediction.by_unseen), "and")
    return (f"As far as these poses can see, and they are blind to {names}: what corrected "
            f"readings err by rests on its typical size.")


def _prediction(result: TriadResult) -> str:
    """Expected error on the next log, as a sentence."""
    if result.prediction is None:
        return "Only rest was measured: nothing is known of the gains."
    text = prediction_text(result)
    return f"{text[0].upper()}{text[1:]}."


def _nothing_wrong(result: TriadResult) -> str:
    added = [e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading"]
    text = "These poses show no missing effect."
    if added:
        text += f" The model contains {' and '.join(added)} besides bias, scale and misalignment."
    blind = result.undetermined
    for name, alike in result.diagnosis.stands_for.items():
        text += (f" {name} stands for its class: these poses do not tell it from "
                 f"{enumeration(alike.names, 'or')}.")
    if blind:
        text += f" They cannot determine {count(len(blind), 'effect')}, listed under Candidates."
    return " ".join([text, *untold_of(result)])


def untold_of(result: TriadResult) -> Iterator[str]:
    """Sentences on effects of the model that another log does not tell."""
    by_effect = result.prediction.by_untold if result.prediction is not None else {}
    return untold_notes(result.triad, result.calibration.fit.model.effects, by_effect)


def _aside(result: TriadResult) -> str:
    """The logged columns that the diagnosis does not use, as a sentence; empty without any."""
    columns = result.diagnosis.aside
    if not columns:
        return ""
    text = aside_text(columns)
    return f" {text[0].upper()}{text[1:]}."


def _is_sought_first(outcome: Outcome, result: TriadResult) -> bool:
    """Whether ``discover`` comes before ``add``: a step in time may be one along a logged column.
    """
    return (result.diagnosis.explanation.step == "add"
            and may_follow_a_column(result, outcome.config.covariates))


def _commands(outcome: Outcome, result: TriadResult, folder: str) -> tuple[str, ...]:
    """The commands of the next step."""
    config, step = outcome.config.source.path, result.diagnosis.explanation.step
    if step == "apply":
        place = Path(folder)
        return (f"{command('apply', place)} {LOG}", command("export", place, "--to", "arduino"))
    offered = result.diagnosis.offered(result.diagnosis.name or "")
    add = (command("add", config, f"{result.triad}.{offered}"),)
    if step == "add":
        return (command("discover", config), *add) if _is_sought_first(outcome, result) else add
    if result.diagnosis.verdict is Code.BAD_POSE:
        return (exclude_command(config, result.triad, result.calibration.fit.poses.label,
                                result.diagnosis.group),)
    first = command("discover" if step == "discover" else "run", config)
    if step == "record" and result.diagnosis.verdict is not Code.NOISE:
        first = f"{command('import')} LOGS --into {word(config)}"
    return (first, *(add if result.diagnosis.verdict is Code.EFFECT else ()))
