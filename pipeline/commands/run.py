"""``pipeline run CONFIG``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.interaction.arguments import ConfigArgument, PathArgument
from pipeline.commands.interaction.output import (
    echo_verdict,
    echo_whole,
    json_option,
    python_option,
    quiet_option,
)

if TYPE_CHECKING:
    from pipeline.stages.run import Outcome


@click.command(epilog=examples(
    "pipeline run config.yaml",
    "pipeline run config.yaml --output results",
    "pipeline run config.yaml --json | jq .gyroscope.diagnosis.verdict",
))
@click.argument("config", type=ConfigArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@click.option("--force", is_flag=True,
              help="Replace a results.json or report.html of another configuration, or that "
                   "`pipeline run` did not write.")
@python_option
@json_option("the results")
@quiet_option("the path of the report")
def command(
    config: Path, output: Path | None, force: bool, allow_python: bool, as_json: bool, quiet: bool
) -> None:
    """Run every stage of CONFIG and write results.json, report.html and a line of history.

    Later runs read the measured angles of the clips from the folder of the results.
    """
    from pipeline.commands.interaction.run_with_progress import run_shown, say_waiting
    from pipeline.console.next_step import next_lines
    from pipeline.report.page import outputs_of
    from pipeline.results.names import REPORT_NAME, RESULTS_NAME
    from pipeline.session_folder import working_on, write_session

    with working_on(config, output, say_waiting, replaces=force) as (session, folder):
        outcome = run_shown(session, folder, allow_python, lines=not (quiet or as_json),
                            bars=not quiet)
        if not (quiet or as_json):
            _show(outcome)
        outputs = outputs_of(outcome, folder)
        write_session(folder, outputs)
    if as_json:
        echo_whole(outputs[RESULTS_NAME])
        return
    if not quiet:
        click.echo("\n".join(next_lines(outcome, folder)))
    click.echo(folder / REPORT_NAME)


def _show(outcome: "Outcome") -> None:
    """Parameters and verdicts."""
    from pipeline.console.parameter_text import certificate_lines, parameter_lines
    from pipeline.console.rate_text import verdict_lines

    for result in outcome.triads:
        click.echo()
        click.echo("\n".join(parameter_lines(result)))
        for line in certificate_lines(result.certificate) if result.certificate else ():
            click.echo(line)
    click.echo()
    for result in outcome.triads:
        echo_verdict(result)
    for line in verdict_lines(outcome.rates.values()):
        click.secho(paragraph(line), bold=True)
