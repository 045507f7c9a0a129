"""Further logs at the terminal: shown, fitted with all others, then written."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.commands.interaction.model_change import (
    Manner,
    as_it_stands,
    say_change,
    write_change,
)
from pipeline.commands.interaction.output import echo_warnings
from pipeline.commands.interaction.run_with_progress import say_waiting
from pipeline.config.load import config_from
from pipeline.console.further_text import further_lines
from pipeline.console.run_text import pose_change_lines
from pipeline.errors import ConfigError
from pipeline.further.logs import Known, further_logs, unused_clips
from pipeline.further.text import places_for, with_further
from pipeline.guess.agreement import implausible
from pipeline.guess.files import is_clip, measured_clips, rates_of_clips
from pipeline.session_folder import working_on
from pipeline.stages.context import CACHE_NAME, RunContext
from pipeline.stages.run import average_session


def bring_and_show(
    path: Path, files: Sequence[Path], triads: Sequence[str], manner: Manner
) -> None:
    """Add the logs and clips ``files`` to the runs of ``triads``, all by default; print what they
    are and the errors before and after.

    If one of them is refused, nothing is written.
    """
    with working_on(path, on_wait=say_waiting) as (config, folder):
        run = manner.runner(folder)
        before = as_it_stands(config, run)
        context = RunContext(folder / CACHE_NAME, allow_python=manner.allow_python)
        rates, recordings = (average_session(config, context) if before is None else
                             (before.rates, before.recordings))
        fits = {each.triad: each.calibration for each in (before.triads if before else ())}
        films = [file for file in files if is_clip(file)]
        clips = measured_clips(rates_of_clips(films, context))
        logs = further_logs(
            config, Known.of(config, fits, rates, recordings),
            [file for file in files if not is_clip(file)], clips)
        places = [place for place in places_for(config, logs)
                  if not triads or place.triad in triads]
        changed = config_from(with_further(config, logs, places))
        manner.show(further_lines(logs, places, path.absolute().parent))
        echo_warnings(unused_clips(clips, logs))
        after = run(changed)
        if fault := implausible(after):
            raise ConfigError(f"{path} was not changed, because with these logs {fault}")
        if before is not None:
            manner.show(pose_change_lines(before, after))
        write_change(config, before, after, folder)
    say_change(after, folder, manner.quiet or before is None)
