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
    from pipeline.commands.run_with_progress import run_watched
    from pipeline.config.load import load_config
    from pipeline.console.run_text import comparison_lines, next_step, ranking_lines, verdict_line

    asked = load_config(config)
    outcome = run_watched(asked, asked.output_folder, allow_python)
    for result in outcome.triads:
        click.echo()
        click.secho(verdict_line(result), bold=True)
        for line in [*comparison_lines(result), *ranking_lines(result)]:
            click.echo(line)
    click.echo()
    click.echo(next_step(outcome, asked.output_folder, look="pipeline effects"))
