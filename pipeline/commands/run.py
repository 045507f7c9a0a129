"""``pipeline run CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples(
    "pipeline run config.yaml",
    "pipeline run config.yaml --output results",
))
@click.argument("config", type=PathArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@click.option("--force", is_flag=True,
              help="Replace a results.json or report.html that `pipeline run` did not write.")
@click.option("--allow-python", is_flag=True,
              help="Run the Python files that CONFIG names for user-defined effects.")
def command(config: Path, output: Path | None, force: bool, allow_python: bool) -> None:
    """Run every stage of CONFIG and write results.json, report.html and a line of history.

    Later runs read the measured angles of the clips from the folder of the results.
    """
    from pipeline.commands.run_with_progress import run_watched, say_waiting
    from pipeline.console.certificate_text import certificate_lines
    from pipeline.console.rate_text import verdict_lines
    from pipeline.console.run_text import next_step, parameter_lines, verdict_line
    from pipeline.report.outputs import outputs_of
    from pipeline.results.read import REPORT_NAME
    from pipeline.session_folder import require_own_files, working_on, write_session
    from pipeline.stages.certificate import compare_with_certificate

    with working_on(config, output, say_waiting) as (session, folder):
        require_own_files(folder, force)
        outcome = run_watched(session, folder, allow_python)
        for result in outcome.triads:
            click.echo()
            for line in parameter_lines(result):
                click.echo(line)
            certificate = compare_with_certificate(session, result)
            if certificate is not None:
                for line in certificate_lines(certificate):
                    click.echo(line)
        click.echo()
        for result in outcome.triads:
            click.secho(paragraph(verdict_line(result)), bold=True)
        for rate in outcome.rates.values():
            for line in verdict_lines(rate):
                click.secho(paragraph(line), bold=True)
        write_session(folder, outputs_of(outcome, folder))
    click.echo(next_step(outcome, folder))
    click.echo(folder / REPORT_NAME)
