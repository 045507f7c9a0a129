"""``pipeline open CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import PathArgument
from pipeline.commands.interaction.named_results import named_results
from pipeline.commands.interaction.output import python_option


@click.command(epilog=examples(
    "pipeline open config.yaml",
    "pipeline open monday.yaml --held-out tuesday.yaml",
))
@click.argument("config", type=PathArgument())
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for the results; default: that of CONFIG.")
@click.option("--held-out", type=PathArgument(), metavar="SESSION",
              help="Another session of the sensor that was run: its poses are predicted only.")
@python_option
def command(
    config: Path, output: Path | None, held_out: Path | None, allow_python: bool
) -> None:
    """Run CONFIG and open its workbench in the browser, until Ctrl-C.

    There you tick effects and leave out poses, see the exact refit and the error fall, go back to
    any model that you tried, and write the one that you want into CONFIG. The address answers this
    computer alone; a run in a terminal updates the page.
    """
    from pipeline.commands.interaction.run_with_progress import run_shown
    from pipeline.commands.run import command as run
    from pipeline.config.load import load_config
    from pipeline.stages.context import CACHE_NAME
    from pipeline.workbench.application import Workbench
    from pipeline.workbench.held_out import HeldOut
    from pipeline.workbench.serve import serve

    beside = None if held_out is None else HeldOut.of(named_results(held_out, allow_python))
    click.get_current_context().invoke(
        run, config=config, output=output, allow_python=allow_python)
    folder = (output or load_config(config).output_folder).absolute()

    def opened(address: str) -> None:
        click.echo(address)
        click.echo("Ctrl-C ends the workbench.", err=True)
        if click.launch(address) != 0:
            click.secho("no browser could be started: open this address in one.", fg="yellow",
                        err=True)

    serve(Workbench(
        config, folder, output, folder / CACHE_NAME, allow_python,
        lambda changed, into: run_shown(changed, into, allow_python, bars=False), beside), opened)
