"""``pipeline check CONFIG``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
def command(config: Path) -> None:
    """Validate CONFIG and find its files; every mistake is listed with its line.

    Nothing is measured and nothing is written.
    """
    from pipeline.config.load import load_config
    from pipeline.console.triad_text import summary_lines
    from pipeline.stages.user_effects import check_user_effects

    loaded = load_config(config)
    if loaded.effects:
        check_user_effects(loaded)
    for line in summary_lines(loaded):
        click.echo(line)
