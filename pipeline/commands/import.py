"""``pipeline import FILE...``."""

import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import (
    HEIGHT_M,
    LATITUDE_DEG,
    RATE_HZ,
    ConfigArgument,
    PathArgument,
    ask_latitude,
    gyroscope_options,
)
from pipeline.commands.interaction.output import echo_json, echo_warnings, json_option, quiet_option
from pipeline.commands.interaction.progress import Progress
from pipeline.text.names import command as proposed

if TYPE_CHECKING:
    from pipeline.guess.checked import CheckedConfig
    from pipeline.guess.plate import ScaleChoice

ONE_RECORDING = 2  #: files, as a phone writes them, one for each sensor


@click.command(epilog=examples(
    "pipeline import log.csv",
    "pipeline import rest/*.csv turn/*.csv clip.mp4 --latitude 59.9",
    "pipeline import phone.zip --latitude 59.9 --height 20",
    "pipeline import pose_*.csv --output session.yaml",
    "pipeline import accelerometer.txt gyroscope.txt --rate-hz 100",
    "pipeline import flight.ulg --json",
    "pipeline import again/*.csv --into config.yaml",
))
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=PathArgument())
@click.option("--output", type=PathArgument(dir_okay=False), metavar="CONFIG",
              help="Configuration to write; default: the log's name with .yaml for one or two "
                   "files, config.yaml for more, here.")
@click.option("--into", type=ConfigArgument(), metavar="CONFIG",
              help="Session that exists: the logs join its runs, and it is run with them.")
@click.option("--triad", "triads", type=click.Choice(["accelerometer", "gyroscope"]), multiple=True,
              help="Triad that the logs are for; with --into, by default every one they show.")
@click.option("--force", is_flag=True, help="Replace a configuration that exists.")
@click.option("--rate-hz", type=RATE_HZ,
              help="Sample rate of logs without a column of times.")
@gyroscope_options
@click.option("--latitude", type=LATITUDE_DEG, help="Latitude of the site in degrees.")
@click.option("--height", type=HEIGHT_M, default=0.0,
              help="Height of the site in metres; with --latitude.")
@json_option("the guess")
@quiet_option("the path of the configuration")
def command(
    files: tuple[Path, ...], output: Path | None, into: Path | None, triads: tuple[str, ...],
    force: bool, rate_hz: float | None, gyroscope_scale: str | float | None,
    latitude: float | None, height: float, as_json: bool, quiet: bool,
) -> None:
    """Guess columns, units and clock of logs of any tool, and write a configuration that runs.

    FILE... are all logs of an evening, at rest and on the turning plate, and the clips of the
    plate. The command asks at most two questions: the range or unit of the gyroscope, where nothing
    shows it, and the latitude; without a terminal, options answer them. It reads text tables in any
    dialect, zip archives of phyphox and Sensor Logger, MATLAB, NumPy and JSON files, and with extra
    packages HDF5, Parquet, ROS bags, MCAP, PX4 and ArduPilot logs. It shows its guesses with the
    first rows, states what is uncertain, runs the configuration, and then writes it. It changes no
    log and never replaces a file without --force.

    With --into, the logs are read as those of CONFIG: the command shows the attitude, the setting
    of the plate and the sd of each pose, adds them to its runs and prints the errors before and
    after. A new clip becomes a new setting. If anything is refused, CONFIG stays as it is.
    """
    if into is not None:
        _bring(files, into, triads, quiet, [output, force, rate_hz, gyroscope_scale, latitude,
                                            height, as_json])
        return
    if triads:
        raise click.UsageError("--triad is for logs of a session that exists; add --into CONFIG.")
    from pipeline.config.template import site_text
    from pipeline.console.import_text import guess_json, guess_lines
    from pipeline.errors import UnwritableOutput
    from pipeline.files import write_whole
    from pipeline.guess.checked import checked_config
    from pipeline.guess.config_text import Choices, open_scale_text
    from pipeline.guess.files import guess_files, is_clip, measured_clips, rates_of_clips
    from pipeline.guess.session import guess_session
    from pipeline.guess.units import per_deg_of
    from pipeline.stages.context import RunContext
    from pipeline.stages.run import run_stages

    path = output or _path_for(files)
    if path.exists() and not force:
        raise UnwritableOutput(f"{path}: exists and is left as it is. Choose another name with "
                               "--output, or add --force to replace it.")
    clips, logs = [file for file in files if is_clip(file)], [
        file for file in files if not is_clip(file)]
    if not logs:
        raise click.UsageError("only clips are named; name the logs of the sensor too, or type: "
                               f"{proposed('rate', *clips)}")
    tables, passed_over = guess_files(logs, rate_hz)
    if any(path.exists() and path.samefile(file) for file in files if file.exists()):
        raise UnwritableOutput(f"{path}: is one of the logs. Choose another name with --output.")
    with TemporaryDirectory() as cache, Progress(not (quiet or as_json)) as progress:
        context = RunContext(Path(cache), progress)
        rates = measured_clips(rates_of_clips(clips, context))
        guess = guess_session(tables, rates, per_deg_of(gyroscope_scale))
        asks = sys.stdin.isatty() and not (as_json or quiet)
        if not (as_json or quiet):
            click.echo("\n".join(guess_lines(guess)))
        echo_warnings(passed_over)
        if asks and guess.scales:
            guess = guess_session(tables, rates, _ask_scale(guess.scales))
        if guess.scales:
            echo_warnings([f"the gyroscope is left out: {open_scale_text(guess)}."])
        if asks and latitude is None:
            latitude = ask_latitude()
        site = None if latitude is None else site_text(latitude, height)
        with suppress(OSError):  # the names of logs lead up through it; the write says why it fails
            path.absolute().parent.mkdir(parents=True, exist_ok=True)
        checked = checked_config(guess, path.absolute(), Choices(site),
                                 lambda config: run_stages(config, context))
    if as_json:
        echo_json(guess_json(guess, checked))
    if checked.text:
        write_whole(path, checked.text)
    _say(path, checked)
    if quiet and not as_json:
        click.echo(path)
    elif not as_json:
        _show_run(path, checked)


