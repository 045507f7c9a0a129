"""``pipeline record CONFIG``."""

from pathlib import Path

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import quiet_option

FASTEST_BAUD = 100_000_000  #: bits per second, of a serial line over USB


@click.command(epilog=examples(
    "pipeline record config.yaml",
    "pipeline record config.yaml --port /dev/ttyUSB0 --camera 0",
))
@click.argument("config", type=ConfigArgument())
@click.option("--port", help="Serial port; default: record.port of CONFIG.")
@click.option("--baud", type=click.IntRange(min=1, max=FASTEST_BAUD),
              help="Baud rate; default: record.baud of CONFIG.")
@click.option("--although-undetermined", is_flag=True,
              help="Record although these poses will not determine the model.")
@click.option("--camera", type=click.IntRange(min=0),
              help="Film the poses on the turning plate with this camera (0 is the first).")
@quiet_option("the instructions and the poses")
def command(
    config: Path, port: str | None, baud: int | None, although_undetermined: bool,
    camera: int | None, quiet: bool,
) -> None:
    """Record the poses of CONFIG from a sensor, with instructions for each pose.

    The command writes each pose as soon as it is complete. You can interrupt it at any time and
    continue with the same command. It stores every byte that it receives beside the poses. To try
    it without a sensor, see `pipeline playback --help`. Poses that cannot determine the model of
    CONFIG are refused before the first is recorded.
    """
    from calib.errors import Undetermined
    from pipeline.config.load import load_config
    from pipeline.plan.refusal import require_planned
    from pipeline.record.start import open_session
    from pipeline.text.commands import command as proposed

    loaded = load_config(config, files_may_be_missing=True)
    if not although_undetermined and loaded.record is not None:
        try:
            require_planned(loaded)
        except Undetermined as refused:
            raise Undetermined(f"{refused} To record these all the same, add "
                               f"--although-undetermined.") from refused
    from pipeline.commands.interaction.recording_display import watcher

    display = watcher(quiet)
    try:
        done = open_session(loaded, display, port=port, baud=baud, camera=camera).run()
    except KeyboardInterrupt:
        display.say(f"Stopped; recorded poses are kept. Continue with: "
                    f"{proposed('record', config)}")
        raise
    finally:
        display.close()
    for block in done:
        click.echo(f"{block.rate}: {block.recorded} of {block.wanted} poses")
    click.echo(f"next: {proposed('plan', config)}")
    click.echo(f"afterwards: {proposed('run', config)}")
