"""``pipeline record CONFIG``."""

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import ConfigArgument
from pipeline.commands.interaction.output import quiet_option, say_address
from pipeline.text.names import command as proposed

if TYPE_CHECKING:
    from pipeline.commands.interaction.recording_display import LivePanel, PlainLines
    from pipeline.config.load import Config
    from pipeline.plan.so_far import Outlook
    from pipeline.record.session import RecordingDisplay
    from vision.camera import Watch

FASTEST_BAUD = 100_000_000  #: bits per second, of a serial line over USB
REHEARSAL = "pipeline-rehearsal"  #: folder that `--demo` writes by default


@click.command(epilog=examples(
    "pipeline record config.yaml",
    "pipeline record config.yaml --port /dev/ttyUSB0 --camera 0",
    "pipeline record --demo --page",
    "pipeline record --ports",
))
@click.argument("config", required=False, type=ConfigArgument())
@click.option("--port", help="Serial port; default: record.port of CONFIG.")
@click.option("--baud", type=click.IntRange(min=1, max=FASTEST_BAUD),
              help="Baud rate; default: record.baud of CONFIG.")
@click.option("--anyway", is_flag=True,
              help="Record poses that will not determine the model.")
@click.option("--camera", type=click.IntRange(min=0),
              help="Film the poses on the turning plate with this camera (0 is the first).")
@click.option("--page", is_flag=True, help="Show the panel in the browser too.")
@click.option("--demo", is_flag=True,
              help=f"Rehearse with a simulated sensor in the folder {REHEARSAL}; no CONFIG.")
@click.option("--ports", is_flag=True,
              help="List the serial ports and why one cannot be opened; no CONFIG.")
@quiet_option("the instructions and the poses")
def command(
    config: Path | None, port: str | None, baud: int | None, anyway: bool,
    camera: int | None, page: bool, demo: bool, ports: bool, quiet: bool,
) -> None:
    """Record the poses of CONFIG from a sensor, with instructions for each pose.

    The command draws the attitude to lay next and writes each pose as soon as it is complete. You
    can interrupt it at any time and continue with the same command. It stores every byte that it
    receives beside the poses. Poses that cannot determine the model of CONFIG are refused before
    the first is recorded.
    """
    if (config is not None) + demo + ports != 1:
        raise click.UsageError("name a configuration, or --demo, or --ports")
    if ports:
        _list_ports()
        return
    from pipeline.commands.interaction.recording_display import watcher
    from pipeline.plan.so_far import Outlook
    from pipeline.record.demo import SPEED, demo_config, demo_session
    from pipeline.record.start import open_session

    loaded = demo_config(Path(REHEARSAL)) if config is None else _recordable(config, anyway)
    path = loaded.source.path
    outlook = Outlook(path)
    with ExitStack() as shown:
        display, watch = shown.enter_context(_shown(watcher(quiet, outlook), outlook, page))
        if watch and config is None:
            shown.enter_context(_demo_camera(watch))
        try:
            if config is None:
                display.say(f"A rehearsal with a simulated sensor, {SPEED:g} times as fast as in "
                            f"life; its files go to {REHEARSAL}.")
                session = demo_session(loaded, display)
            else:
                session = open_session(loaded, display, port, baud, camera, watch)
            done = session.run()
        except KeyboardInterrupt:
            again = proposed("record", "--demo") if config is None else proposed("record", path)
            display.say(f"Stopped; recorded poses are kept. Continue with: {again}")
            raise
    for block in done:
        click.echo(f"{block.rate}: {block.recorded} of {block.wanted} poses")
    click.echo(f"next: {proposed('plan', path)}")
    click.echo(f"afterwards: {proposed('run', path)}")


@contextmanager
def _shown(
    panel: "LivePanel | PlainLines", outlook: "Outlook", page: bool
) -> Iterator["tuple[RecordingDisplay, Watch | None]"]:
    """The display of a recording, closed at its end; with ``page`` the browser shows it too.

    The page also takes the frames of a camera.
    """
    try:
        if not page:
            yield panel, None
            return
        from pipeline.served.serve import serving
        from pipeline.workbench.recording_page import RecordingPage
        from vision.live_plate import LivePlate

        with closing(LivePlate()) as plate:
            both = RecordingPage(panel, outlook, plate)
            with serving(both.routes, say_address):
                yield both, plate.watch
    finally:
        panel.close()


@contextmanager
def _demo_camera(watch: "Watch") -> Iterator[None]:
    """A clip of the example session, played as a camera would see it."""
    import time

    from pipeline.config.template import session_folder
    from vision.camera import Camera

    with closing(Camera(session_folder() / "video/33rpm.mp4", time.monotonic, watch)):
        yield


def _recordable(path: Path, anyway: bool) -> "Config":
    """The configuration, if the planned poses determine its model."""
    from calib.errors import Undetermined
    from pipeline.config.load import load_config
    from pipeline.plan.so_far import require_planned

    loaded = load_config(path, files_may_be_missing=True)
    try:
        require_planned(loaded)
    except Undetermined as refused:
        if not anyway:
            raise Undetermined(f"{refused} To record these poses although they do not "
                               f"determine the model, add --anyway.") from refused
        click.echo(f"--anyway overrules: {refused}", err=True)
    return loaded


def _list_ports() -> None:
    """Print the serial ports, the probable device on each, and why one cannot be opened."""
    from pipeline.record.serial_port import find_ports, permission_advice

    found_ports = find_ports()
    if not found_ports:
        click.echo("No serial port was detected. Connect the sensor (a charging cable has no data "
                   "wires) and try again.")
        return
    for port in found_ports:
        description = "  ".join(part for part in (port.probably, port.description) if part)
        click.echo(f"{port.name}  {description}".rstrip())
        if not port.may_open:
            click.echo(f"  cannot be opened. {permission_advice(port.name)}")
    likely = next((port.name for port in found_ports if port.probably), found_ports[0].name)
    click.echo(f"next: set `port: {likely}` under `record:` in the configuration, then type "
               f"`pipeline record CONFIG`")