def _bring(
    files: Sequence[Path], into: Path, triads: Sequence[str], quiet: bool, others: Sequence[object]
) -> None:
    """The logs into a session that exists, whose configuration states what the ``others`` would."""
    from pipeline.commands.interaction.further import bring_and_show
    from pipeline.commands.interaction.model_change import Manner

    if any(others):
        raise click.UsageError(f"--into goes with --triad and --quiet alone: {into} states the "
                               f"columns, clock, ranges and site of its logs.")
    bring_and_show(into, files, triads, Manner(allow_python=False, quiet=quiet))


def _path_for(files: Sequence[Path]) -> Path:
    """The configuration's name: the log's own for one recording, ``config.yaml`` for many, and for
    a log that has that name."""
    of_log = Path(f"{Path(files[0].name.removesuffix('.gz')).stem}.yaml")
    is_log = of_log.resolve() in [file.resolve() for file in files]
    return Path("config.yaml") if is_log or len(files) > ONE_RECORDING else of_log


def _ask_scale(choices: "Sequence[ScaleChoice]") -> float:
    """Units of the gyroscope per °/s, chosen among equally plausible ones."""
    for choice in choices:
        click.echo(choice.says, err=True)
    known = {choice.answer: choice.per_deg for choice in choices}
    typed: str = click.prompt(
        "Unit of the gyroscope" if choices[0].unit else "Range of the gyroscope in °/s",
        type=click.Choice(list(known)), err=True)
    return known[typed]


def _say(path: Path, checked: "CheckedConfig") -> None:
    """Print the changes and warnings of the check, and whether the configuration runs."""
    from pipeline.errors import UnfinishedGuess

    echo_warnings((*checked.changes, *(checked.outcome.warnings if checked.outcome else ())))
    if not checked.text:
        raise UnfinishedGuess(f"no configuration was written: {checked.fault} Then import all "
                              f"logs again.")
    if checked.outcome is None:
        raise UnfinishedGuess(
            f"{path} was written, but is no calibration yet: {checked.fault} After that, type: "
            f"{proposed('run', path)}")
    if checked.fault is not None:
        raise UnfinishedGuess(
            f"{path} was written and runs, but it cannot be right: {checked.fault} Correct the "
            f"file, then type: {proposed('run', path)}")


def _show_run(path: Path, checked: "CheckedConfig") -> None:
    """Print the errors of the trial run, its doubts, and the next command."""
    from calib.diagnosis.verdict.decision import Code
    from pipeline.console.run_text import recordings_line, triad_line, verdict_line

    assert checked.outcome is not None
    triads = checked.outcome.triads
    click.echo(recordings_line(checked.outcome.recordings))
    for result in triads:
        click.echo(triad_line(result))
    doubtful = [result for result in triads
                if result.diagnosis.verdict is not Code.NOTHING_MISSING]
    for result in doubtful:
        click.echo(verdict_line(result))
    for result in triads:
        if result not in doubtful and result.diagnosis.explanation.standing != "good":
            click.echo(f"{result.triad}: {result.diagnosis.explanation.short}.")
    site = checked.outcome.config.site
    if any("earth_rate" in result.diagnosis.group for result in doubtful):
        click.echo(
            "The Earth's rate is known once the latitude is: import again with --latitude."
            if site is None or site.latitude_deg is None else
            f"Is the latitude of {site.latitude_deg:g}° right, south of the equator negative, and "
            f"does the accelerometer read +g along the axis that points up?")
    names = " and the ".join(result.triad for result in doubtful)
    click.echo(f"{path} was written, and it runs." if not doubtful else
               f"{path} was written. It is complete and its logs can be read, but the calibration "
               f"is in doubt: the lines on the {names} above say what is missing, or why that "
               f"cannot be told.")
    click.echo(f"next: {proposed('run', path)}")
