"""The next step of a session in one line, from the answers on its triads and plates."""

from collections.abc import Iterator
from pathlib import Path

from calib.diagnosis.next_measurement.advice import DIRECTIONS
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.wording import minutes_of
from calib.poses.attitudes import direction_name
from pipeline.console.answers import NEW_FILES, answers_of, untold_of
from pipeline.console.run_text import aside_text
from pipeline.results.names import RESULTS_NAME
from pipeline.stages.run import Outcome
from pipeline.stages.session_logs import settings_of
from pipeline.text.names import command, word


def next_lines(outcome: Outcome, folder: Path) -> Iterator[str]:
    """The next step, after the logged columns that no diagnosis of what is missing looked at."""
    for result in outcome.triads:
        aside = result.diagnosis.aside if outcome.config.covariates is None else ()
        if aside and result.diagnosis.verdict is not Code.NOTHING_MISSING:
            yield f"{result.triad}: {aside_text(aside)}"
    yield next_line(outcome, folder)


def next_line(outcome: Outcome, folder: Path) -> str:
    """The next step of a session for the terminal, taken from its worst answer."""
    config = outcome.config.source.path
    answers = answers_of(outcome, str(folder))
    answer = next((answer for answer in answers if answer.commands), None)
    if answer is None:
        return f"next: add the sections accelerometer and gyroscope to {word(config)}"
    first, *others = answer.commands
    if answer.step == "apply":
        if not (folder / RESULTS_NAME).is_file():  # `diagnose` and `discover` write none
            return f"next: {command('run', config)}"
        return "\n".join([*(note for result in outcome.triads for note in untold_of(result)),
                          f"next: {first}"])
    if answer.step in ("add", "discover"):
        return f"next: {first}"
    if answer.next.endswith(NEW_FILES) and (listed := _attitudes_of_both(outcome)):
        return f"next: record {listed}{NEW_FILES} {first}"
    steps = {each.next: each.subject for each in answers if each.next.endswith(NEW_FILES)}
    if answer.next in steps and len(steps) > 1:  # one session serves both triads
        named = "; ".join(f"for the {subject} {_lower(step.removesuffix(NEW_FILES))}"
                          for step, subject in steps.items())
        return f"next: {named}{NEW_FILES} {first}"
    line = f"next: {_lower(answer.next)} {first}"
    return line + "".join(f"\nor see the errors with it: {other}" for other in others)


def _attitudes_of_both(outcome: Outcome) -> str:
    """One list of the attitudes that both triads lack, where the same poses serve both; else empty.
    """
    lacking = [result for result in outcome.triads if result.diagnosis.advice is not None
               and result.diagnosis.advice.block == DIRECTIONS and result.prediction is not None]
    runs = [{*settings_of(outcome.config, result.triad)} for result in lacking]
    if len(lacking) < 2 or any(one != runs[0] for one in runs):
        return ""
    names = dict.fromkeys(direction_name(each) for result in lacking if result.prediction
                          for each in result.prediction.wanted)
    listed = f"poses with {', '.join(names)} ({minutes_of(len(names))}), for both triads"
    return listed if names else ""


def _lower(text: str) -> str:
    return text[0].lower() + text[1:]
