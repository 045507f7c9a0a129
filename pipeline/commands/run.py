"""``pipeline run CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Folder for the results, instead of the one in CONFIG.")
@click.option("--allow-python", is_flag=True,
              help="Let Python files that CONFIG names for its own effects run.")
def command(config: Path, output: Path | None, allow_python: bool) -> None:
    """Run every stage in CONFIG and write results.json, report.html and a line of history.

    Clips are followed once: later runs find their phase tracks in the results' folder.
    """
    from pipeline.commands.run_with_progress import run_watched
    from pipeline.config.load import load_config
    from pipeline.console.certificate_text import certificate_lines
    from pipeline.console.run_text import next_step, parameter_lines, verdict_line
    from pipeline.report.page import write_outputs
    from pipeline.stages.certificate import compare_with_certificate

    asked = load_config(config)
    folder = output or asked.output_folder
    outcome = run_watched(asked, folder, allow_python)
    for result in outcome.triads:
        click.echo()
        for line in parameter_lines(result):
            click.echo(line)
        certificate = compare_with_certificate(asked, result)
        if certificate is not None:
            for line in certificate_lines(certificate):
                click.echo(line)
    click.echo()
    for result in outcome.triads:
        click.secho(verdict_line(result), bold=True)
    report = write_outputs(outcome, folder)
    click.echo(next_step(outcome, folder))
    click.echo(report)
