"""``pipeline noise LOG``."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import POSITIVE, PathArgument
from pipeline.commands.interaction.output import echo_whole, json_option, quiet_option

if TYPE_CHECKING:
    from calib.noise.coefficients import AxisNoise
    from calib.poses.imu_log import ImuLog


@click.command(epilog=examples(
    "pipeline noise still.csv --config config.yaml",
    "pipeline noise still.csv --output noise --json",
))
@click.argument("log", type=PathArgument())
@click.option("--config", type=PathArgument(dir_okay=False),
              help="Configuration whose `sensor` states the units; default: guess them as "
                   "`pipeline import` does.")
@click.option("--rate-hz", type=POSITIVE,
              help="Sample rate of a log without a column of times.")
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for noise.json, noise.svg and noise.png; default: the results of "
                   "CONFIG, or the log's name with .noise, here.")
@click.option("--force", is_flag=True, help="Replace files that this program did not write.")
@json_option("the noise")
@quiet_option("the paths of the files")
def command(
    log: Path, config: Path | None, rate_hz: float | None, output: Path | None, force: bool,
    as_json: bool, quiet: bool,
) -> None:
    """Determine noise density, bias instability and random walk from a long log at rest.

    The Allan deviation needs evenly spaced samples of a sensor that nobody touches: some minutes
    for the noise density, two hours or more for the others. Needs the extra `noise`:
    pip install 'turntable-imu-calibration[noise]'.
    """
    from pipeline.errors import UnreadableInput

    try:
        from calib.noise.coefficients import axis_noise
    except ImportError as error:
        raise UnreadableInput(
            f"{log}: an Allan deviation needs {error.name}, which is not installed. Type: pip "
            f"install 'turntable-imu-calibration[noise]'") from error
    from calib.noise.stillness import require_still, sample_step_s
    from calib.poses.imu_log import TRIADS
    from pipeline.console.noise_text import noise_lines
    from pipeline.report.noise_figure import noise_figure
    from pipeline.results.noise import NOISE_NAME, noise_json
    from pipeline.results.written import write_output

    readings, folder = _readings(log, config, rate_hz)
    step_s = sample_step_s(readings)
    triads: dict[str, list[AxisNoise]] = {}
    for triad in TRIADS:
        if readings.has(triad):
            values = getattr(readings, triad)
            require_still(readings, triad, values, step_s)
            triads[triad] = [axis_noise(values[:, axis], step_s) for axis in range(3)]
    length_s = step_s * len(readings.time_s)
    text = noise_json(readings.label, 1 / step_s, length_s, triads)
    folder = output or folder
    files: dict[str, str | bytes] = {NOISE_NAME: text}
    files |= {f"noise.{form}": noise_figure(readings.label, triads, form)
              for form in ("svg", "png")}
    for name, content in files.items():
        write_output(folder, folder / name, content, force=force, inputs=(log,))
    if as_json:
        echo_whole(text)
        return
    if not quiet:
        for line in noise_lines(readings.label, 1 / step_s, length_s, triads):
            click.echo(line)
        click.echo()
    for name in files:
        click.echo(folder / name)


def _readings(log: Path, config: Path | None, rate_hz: float | None) -> tuple["ImuLog", Path]:
    """The log in SI units, and the folder where its noise goes by default."""
    from dataclasses import replace

    from calib.poses.imu_log import TRIADS
    from pipeline.config.load import load_config
    from pipeline.config.sensor import sensor_specs
    from pipeline.errors import UnreadableInput
    from pipeline.guess.files import guess_files
    from pipeline.guess.session import guess_session
    from pipeline.logs.clock import StatedClock
    from pipeline.logs.read import read_log
    from pipeline.stages.stated_units import require_stated_units
    from pipeline.text.commands import command as proposed

    if config is None:
        tables, _ = guess_files([log], rate_hz)
        guess = guess_session(tables)
        for each in (guess.accelerometer, guess.gyroscope):
            if each is not None:
                click.echo(f"guessed: {', '.join(each.columns)} are in {each.unit}, because "
                           f"{each.because}; --config states it", err=True)
        readings = guess.tables[0].log()
        if readings is None:
            raise UnreadableInput(f"{log}: its readings or times are no log of samples. Type "
                                  f"`{proposed('import', log)}` to see what is there.")
        return readings, Path(f"{log.name.split('.')[0]}.noise")
    session = load_config(config, files_may_be_missing=True)
    require_stated_units(session, [log])
    raw = read_log(log, None, StatedClock(rate_hz))
    nominal: dict[str, Any] = {}
    for triad, spec in zip(TRIADS, sensor_specs(session.sensor), strict=True):
        if raw.has(triad) and spec is not None:
            nominal[triad] = spec.nominal(getattr(raw, triad))
        elif raw.has(triad):
            raise UnreadableInput(f"{config}: `sensor` does not state the {triad}, which {log} "
                                  f"holds. State it, or leave --config out to have it guessed.")
    return replace(raw, **nominal), session.output_folder
