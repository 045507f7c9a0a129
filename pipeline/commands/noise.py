"""``pipeline noise LOG``."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import (
    RATE_HZ,
    PathArgument,
    gyroscope_options,
    log_in_si,
)
from pipeline.commands.interaction.output import echo_whole, json_option, quiet_option

if TYPE_CHECKING:
    from calib.noise.coefficients import AxisNoise


@click.command(epilog=examples(
    "pipeline noise still.csv --config config.yaml",
    "pipeline noise still.csv --output noise --json",
))
@click.argument("log", type=PathArgument())
@click.option("--config", type=PathArgument(dir_okay=False),
              help="Configuration whose `sensor` states the units; default: guess them as "
                   "`pipeline import` does.")
@click.option("--rate-hz", type=RATE_HZ,
              help="Sample rate of a log without a column of times.")
@gyroscope_options
@click.option("--output", type=PathArgument(file_okay=False),
              help="Folder for noise.json, noise.svg and noise.png; default: the results of "
                   "CONFIG, or the log's name with .noise, here.")
@click.option("--force", is_flag=True, help="Replace files that this program did not write.")
@json_option("the noise")
@quiet_option("the paths of the files")
def command(
    log: Path, config: Path | None, rate_hz: float | None, gyroscope_scale: str | float | None,
    output: Path | None, force: bool, as_json: bool, quiet: bool,
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
    from pipeline.config.load import load_config
    from pipeline.console.noise_text import noise_lines
    from pipeline.report.noise_figure import noise_figure
    from pipeline.results.noise import NOISE_NAME, noise_json
    from pipeline.results.written import write_output

    readings = log_in_si(log, config, gyroscope_scale, rate_hz)
    folder = (Path(f"{log.name.split('.')[0]}.noise") if config is None
              else load_config(config, files_may_be_missing=True).output_folder)
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
    files |= {f"noise.{form}": picture
              for form, picture in noise_figure(readings.label, triads).items()}
    for name, content in files.items():
        write_output(folder, folder / name, content, force=force, inputs=(log,))
    if as_json:
        echo_whole(text)
        return
    if not quiet:
        click.echo("\n".join(noise_lines(readings.label, 1 / step_s, length_s, triads)))
        click.echo()
    for name in files:
        click.echo(folder / name)
