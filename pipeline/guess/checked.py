"""A configuration that runs: the guess is tried, and what the poses do not carry is taken out."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.data_sheet import gain_off_the_sheet
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Undetermined
from calib.poses.imu_log import TRIADS
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.load import Config, parse_config
from pipeline.config.types import STOPPED
from pipeline.errors import PipelineError
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.session import SessionGuess
from pipeline.stages.run import Outcome

#: From the largest to the smallest; a bias alone is no calibration of an accelerometer.
MODELS = {"accelerometer": (BASE, ("bias", "scale")), "gyroscope": (BASE, ("bias", "scale"),
                                                                    ("bias",))}
MOST_TRIES = sum(map(len, MODELS.values())) + len(TRIADS) + 1
"""Derived: for each triad every smaller model and its removal, and the last try."""

LARGEST_MISFIT = 0.02
"""Residual over the reference, root mean square, of a model that can be right. A judgement: after
bias and scale the cheapest sensor leaves less than 1 %; wrong columns or units leave 10 %."""
LARGEST_WANDER = 100.0
"""Scatter of a gyroscope's bias from pose to pose over the noise of a mean, at most. A judgement:
a cheap one that warms up moves by 20 times it."""


@dataclass(frozen=True, eq=False)
class CheckedConfig:
    """The text of a configuration, and what came of running it.

    ``outcome`` is None where it does not run; ``changes`` say what the check took out, ``fault``
    why nothing was left, or what makes the outcome implausible.
    """

    text: str
    outcome: Outcome | None
    changes: tuple[str, ...]
    fault: str | None = None


def checked_config(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> CheckedConfig:
    """The configuration of ``guess`` at ``path`` that runs; nothing is written.

    A model that the poses do not determine gives way to the largest that they do; a triad that
    cannot be calibrated at all is left out, with the reason as a comment.
    """
    fault: str | None = None
    if guess.at_rest is None and not any(source.rate for source in guess.sources):
        fault = f"it has nothing to calibrate. {'. '.join(guess.doubts)}."
        return CheckedConfig(config_text(guess, path.parent, choices), None, (), fault)
    changes: list[str] = []
    for _ in range(MOST_TRIES):
        text = config_text(guess, path.parent, choices)
        try:
            outcome = run(parse_config(path, text))
            return CheckedConfig(text, outcome, tuple(changes), implausible(outcome))
        except (CalibrationError, PipelineError) as error:
            fault = str(error)
            smaller = _smaller(choices, error)
            if smaller is not None:
                changes.append(f"the poses do not determine the whole model: {error}")
                choices = smaller
                continue
            triad = _culprit(guess, path, choices, run)
            turning = any(source.rate not in (None, STOPPED) for source in guess.sources)
            if triad is None or (triad == "accelerometer" and not turning):
                break  # of a gyroscope at rest there is no more than a bias
            changes.append(f"the {triad} is left out: {error}")
            choices = replace(choices, left_out={**choices.left_out, triad: fault})
    return CheckedConfig(config_text(guess, path.parent, choices), None, tuple(changes), fault)


def _smaller(choices: Choices, error: Exception) -> Choices | None:
    """The choices with the next smaller model, where a triad's poses carry no larger one."""
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
    """The triad without which the rest runs; None where only one is left."""
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


def implausible(outcome: Outcome) -> str | None:
    """Why an outcome cannot be right although it fits; None where nothing speaks against it."""
    for result in outcome.triads:
        spec, triad = result.calibration.spec, result.triad
        reference = result.calibration.fit.poses.reference.magnitude
        size = float(np.sqrt(np.mean(reference**2)))
        share = result.comparison.residual_rms / size if size else 0.0
        if share > LARGEST_MISFIT:
            against = TRIAD_KINDS[triad].reference
            return (f"the {triad}'s poses differ from {against} by {share:.1%} (root mean "
                    f"square), more than any sensor after its calibration. One of these is wrong: "
                    f"its columns, its unit, or files of two sensors or ranges together.")
        misfit = result.calibration.fit.chi2 / max(result.calibration.fit.dof, 1)
        if not size and misfit > LARGEST_WANDER**2:
            return (f"the {triad}'s poses at rest scatter by {misfit**0.5:.0f} times their own "
                    f"noise, which no bias does. Its columns are another sensor's, or it moved.")
        if off := next(gain_off_the_sheet(result.calibration.parameters, spec, triad), ""):
            return off
    return None
