"""``pipeline diagnose CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples, paragraph
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples("pipeline diagnose config.yaml"))
@click.argument("config", type=PathArgument())
@click.option("--allow-python", is_flag=True,
              help="Run the Python files that CONFIG names for user-defined effects.")
def command(config: Path, allow_python: bool) -> None:
    """Print what the model in CONFIG misses, how certain that is, and the next command to type.

    The command runs every stage and does not change the results or the history.
    """
    from pipeline.commands.run_with_progress import run_watched, say_waiting
    from pipeline.console.rate_text import verdict_lines
    from pipeline.console.run_text import comparison_lines, next_step, ranking_lines, verdict_line
    from pipeline.session_folder import working_on

    with working_on(config, on_wait=say_waiting) as (session, folder):
        outcome = run_watched(session, folder, allow_python)
    for result in outcome.triads:
        click.echo()
        click.secho(paragraph(verdict_line(result)), bold=True)
        for line in [*comparison_lines(result), *ranking_lines(result)]:
            click.echo(line)
    for rate in outcome.rates.values():
        for line in verdict_lines(rate):
            click.echo()
            click.secho(paragraph(line), bold=True)
    click.echo()
    click.echo(next_step(outcome, folder, look="pipeline effects"))
