"""Options that many commands have, results that a user names, and output."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands import paragraph
from pipeline.commands.interaction.arguments import CONFIG_NAME
from pipeline.console.terminal import ShownStream

if TYPE_CHECKING:
    from pipeline.results.read import Stored
    from pipeline.stages.triads import TriadResult


Decorated = Callable[[Callable[..., Any]], Callable[..., Any]]


#: ``--allow-python``, without which a file that comes from elsewhere runs nothing.
python_option: Decorated = click.option(
    "--allow-python", is_flag=True,
    help="Run the Python files that are named for user-defined effects.")


def json_option(printed: str) -> Decorated:
    """``--json``; the command has a parameter ``as_json``."""
    return click.option("--json", "as_json", is_flag=True, help=f"Print {printed} as JSON.")


def quiet_option(printed: str) -> Decorated:
    """``--quiet``; warnings are printed all the same."""
    return click.option("--quiet", is_flag=True,
                        help=f"Print only {printed}, and warnings.")


def say(text: str, *, err: bool = False, **face: str | bool) -> None:
    """Print a line, on a terminal in one of the commands' own styles.

    Parameters
    ----------
    text : str
    err : bool
        On standard error.
    face : str or bool
        As ``click.style`` takes it: ``fg="yellow"``, ``bold=True``.
    """
    stream = sys.stderr if err else sys.stdout
    context = click.get_current_context(silent=True)
    in_colour = stream.isatty() and (context is None or context.color is not False)
    if in_colour and isinstance(stream, ShownStream):
        before, after = click.style("\n", **face).split("\n")  # type: ignore[arg-type]
        stream.write_between(before, text, f"{after}\n")
    else:
        click.echo(text, err=err)


def echo_warnings(texts: Iterable[str], kind: str = "warning") -> None:
    """Print each of ``texts`` on standard error, after its kind."""
    for text in texts:
        say(f"{kind}: {text}", fg="yellow", err=True)


def echo_json(value: Any) -> None:
    """Print ``value`` as JSON."""
    echo_whole(json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def echo_whole(content: str | bytes) -> None:
    """Print output for programs: UTF-8 on any terminal, and no line cut at its width."""
    data = content.encode("utf-8", "surrogateescape") if isinstance(content, str) else content
    if isinstance(sys.stdout, ShownStream):
        sys.stdout.write_bytes(data)
    else:
        click.echo(data, nl=False)


def say_address(address: str) -> None:
    """Print the address of a page of this computer, and open a browser there."""
    click.echo(address)
    click.echo("Ctrl-C ends it.", err=True)
    if click.launch(address) != 0:
        click.secho("no browser could be started: open this address in one.", fg="yellow", err=True)


CONFIGURATION = (".yaml", ".yml")


def named_results(path: Path, allow_python: bool) -> "Stored":
    """The results in ``path``, or those of the configuration in ``path``."""
    from pipeline.config.load import load_config
    from pipeline.results.inputs import require_results_of
    from pipeline.results.names import RESULTS_NAME
    from pipeline.results.read import load_results
    from pipeline.text.names import command as proposed

    if (path / CONFIG_NAME).exists() and not (path / RESULTS_NAME).exists():
        path /= CONFIG_NAME  # a folder stands for the configuration in it
    config = load_config(path) if path.suffix in CONFIGURATION else None
    folder = path if config is None else config.output_folder
    if not folder.exists():
        raise click.UsageError(
            f"there is no {path}." if folder == path else
            f"{path} was not run yet: there is no {folder}. Type: {proposed('run', path)}")
    stored = load_results(folder, allow_python)
    if config is not None:
        require_results_of(stored, config)
    return stored


#: Colour by the standing of a diagnosis; the words say the same without it.
COLOURS: Mapping[str, str] = {"good": "green", "act": "red", "open": "yellow"}


def echo_verdict(result: "TriadResult") -> None:
    """Print the diagnosis of a triad in its colour, wrapped at the terminal's width."""
    from pipeline.console.run_text import verdict_line

    say(paragraph(verdict_line(result)), bold=True,
                fg=COLOURS[result.diagnosis.explanation.standing])
