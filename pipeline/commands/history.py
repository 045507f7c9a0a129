"""``pipeline history CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path, file_okay=False),
              help="Folder of the results, where `pipeline run` was given one.")
def command(config: Path, output: Path | None) -> None:
    """Show every run of CONFIG so far: model, errors, verdict. Equal runs are shown once."""
    from pipeline.config.load import load_config
    from pipeline.results.history import history_lines, read_history

    folder = output or load_config(config).output_folder
    for line in history_lines(read_history(folder)) or (
        f"No run is in {folder} yet. Type: pipeline run {config}",
    ):
        click.echo(line)
