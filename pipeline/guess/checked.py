"""A configuration that runs: the guess is tried, without a triad that it does not calibrate."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from calib.errors import CalibrationError, Remedy, Undetermined
from calib.poses.imu_log import TRIADS, Triad
from pipeline.config.load import Config, parse_config
from pipeline.errors import PipelineError
from pipeline.guess.agreement import disagreements, implausible, unused_accelerometer
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.files import listed
from pipeline.guess.session import SessionGuess
from pipeline.stages.run import Outcome
from pipeline.text.names import short_name


@dataclass(frozen=True, eq=False)
class CheckedConfig:
    """The text of a configuration and the result of running it.

    The text is empty where no edit mends its fault, but other logs or options of the import.
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

    Poses that are to be recorded again are left out, and a triad that cannot be calibrated, with
    the reason as a comment. It has the whole model: without the misalignment that every sensor
    has, poses that do not determine it would show another effect, or a wrong scale. Where nothing
    runs, both triads stay.
    """
    unused = unused_accelerometer(guess)
    if unused and (guess.scales or not guess.turns):
        return CheckedConfig("", None, (), unused)
    if unused:
        choices = replace(choices, left_out={"accelerometer": unused})
    if guess.at_rest is None and not any(source.rate for source in guess.sources):
        fault = f"there is nothing to calibrate. {'. '.join(guess.doubts)}."
        return CheckedConfig("", None, (), fault)
    if disagreement := next(disagreements(guess), None):
        return CheckedConfig("", None, (), disagreement)
    try:
        for reason in guess.dead.values():
            raise Undetermined(reason)
        checked = _of_sound_poses(guess, path, choices, run)
        return replace(checked, changes=(*(
            f"the {triad} is left out: {why}" for triad, why in choices.left_out.items()),
            *checked.changes))
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
        text = "" if isinstance(error, Undetermined) else config_text(guess, path.parent, choices)
        return CheckedConfig(text, None, (), str(error))


def _of_sound_poses(
    guess: SessionGuess, path: Path, choices: Choices, run: Callable[[Config], Outcome]
) -> CheckedConfig:
    """The configuration without the poses that an error wants to be recorded again.

    Raises
    ------
    CalibrationError, PipelineError
        The first that another one follows, or that takes half of the poses of a setting.
    """
    sound, changes = guess, list[str]()
    first: CalibrationError | PipelineError | None = None
    while True:
        text = config_text(sound, path.parent, choices)
        try:
            outcome = run(parse_config(path, text))
            return CheckedConfig(text, outcome, tuple(changes), implausible(outcome))
        except (CalibrationError, PipelineError) as error:
            first = first or error
            again = _named(sound, str(error))
            kept = [tuple(table for table in source.tables if table.path not in again)
                    for source in sound.sources]
            remedy = getattr(error, "remedy", None)
            if not again or remedy != Remedy("exclude_pose") or any(
                    2 * len(tables) <= len(source.tables)
                    for tables, source in zip(kept, guess.sources, strict=True)):
                raise first from None
            changes.append(f"{listed(again)}: left out. {error}")
            sound = replace(sound, doubts=(*sound.doubts, changes[-1]), sources=tuple(
                replace(source, tables=tables)
                for source, tables in zip(sound.sources, kept, strict=True)))


def _named(guess: SessionGuess, error: str) -> list[Path]:
    """The files that an error names."""
    paths = [table.path for table in guess.tables]
    return [path for path in paths
            if re.search(rf"(?<![\w./-]){re.escape(short_name(path, paths))}", error)]


def _culprits(guess: SessionGuess, error: Exception) -> list[Triad]:
    """The triads without which a configuration may run, those that the error names first."""
    if guess.accelerometer is None or guess.gyroscope is None:
        return []
    able = TRIADS[::-1] if guess.turns else ("gyroscope",)  # at rest it shows a bias
    return sorted(able, key=lambda triad: not str(error).startswith(triad))
