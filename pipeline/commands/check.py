"""``pipeline check CONFIG``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import echo_json, echo_warnings, json_option, quiet_option

if TYPE_CHECKING:
    from pipeline.config.load import Config
    from pipeline.stages.rehearsal import Rehearsal


@click.command(epilog=examples(
    "pipeline check config.yaml",
    "pipeline check config.yaml --quiet && pipeline run config.yaml",
    "pipeline check config.yaml --json",
))
@click.argument("config", type=ConfigArgument())
@json_option("the sections, or the errors,")
@quiet_option("errors")
def command(config: Path, as_json: bool, quiet: bool) -> None:
    """Validate CONFIG, read its logs, and list every error with its line.

    The command averages the poses and fits the models as `pipeline run` does, and makes the same
    checks except those that need the clips. It also refuses planned poses (the section `record`)
    that cannot determine the model. It opens no clip, runs no Python and writes nothing.
    """
    from calib.errors import CalibrationError
    from pipeline.console.check_text import config_json, config_lines
    from pipeline.errors import ConfigError, PipelineError, exit_code_of, message_of

    try:
        loaded, rehearsal = _checked(config)
    except (PipelineError, CalibrationError) as error:
        if as_json:
            problems = error.problems if isinstance(error, ConfigError) else (message_of(error),)
            echo_json({"config": str(config), "exit_code": exit_code_of(error),
                       "problems": problems})
        raise
    if as_json:
        echo_json(config_json(loaded, rehearsal))
        return
    echo_warnings(rehearsal.warnings)
    if not quiet:
        click.echo("\n".join(config_lines(loaded, rehearsal.poses)))


def _checked(path: Path) -> "tuple[Config, Rehearsal]":
    """The configuration, if it and its logs are right, and doubts about them."""
    from pipeline.config.load import config_from
    from pipeline.config.yaml_text import read_source
    from pipeline.errors import MissingFiles
    from pipeline.plan.so_far import require_planned
    from pipeline.session_folder import require_place
    from pipeline.stages.rehearsal import rehearse

    source = read_source(path)
    try:
        loaded = config_from(source)
    except MissingFiles:  # perhaps nothing is recorded yet: then only the plan can be wrong
        require_planned(config_from(source, files_may_be_missing=True))
        raise
    require_planned(loaded)
    require_place(loaded, loaded.output_folder)
    return loaded, rehearse(loaded)
