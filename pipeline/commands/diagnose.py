"""``pipeline diagnose CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--allow-python", is_flag=True,
              help="Let Python files that CONFIG names for its own effects run.")
def command(config: Path, allow_python: bool) -> None:
    """Say what the model in CONFIG misses, how sure that is, and what to type next.

    Every stage is run; results and history are left as they are.
    """
    from pipeline.commands.run_with_progress import run_watched, say_waiting
    from pipeline.console.run_text import comparison_lines, next_step, ranking_lines, verdict_line
    from pipeline.session_folder import working_on

    with working_on(config, on_wait=say_waiting) as (session, folder):
        outcome = run_watched(session, folder, allow_python)
    for result in outcome.triads:
        click.echo()
        click.secho(verdict_line(result), bold=True)
        for line in [*comparison_lines(result), *ranking_lines(result)]:
            click.echo(line)
    click.echo()
    click.echo(next_step(outcome, folder, look="pipeline effects"))
