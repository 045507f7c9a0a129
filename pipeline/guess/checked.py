"""A configuration that runs: the guess is tried and reduced to what the poses determine."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

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

#: Models from the largest to the smallest; a bias alone does not calibrate an accelerometer.
MODELS = {"accelerometer": (BASE, ("bias", "scale")), "gyroscope": (BASE, ("bias", "scale"),
                                                                    ("bias",))}
MOST_TRIES = sum(map(len, MODELS.values())) + len(TRIADS) + 1
"""Number of tries. Derived: for each triad every smaller model and its removal, and the last."""


@dataclass(frozen=True, eq=False)
class CheckedConfig:
    """The text of a configuration and the result of running it.

    ``outcome`` is None if it does not run; ``changes`` list what the check removed, ``fault``
    states why nothing was left, or what makes the outcome implausible.
    """

    text: str
    outcome: Outcome | None
    changes: tuple[str, ...]
    fault: str | None = None


def checked_config(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> CheckedConfig:
    """A configuration of ``guess`` at ``path`` that runs; no file is written.

    A model that the poses do not determine is replaced by the largest that they do; a triad that
    cannot be calibrated at all is left out, with the reason as a comment. Where nothing runs, the
    whole model is written, with what it lacks.
    """
    fault: str | None = None
    if guess.at_rest is None and not any(source.rate for source in guess.sources):
        fault = f"it has nothing to calibrate. {'. '.join(guess.doubts)}."
        return CheckedConfig(config_text(guess, path.parent, choices), None, (), fault)
    if fault := next(disagreements(guess), None):
        return CheckedConfig(config_text(guess, path.parent, choices), None, (), fault)
    changes: list[str] = []
    whole = choices
    for _ in range(MOST_TRIES):
        text = config_text(guess, path.parent, choices)
        try:
            outcome = run(parse_config(path, text))
            return CheckedConfig(text, outcome, tuple(changes), implausible(outcome))
        except (CalibrationError, PipelineError) as error:
            fault = fault or str(error)
            smaller = _smaller(choices, error)
            if smaller is not None:
                changes.append(f"the poses do not determine the whole model: {error}")
                choices = smaller
                continue
            triad = _culprit(guess, path, choices, run)
            turning = any(source.rate not in (None, STOPPED) for source in guess.sources)
            if triad is None or (triad == "accelerometer" and not turning):
                break  # a gyroscope at rest shows no more than a bias
            changes.append(f"the {triad} is left out: {error}")
            choices = replace(choices, left_out={**choices.left_out, triad: str(error)})
    if any(not table.clock.is_known and not table.are_means for table in guess.tables):
        fault = (f"{fault} The file states no sample rate, and {ASSUMED_HZ:g} Hz is no more than "
                 f"usual: state it by --rate-hz.")
    return CheckedConfig(config_text(guess, path.parent, whole), None, (), fault)


def _smaller(choices: Choices, error: Exception) -> Choices | None:
    """The choices with the next smaller model, if a triad's poses determine no larger one."""
    if not isinstance(error, Undetermined):
        return None
    remedy = error.remedy
    triad: str | None = next((name for name in TRIADS if str(error).startswith(f"{name}:")), None)
    if remedy is not None and remedy.kind == "smaller_model" and remedy.triad is not None:
        triad = remedy.triad
    if triad is None:
        return None
    now = tuple(choices.models.get(triad, BASE))
    smaller = [model for model in MODELS[triad] if len(model) < len(now)]
    return replace(choices, models={**choices.models, triad: smaller[0]}) if smaller else None


def _culprit(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> str | None:
    """The triad without which the configuration runs; None if only one triad is left."""
    there = [triad for triad in TRIADS if getattr(guess, triad) and triad not in choices.left_out]
    if len(there) < len(TRIADS):
        return None
    for triad in reversed(there):
        without = replace(choices, left_out={**choices.left_out, triad: "?"})
        try:
            run(parse_config(path, config_text(guess, path.parent, without)))
        except (CalibrationError, PipelineError) as error:
            if _smaller(without, error) is not None:
                return triad
            continue
        return triad
    return None
