"""A model change at the terminal: run, change the model, run again, print both results."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from calib.diagnosis.verdict.wording import enumeration
from calib.errors import CalibrationError
from pipeline.commands.interaction.output import echo_verdict, echo_warnings
from pipeline.commands.interaction.run_with_progress import run_shown, say_waiting
from pipeline.config.load import Config
from pipeline.console.next_step import next_lines
from pipeline.console.run_text import change_lines, pose_change_lines
from pipeline.errors import ConfigError, UnreadableInput, message_of
from pipeline.exclusion import excluding
from pipeline.model_change import (
    ModelChange,
    Target,
    change_model,
    note_on,
    overruled,
    read_target,
)
from pipeline.next_change import (
    MOST_CHANGES,
    change_for_unknown,
    error_falls,
    is_noise,
    next_change,
    whole,
    without_noise,
)
from pipeline.report.page import outputs_of
from pipeline.results.history import HISTORY_NAME
from pipeline.session_folder import working_on, write_session
from pipeline.stages.context import CACHE_NAME, RunContext
from pipeline.stages.run import Outcome, average_session
from pipeline.text.names import command


@dataclass(frozen=True)
class Manner:
    """Settings of the runs and their display; ``quiet`` leaves out progress and tables."""

    allow_python: bool
    quiet: bool

    def runner(self, folder: Path) -> Callable[[Config], Outcome]:
        """A run of a configuration with its cache in ``folder``; the logs are read once.

        Its warnings are printed of the last alone: of one before, a change may have removed them.
        """
        latest: list[Outcome] = []

        def run(config: Config) -> Outcome:
            latest[:] = [run_shown(config, folder, self.allow_python, bars=not self.quiet,
                                 warnings=False, before=latest[0] if latest else None)]
            return latest[0]

        return run

    def show(self, lines: Iterable[str], note: str = "") -> None:
        """Print the errors before and after, and a note."""
        if not self.quiet:
            click.echo("\n".join([*lines, ""]))
        if note:
            echo_warnings([note], "note")


def change_and_show(
    path: Path,
    targets: Sequence[str],
    manner: Manner,
    *,
    remove: bool = False,
    anyway: bool = False,
) -> None:
    """Change the model by ``targets``, one after the other; print each and write the last.

    If a target is refused, the configuration stays as it was before the first.
    """
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = manner.runner(folder)
        changes: list[ModelChange] = []
        for target in targets:
            before = changes[-1].after if changes else None
            now = before.config if before is not None else config
            try:
                changes.append(change_model(now, read_target(now, target), run, before=before,
                                            remove=remove, anyway=anyway))
            except (CalibrationError, ConfigError):
                if changes:
                    click.echo(f"{path} was not changed: {target} is refused.", err=True)
                raise
            manner.show(change_lines(changes[-1]), note_on(changes[-1]))
        write_change(config, changes[0].before, changes[-1].after, folder)
    if anyway:
        reasons = filter(None, map(overruled, changes))
        echo_warnings(f"--anyway overrules: {reason}" for reason in reasons)
    say_change(changes[-1].after, folder, manner.quiet)


def exclude_and_show(path: Path, poses: Sequence[str], manner: Manner) -> None:
    """Exclude ``poses``; print the errors before and after, and write both files.

    A session that is refused, perhaps for these very poses, is changed too.
    """
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = manner.runner(folder)
        before = as_it_stands(config, run)
        recordings = None if before is None else before.recordings
        if before is None and not all(one.poses.files for _, one in config.placed_runs()):
            context = RunContext(folder / CACHE_NAME, allow_python=manner.allow_python)
            recordings = average_session(config, context)[1]
        changed, notes = excluding(config, recordings, poses)
        echo_warnings(notes, "note")
        try:
            after = run(changed)
        except (CalibrationError, UnreadableInput):
            if before is None:
                write_session(folder, {}, config, changed.source.text)
                click.echo(f"{path} was changed. Without these poses:", err=True)
            raise
        if before is not None:
            manner.show(pose_change_lines(before, after))
        write_change(config, before, after, folder)
    say_change(after, folder, manner.quiet or before is None)


def as_it_stands(config: Config, run: Callable[[Config], Outcome]) -> Outcome | None:
    """A session before it is changed; None where it is refused, which is reported."""
    try:
        return run(config)
    except (CalibrationError, UnreadableInput) as error:
        click.echo(f"As it stands: {message_of(error)}", err=True)
        return None


def add_until_settled(path: Path, manner: Manner) -> None:
    """Add effects that the diagnosis names, or else that discovery finds, again and again.

    An effect that does not lower the expected error in new attitudes is not kept, and a noise goes
    again once effects that are added after it explain what it stood for.
    """
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = manner.runner(folder)
        outcome = run(config)
        write_session(folder, outputs_of(outcome, folder))
        refused: list[Target] = []
        noises: list[Target] = []
        for _ in range(MOST_CHANGES):
            changes = next_change(outcome, run, refused)
            if not changes and (change := change_for_unknown(outcome, run, refused)):
                changes = [change]
            if not changes:
                break
            for change in changes:
                manner.show(change_lines(change), note_on(change))
            if not error_falls(whole(changes)):
                target = changes[-1].target
                click.echo(f"{target} is not kept: what corrected readings are expected to err by "
                           f"in new attitudes does not fall with it.")
                refused.append(target)
                continue
            for change in changes:  # each has a line of its own in the history
                write_change(change.before.config, change.before, change.after, folder)
            outcome = changes[-1].after
            if is_noise(changes[-1]):
                noises.append(changes[-1].target)
                continue
            for noise in tuple(noises):
                after = without_noise(outcome, noise, run, refused)
                if after is not None:
                    click.echo(f"{noise} is taken out again: it stood for what is named now.")
                    write_change(outcome.config, outcome, after, folder)
                    noises.remove(noise)
                    outcome = after
    for result in outcome.triads:
        echo_verdict(result)
    if outcome.config.source.text == config.source.text:
        echo_warnings(outcome.warnings)
        click.echo(f"{path} was not changed: {_why_unchanged(outcome, refused)}.")
        click.echo("\n".join(next_lines(outcome, folder)))
        return
    say_change(outcome, folder)


def _why_unchanged(outcome: Outcome, refused: Sequence[Target]) -> str:
    if refused:
        return "with no effect that was tried does that error fall"
    for result in outcome.triads:
        named = result.diagnosis.named_class(result.diagnosis.name or "")
        if len(named) > 1:
            members = enumeration([f"'{name}'" for name in named], "and")
            return (f"these data do not separate {members}, which correct other attitudes "
                    f"differently, and --auto does not guess")
    return "the diagnosis names no effect to add"


def write_change(config: Config, before: Outcome | None, after: Outcome, folder: Path) -> None:
    """Write the configuration and its results together; the history begins with those before."""
    if before is not None and not (folder / HISTORY_NAME).exists():
        write_session(folder, outputs_of(before, folder))
    write_session(folder, outputs_of(after, folder), config, after.config.source.text)


def say_change(outcome: Outcome, folder: Path, verdicts: bool = False) -> None:
    """Print warnings, the verdicts where they are asked for, and the next command."""
    echo_warnings(outcome.warnings)
    if verdicts:
        for result in outcome.triads:
            echo_verdict(result)
    path = outcome.config.source.path
    click.echo(f"{path} was changed. `{command('history', path)}` lists all runs.")
    click.echo("\n".join(next_lines(outcome, folder)))
