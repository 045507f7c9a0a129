"""A configuration that runs: the guess is tried and reduced to what the poses determine."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Undetermined
from calib.poses.imu_log import TRIADS
from pipeline.config.load import Config, parse_config
from pipeline.config.types import STOPPED
from pipeline.errors import PipelineError
from pipeline.guess.agreement import disagreements, implausible
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.session import SessionGuess
from pipeline.logs.clock import ASSUMED_HZ
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult

#: Models from the largest to the smallest; a bias alone does not calibrate an accelerometer.
MODELS = {"accelerometer": (BASE, ("bias", "scale")), "gyroscope": (BASE, ("bias", "scale"),
                                                                    ("bias",))}
LARGEST_SCALE_SD = 0.02
"""Relative sd of a scale from which poses show no more than the data sheet. Fact: those of low-cost
sensors state 1 to 3 %."""
MOST_TRIES = sum(map(len, MODELS.values())) + len(TRIADS) + 1
"""Number of tries. Derived: for each triad every smaller model and its removal, and the last."""


@dataclass(frozen=True, eq=False)
class CheckedConfig:
    """The text of a configuration and the result of running it.

    ``outcome`` is None if it does not run; ``changes`` list what the check removed, ``fault``
    states why nothing was left, or what makes the outcome implausible. ``needs_import``: no edit of
    the text mends that, but other logs or options.
    """

    text: str
    outcome: Outcome | None
    changes: tuple[str, ...]
    fault: str | None = None
    needs_import: bool = False


def checked_config(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> CheckedConfig:
    """A configuration of ``guess`` at ``path`` that runs; no file is written.

    A model that the poses do not determine is replaced by the largest that they do and that
    describes them; a triad that cannot be calibrated at all is left out, with the reason as a
    comment. Where nothing runs, the whole model is written, with what it lacks.
    """
    first: Exception | None = None
    if guess.at_rest is None and not any(source.rate for source in guess.sources):
        fault = f"it has nothing to calibrate. {'. '.join(guess.doubts)}."
        return CheckedConfig(config_text(guess, path.parent, choices), None, (), fault, True)
    if disagreement := next(disagreements(guess), None):
        return CheckedConfig(config_text(guess, path.parent, choices), None, (), disagreement, True)
    changes: dict[str, str] = {}
    lacking: dict[str, Exception] = {}
    whole = choices
    for _ in range(MOST_TRIES):
        text = config_text(guess, path.parent, choices)
        try:
            outcome = run(parse_config(path, text))
            for result in outcome.triads:
                if result.triad in lacking and not _is_of_use(result):
                    raise lacking[result.triad]
            return CheckedConfig(text, outcome, tuple(changes.values()), implausible(outcome))
        except (CalibrationError, PipelineError) as error:
            first = first or error
            smaller = _smaller(choices, error)
            if smaller is not None:
                triad, model = smaller
                lacking.setdefault(triad, error)
                changes.setdefault(triad, f"the poses do not determine the whole model: {error}")
                choices = replace(choices, models={**choices.models, triad: model})
                continue
            there = [name for name in TRIADS
                     if getattr(guess, name) and name not in choices.left_out]
            turning = any(source.rate not in (None, STOPPED) for source in guess.sources)
            culprit = None if len(there) < len(TRIADS) else (
                _triad_of(error) or _culprit(guess, path, choices, run))
            if culprit is None or (culprit == "accelerometer" and not turning):
                break  # a gyroscope at rest shows no more than a bias
            changes[culprit] = f"the {culprit} is left out: {error}"
            choices = replace(choices, left_out={**choices.left_out, culprit: str(error)})
    fault = str(first)
    if any(not table.clock.is_known and not table.are_means for table in guess.tables):
        fault = (f"{fault} The file states no sample rate, and {ASSUMED_HZ:g} Hz is no more than "
                 f"usual: state it by --rate-hz.")
    return CheckedConfig(config_text(guess, path.parent, whole), None, (), fault,
                         isinstance(first, Undetermined))


def _is_of_use(result: TriadResult) -> bool:
    """Whether a smaller model describes the poses, and shows more than the data sheet.

    The misalignment that every sensor has may look like another effect, or like a scale.
    """
    if not result.calibration.fit.poses.reference.magnitude.any():
        return True  # at rest a gyroscope shows its bias
    parameters = result.calibration.parameters
    known = parameters.sd[-1] < LARGEST_SCALE_SD * np.abs(parameters.scale_counts_per_unit)
    return bool(known.all()) and result.diagnosis.verdict is Code.NOTHING_MISSING


def _triad_of(error: Exception) -> str | None:
    """The triad whose poses do not determine its model; None for another error."""
    if not isinstance(error, Undetermined):
        return None
    if error.remedy is not None and error.remedy.kind == "smaller_model" and error.remedy.triad:
        return error.remedy.triad
    return next((name for name in TRIADS if str(error).startswith(f"{name}:")), None)


def _smaller(choices: Choices, error: Exception) -> tuple[str, tuple[str, ...]] | None:
    """The triad whose poses determine no larger model, and its next smaller one."""
    triad = _triad_of(error)
    now = tuple(choices.models.get(triad or "", BASE))
    smaller = [model for model in MODELS[triad] if len(model) < len(now)] if triad else []
    return (triad, smaller[0]) if triad and smaller else None


def _culprit(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> str | None:
    """The triad without which the configuration runs; None if there is none."""
    for triad in reversed(TRIADS):
        without = replace(choices, left_out={**choices.left_out, triad: "?"})
        try:
            run(parse_config(path, config_text(guess, path.parent, without)))
        except (CalibrationError, PipelineError) as error:
            if _smaller(without, error) is not None:
                return triad
            continue
        return triad
    return None
