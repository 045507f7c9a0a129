"""``pipeline history CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument, PathArgument
from pipeline.commands.interaction.output import echo_json, json_option, quiet_option


@click.command(epilog=examples(
    "pipeline history config.yaml",
    "pipeline history config.yaml --json | jq '.[-1].gyroscope.verdict'",
))
@click.argument("config", type=ConfigArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder of the results, if `pipeline run` had this option.")
@json_option("the runs")
@quiet_option("the latest run of each triad")
def command(config: Path, output: Path | None, as_json: bool, quiet: bool) -> None:
    """List all runs of CONFIG with model, errors and verdict. Equal runs are listed once."""
    from pipeline.config.load import load_config
    from pipeline.results.history import read_history, run_history_lines
    from pipeline.text.names import command as proposed

    folder = output or load_config(config).output_folder
    runs = read_history(folder)
    if as_json:
        echo_json([run.as_json() for run in runs])
        return
    for line in run_history_lines(runs[-1:] if quiet else runs) or (
        f"{folder} contains no run yet. Type: {proposed('run', config)}",
    ):
        click.echo(line)
