"""``pipeline remove CONFIG TARGET``."""

from pathlib import Path

import click


@click.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.argument("target")
@click.option("--allow-python", is_flag=True,
              help="Let Python files that CONFIG names for its own effects run.")
def command(config: Path, target: str, allow_python: bool) -> None:
    """Take an effect out of CONFIG (comments kept), rerun, and show before → after."""
    from pipeline.commands.model_change import change_and_show

    change_and_show(config, target, allow_python, remove=True)
