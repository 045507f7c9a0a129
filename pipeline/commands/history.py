"""``pipeline history CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.arguments import PathArgument


@click.command(epilog=examples(
    "pipeline history config.yaml",
    "pipeline history config.yaml --json",
))
@click.argument("config", type=PathArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder of the results, if `pipeline run` had this option.")
@click.option("--json", "as_json", is_flag=True, help="Print the runs as JSON.")
def command(config: Path, output: Path | None, as_json: bool) -> None:
    """List all runs of CONFIG with model, errors and verdict. Equal runs are listed once."""
    import json
    from dataclasses import asdict

    from pipeline.config.load import load_config
    from pipeline.results.history import history_lines, read_history

    folder = output or load_config(config).output_folder
    runs = read_history(folder)
    if as_json:
        click.echo(json.dumps([asdict(run) for run in runs], indent=1, ensure_ascii=False))
        return
    for line in history_lines(runs) or (
        f"{folder} contains no run yet. Type: pipeline run {config}",
    ):
        click.echo(line)
