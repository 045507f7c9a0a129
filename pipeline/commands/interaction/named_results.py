"""Results that a user names by a configuration, a folder or the file itself."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from pipeline.results.read import Stored

CONFIGURATION = (".yaml", ".yml")


def named_results(path: Path, allow_python: bool) -> "Stored":
    """The results in ``path``, or those of the configuration that it is."""
    from pipeline.config.load import load_config
    from pipeline.results.read import load_results
    from pipeline.text.commands import command as proposed

    folder = load_config(path).output_folder if path.suffix in CONFIGURATION else path
    if not folder.exists():
        raise click.UsageError(
            f"there is no {path}." if folder == path else
            f"{path} was not run yet: there is no {folder}. Type: {proposed('run', path)}")
    return load_results(folder, allow_python)
