"""``pipeline run CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples, paragraph


@click.command(epilog=examples(
    "pipeline run config.yaml",
    "pipeline run config.yaml --output results",
))
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@click.option("--allow-python", is_flag=True,
              help="Run the Python files that CONFIG names for user-defined effects.")
def command(config: Path, output: Path | None, allow_python: bool) -> None:
    """Run every stage of CONFIG and write results.json, report.html and a line of history.

    Later runs read the measured angles of the clips from the folder of the results.
    """
    from pipeline.commands.run_with_progress import run_watched
    from pipeline.config.load import load_config
    from pipeline.console.certificate_text import certificate_lines
    from pipeline.console.run_text import next_step, parameter_lines, verdict_line
    from pipeline.report.page import write_outputs
    from pipeline.stages.certificate import compare_with_certificate

    loaded = load_config(config)
    folder = output or loaded.output_folder
    outcome = run_watched(loaded, folder, allow_python)
    for result in outcome.triads:
        click.echo()
        for line in parameter_lines(result):
            click.echo(line)
        certificate = compare_with_certificate(loaded, result)
        if certificate is not None:
            for line in certificate_lines(certificate):
                click.echo(line)
    click.echo()
    for result in outcome.triads:
        click.secho(paragraph(verdict_line(result)), bold=True)
    report = write_outputs(outcome, folder)
    click.echo(next_step(outcome, folder))
    click.echo(report)
