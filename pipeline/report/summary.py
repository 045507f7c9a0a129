"""The verdict for somebody who has never met the words: is it good, what is wrong, what next."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from calib.effects.catalogue import find_effect
from calib.errors import CalibrationError
from calib.poses.attitudes import direction_name
from pipeline.console.run_text import prediction_text
from pipeline.formatting import DISPLAY, count
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

#: Verdict of a diagnosis -> how it stands: a word and a sign, since colour alone says nothing.
STANDING = {
    "nothing_missing": ("good", "✓"),
    "effect": ("act", "!"),
    "ambiguous": ("open", "?"),
    "unknown": ("act", "!"),
    "bad_pose": ("act", "!"),
    "noise": ("open", "?"),
}
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
    code = result.diagnosis.verdict
    standing, sign = STANDING[code]
    short, wrong = _wrong(result)
    if standing == "good" and _lost_direction(result):
        standing, sign = "open", "?"
        short = "directions are missing among its poses"
    following, commands = _next(result, config, shlex.quote(folder))
    return Answer(
        result.triad, standing, sign, short, _is_it_good(result), wrong, following, commands
    )


def _is_it_good(result: TriadResult) -> str:
    unit, factor = DISPLAY[result.triad]
    comparison = result.comparison
    noise = sqrt(float(np.mean(result.calibration.fit.equations.row_sd**2)))
    rms, loo = comparison.residual_rms * factor, comparison.loo_rms * factor
    if result.diagnosis.verdict == "nothing_missing":
        first = _lost_direction(result) or "Yes."
        return (
            f"{first} The {count(len(comparison.poses), 'pose')} lie {rms:.2g} {unit} (root mean "
            f"square) from the model, as their own noise of {noise * factor:.2g} {unit} lets one "
            f"expect. A pose that takes no part in the fit is predicted to {loo:.2g} {unit}. "
            f"{_prediction(result)}"
        )
    times = comparison.residual_rms / noise
    return (
        f"{'Not yet' if times > 2 else 'Perhaps not'}. The {count(len(comparison.poses), 'pose')} "
        f"lie {rms:.2g} {unit} (root mean square) from the model, {times:.2g} times their own "
        f"noise of {noise * factor:.2g} {unit}."
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


def _quoted(names: Sequence[str]) -> str:
    return " or ".join(_readable(name) for name in names)


def _readable(name: str) -> str:
    if name.startswith("~"):
        return f"something that follows {name[1:]}"
    return {"jump": "a jump of the bias", "bad_pose": "one bad pose",
            "noise": "more noise than stated"}.get(name, name)


def _wrong(result: TriadResult) -> tuple[str, str]:
    """What is wrong in a few words, and in two or three sentences."""
    found = result.diagnosis
    if found.verdict == "nothing_missing":
        return "nothing is missing", _nothing_wrong(result)
    if found.verdict == "effect" and found.name is not None:
        return _missing(result, found.name)
    if found.verdict == "ambiguous":
        return "something may be missing, and these data cannot tell what", (
            f"Something may be missing. It could be {_quoted(found.group)}; in these poses they "
            f"look too much alike, or too small, to say which."
        )
    short = {
        "unknown": f"the misfit follows {found.name}, in a way that no listed effect does",
        "bad_pose": f"the pose {found.name} contradicts the others",
        "noise": "the residual is larger than the noise, without any shape",
    }[found.verdict]
    return short, found.says


def _nothing_wrong(result: TriadResult) -> str:
    added = [e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading"]
    says = "Nothing that these poses can see."
    if added:
        says += f" The model holds {' and '.join(added)} besides bias, scale and misalignment."
    blind = result.diagnosis.blind
    if blind:
        says += f" They cannot see {', '.join(blind)}; the boxes below say why."
    return says


def _missing(result: TriadResult, name: str) -> tuple[str, str]:
    found = result.diagnosis
    best = next(c for c in found.ranking if c.name == name and c.kind == "listed")
    share = 100 * best.chi2_drop / result.calibration.fit.chi2
    says = f"The model lacks {name}: {_physics(name)} It explains {share:.0f} % of the misfit."
    short = f"its model lacks {name}"
    if len(found.group) > 1:
        others = _quoted(found.group[1:])
        says += f" In these poses {others} would look the same."
        short = f"its model lacks {name} or {others}, which look the same here"
    if found.partner is not None:
        says += f" A second effect shows beside it: {found.partner}."
    return short, says


def _physics(name: str) -> str:
    try:
        said = find_effect(name).physics
    except CalibrationError:
        return "your own effect."
    return said[0].lower() + said[1:]


def _next(result: TriadResult, config: str, folder: str) -> tuple[str, tuple[str, ...]]:
    """What to do, and the commands."""
    found = result.diagnosis
    run = f"pipeline run {config}"
    if found.verdict == "nothing_missing":
        return "Correct a log, or hand the calibration to another program:", (
            f"pipeline apply {folder} {LOG} --output calibrated.csv",
            f"pipeline export {folder} --to arduino",
        )
    if found.verdict == "effect" and len(found.group) == 1:
        return "Add it; everything is refitted together and the error shown before and after:", (
            f"pipeline add {config} {result.triad}.{found.name}",
        )
    if found.record_next:
        return f"Record {found.record_next}; name the new logs in the configuration and run:", (
            run,
        )
    if found.verdict == "bad_pose":
        return "Record that pose again, or take it out of the list of poses, and run:", (run,)
    if found.verdict == "effect":
        separates = find_effect(found.group[0]).page.separates
        return f"What tells them apart: {separates}. Then run:", (run,)
    if found.verdict == "unknown":
        return ("If you know its physics, write it as your own effect under `effects:` in the "
                "configuration; the charts below show its shape:"), (f"pipeline diagnose {config}",)
    return "Record the same poses once more, for longer and in random order, and run:", (run,)
