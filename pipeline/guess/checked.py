"""A configuration that runs: the guess is tried, without a triad that it does not calibrate."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from calib.errors import CalibrationError, Undetermined
from calib.poses.imu_log import Triad
from pipeline.config.load import Config, parse_config
from pipeline.config.types import STOPPED
from pipeline.errors import PipelineError
from pipeline.guess.agreement import disagreements, implausible
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.session import SessionGuess
from pipeline.logs.clock import ASSUMED_HZ
from pipeline.stages.run import Outcome


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

    A triad that cannot be calibrated is left out, with the reason as a comment. It has the whole
    model: without the misalignment that every sensor has, poses that do not determine it would
    show another effect, or a wrong scale. Where nothing runs, both triads stay.
    """
    text = config_text(guess, path.parent, choices)
    if guess.at_rest is None and not any(source.rate for source in guess.sources):
        fault = f"it has nothing to calibrate. {'. '.join(guess.doubts)}."
        return CheckedConfig(text, None, (), fault, True)
    if disagreement := next(disagreements(guess), None):
        return CheckedConfig(text, None, (), disagreement, True)
    try:
        if guess.dead_axis:
            raise Undetermined(guess.dead_axis)
        outcome = run(parse_config(path, text))
        return CheckedConfig(text, outcome, (), implausible(outcome))
    except (CalibrationError, PipelineError) as error:
        for triad in _culprits(guess, error):
            without = config_text(guess, path.parent, replace(choices, left_out={
                triad: str(error)}))
            try:
                outcome = run(parse_config(path, without))
            except (CalibrationError, PipelineError):
                continue
            return CheckedConfig(without, outcome, (f"the {triad} is left out: {error}",),
                                 implausible(outcome))
        fault = str(error)
        if any(not table.clock.is_known and not table.are_means for table in guess.tables):
            fault = (f"{fault} The file states no sample rate, and {ASSUMED_HZ:g} Hz is no more "
                     f"than usual: state it by --rate-hz.")
        return CheckedConfig(text, None, (), fault, isinstance(error, Undetermined))


def _culprits(guess: SessionGuess, error: Exception) -> list[Triad]:
    """The triads without which a configuration may run, those that the error names first."""
    if guess.accelerometer is None or guess.gyroscope is None:
        return []
    turning = any(source.rate not in (None, STOPPED) for source in guess.sources)
    able = ["gyroscope", "accelerometer"] if turning else ["gyroscope"]  # at rest it shows a bias
    return sorted(able, key=lambda triad: not str(error).startswith(f"{triad}:"))
