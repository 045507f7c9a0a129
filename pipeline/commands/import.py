"""``pipeline import FILE...``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import HEIGHT_M, LATITUDE_DEG, POSITIVE, PathArgument
from pipeline.commands.interaction.output import echo_json, echo_warnings, json_option, quiet_option

if TYPE_CHECKING:
    from pipeline.guess.checked import CheckedConfig


@click.command(epilog=examples(
    "pipeline import log.csv",
    "pipeline import phone.zip --latitude 59.9 --height 20",
    "pipeline import pose_*.csv --output session.yaml",
    "pipeline import accelerometer.txt gyroscope.txt --rate-hz 100",
    "pipeline import flight.ulg --json",
))
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=PathArgument())
@click.option("--output", type=PathArgument(dir_okay=False), metavar="CONFIG",
              help="Configuration to write; default: the first file's name with .yaml, here.")
@click.option("--force", is_flag=True, help="Replace a configuration that exists.")
@click.option("--rate-hz", type=POSITIVE,
              help="Sample rate of logs without a column of times.")
@click.option("--latitude", type=LATITUDE_DEG, help="Latitude of the site in degrees.")
@click.option("--height", type=HEIGHT_M, default=0.0,
              help="Height of the site in metres; with --latitude.")
@json_option("the guess")
@quiet_option("the path of the configuration")
def command(
    files: tuple[Path, ...], output: Path | None, force: bool, rate_hz: float | None,
    latitude: float | None, height: float, as_json: bool, quiet: bool,
) -> None:
    """Guess columns, units and clock of logs of any tool, and write a configuration that runs.

    Reads text tables in any dialect, zip archives of phyphox and Sensor Logger, MATLAB, NumPy and
    JSON files, and with extra packages HDF5, Parquet, ROS bags, MCAP, PX4 and ArduPilot logs. The
    command shows its guesses with the first rows, states what is uncertain, runs the configuration,
    and then writes it. It changes no log and never replaces a file without --force.
    """
    from pipeline.commands.interaction.run_with_progress import run_unwatched
    from pipeline.config.template import site_text
    from pipeline.console.import_text import guess_json, guess_lines
    from pipeline.errors import UnwritableOutput
    from pipeline.files import write_whole
    from pipeline.guess.checked import checked_config
    from pipeline.guess.config_text import Choices
    from pipeline.guess.files import guess_files

    path = output or Path(f"{files[0].name.split('.')[0] or 'session'}.yaml")
    if path.exists() and not force:
        raise UnwritableOutput(f"{path}: exists and is left as it is. Choose another name with "
                               "--output, or add --force to replace it.")
    guess, passed_over = guess_files(files, rate_hz)
    if any(path.exists() and path.samefile(each) for each in files if each.exists()):
        raise UnwritableOutput(f"{path}: is one of the logs. Choose another name with --output.")
    if not (as_json or quiet):
        for line in guess_lines(guess):
            click.echo(line)
    echo_warnings(passed_over)
    site = None if latitude is None else site_text(latitude, height)
    checked = checked_config(guess, path.absolute(), Choices(site), run_unwatched)
    if as_json:
        echo_json(guess_json(guess, checked))
    write_whole(path, checked.text)
    _say(path, checked)
    if quiet and not as_json:
        click.echo(path)
    elif not as_json:
        _show_run(path, checked)


def _say(path: Path, checked: "CheckedConfig") -> None:
    """What the check has changed, and whether the configuration runs."""
    from pipeline.errors import UnfinishedGuess
    from pipeline.text.commands import command as proposed

    echo_warnings(checked.changes)
    if checked.outcome is None:
        raise UnfinishedGuess(
            f"{path} was written, but it does not run yet: {checked.fault} Correct the file, then "
            f"type: {proposed('run', path)}")


def _show_run(path: Path, checked: "CheckedConfig") -> None:
    """The errors of the trial run, and the next command."""
    from pipeline.console.run_text import recordings_line, triad_line
    from pipeline.text.commands import command as proposed

    assert checked.outcome is not None
    click.echo(recordings_line(checked.outcome.recordings))
    for result in checked.outcome.triads:
        click.echo(triad_line(result))
    click.echo(f"{path} was written, and it runs.")
    click.echo(f"next: {proposed('run', path)}")
