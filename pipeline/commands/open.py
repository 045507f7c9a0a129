"""``pipeline open CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument, PathArgument
from pipeline.commands.interaction.output import python_option


@click.command(epilog=examples(
    "pipeline open config.yaml",
    "pipeline open config.yaml --output results",
))
@click.argument("config", type=ConfigArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@python_option
def command(config: Path, output: Path | None, allow_python: bool) -> None:
    """Run CONFIG and open its report in the browser.

    There you tick effects and leave out poses, see the model refitted at once and the error fall,
    and copy the command that changes CONFIG.
    """
    from pipeline.commands.run import command as run
    from pipeline.config.load import load_config
    from pipeline.results.names import REPORT_NAME

    click.get_current_context().invoke(
        run, config=config, output=output, allow_python=allow_python)
    report = (output or load_config(config).output_folder).absolute() / REPORT_NAME
    if click.launch(str(report), wait=True) != 0:
        click.secho(f"no program of this system opens {report}. Open this file in a browser.",
                    fg="yellow", err=True)
