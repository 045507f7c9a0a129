"""``pipeline open [CONFIG|FOLDER]``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.output import named_results, python_option, say_address

if TYPE_CHECKING:
    from pipeline.workbench.application import Workbench
    from pipeline.workbench.held_out import HeldOut


@click.command(epilog=examples(
    "pipeline open config.yaml",
    "pipeline open sessions",
    "pipeline open monday.yaml --held-out tuesday.yaml",
))
@click.argument("config", metavar="[CONFIG|FOLDER]", type=PathArgument(), default=".")
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@click.option("--held-out", type=PathArgument(), metavar="SESSION",
              help="Another session of the sensor that was run: its poses are predicted only.")
@python_option
def command(
    config: Path, output: Path | None, held_out: Path | None, allow_python: bool
) -> None:
    """Open the workbench of CONFIG in the browser, until Ctrl-C.

    The session is run first, unless its results are those of its files as they are. There you tick
    effects and leave out poses, see the exact refit and the error fall, go back to any model that
    you tried, and write the one that you want into CONFIG. The address answers this computer alone;
    a run in a terminal updates the page. Of a FOLDER, by default this one, the page lists the
    sessions; logs and clips that you drop there become a new one.
    """
    from pipeline.commands.run import command as run
    from pipeline.served.serve import serve
    from pipeline.workbench.application import routes_of
    from pipeline.workbench.folder_page import FolderPage
    from pipeline.workbench.held_out import HeldOut

    beside = None if held_out is None else HeldOut.of(named_results(held_out, allow_python))
    if config.is_dir():
        if output is not None:
            raise click.UsageError("--output is for one session; name its configuration.")
        serve(FolderPage(config, lambda path: _run(path, allow_python, beside)).routes, say_address)
        return
    if _is_run(config, output, allow_python):
        click.echo(f"{config}: was run, and no file has changed since.")
    else:
        click.get_current_context().invoke(
            run, config=config, output=output, allow_python=allow_python)
    serve(routes_of(_workbench(config, output, allow_python, beside)), say_address)


def _workbench(
    config: Path, output: Path | None, allow_python: bool, held_out: "HeldOut | None"
) -> "Workbench":
    from pipeline.commands.interaction.run_with_progress import run_shown
    from pipeline.config.load import load_config
    from pipeline.stages.context import CACHE_NAME
    from pipeline.workbench.application import Workbench

    folder = (output or load_config(config).output_folder).absolute()
    return Workbench(config, folder, output, folder / CACHE_NAME, allow_python,
                     lambda changed, into: run_shown(changed, into, allow_python, bars=False),
                     held_out)


def _is_run(path: Path, output: Path | None, allow_python: bool) -> bool:
    """Whether a run would reproduce the present results; refused Python is left to it."""
    from pipeline.session_folder import working_on
    from pipeline.workbench.session_files import SessionFiles

    with working_on(path, output, replaces=None) as (config, folder):
        may_run = allow_python or not any(one.python for one in config.effects.values())
        return may_run and SessionFiles(path, folder).is_run()


def _run(path: Path, allow_python: bool, held_out: "HeldOut | None") -> "Workbench":
    """A session of a folder, which is run if its results are not those of the present files."""
    workbench = _workbench(path, None, allow_python, held_out)
    if not _is_run(path, None, allow_python):
        workbench.run_again()
    return workbench
