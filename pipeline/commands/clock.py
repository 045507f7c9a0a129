"""``pipeline clock --camera NAME``."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import LONGEST_S, Finite, PathArgument
from pipeline.commands.interaction.output import echo_json, json_option, quiet_option

if TYPE_CHECKING:
    from pipeline.clock.screen import DrawnHand

FILMED_S = 300.0  #: the time that the sd of the film needs to fall below that of the temperature
SHORTEST_S = 30.0  #: eight turns of the hand and the part left out of the film
TIME_SERVER = "pool.ntp.org"
NO_SERVER = "none"


@click.command(epilog=examples(
    "pipeline clock --camera c920",
    "pipeline clock --camera c920 --device 1 --seconds 600",
    "pipeline clock --show",
    "pipeline clock --camera phone --clip film.mp4",
    "pipeline clock",
))
@click.option("--camera", metavar="NAME",
              help="Measure the clock of this camera, and keep it under this name of your choice.")
@click.option("--device", type=click.IntRange(min=0), default=0, show_default=True, metavar="N",
              help="Number of the camera at this computer that films the screen.")
@click.option("--clip", type=PathArgument(dir_okay=False), metavar="FILE",
              help="A film of the drawn hand, of a camera that is not at this computer.")
@click.option("--show", is_flag=True, help="Only draw the hand, for such a camera.")
@click.option("--screen", type=PathArgument(dir_okay=False), metavar="FILE",
              help="With --clip: what --show wrote of the hand; default: of the latest.")
@click.option("--seconds", type=Finite(min=SHORTEST_S, max=LONGEST_S), default=FILMED_S,
              show_default=True, help="For how long the hand is drawn and filmed.")
@click.option("--keep", type=PathArgument(dir_okay=False), metavar="FILE.mkv",
              help="Keep the film that --device takes; default: delete it.")
@click.option("--ntp", default=TIME_SERVER, show_default=True, metavar="SERVER",
              help="Time server that is asked every 16 s; `none` asks none.")
@json_option("the clock")
@quiet_option("the clock and the path of its file")
def command(
    camera: str | None, device: int, clip: Path | None, show: bool, screen: Path | None,
    seconds: float, keep: Path | None, ntp: str, as_json: bool, quiet: bool,
) -> None:
    """Measure the clock of a camera against the clock of this computer.

    A hand that turns at a known rate is drawn in the browser, the camera films it, and the rate is
    measured like that of a plate. The error of the camera's clock is kept for you and used by
    `timebase: {camera: NAME}` in a configuration. Place the camera as it stands before the plate,
    let it warm up for a quarter of an hour, film the screen face on, and film with the same
    program and settings as the plate. Without options the command lists the clocks that are known.
    """
    from dataclasses import asdict
    from datetime import date

    from pipeline.cameras import cameras_file, keep_camera, known_cameras
    from pipeline.console.clock_text import clock_line, clock_parts, next_step

    _require_sense(camera, clip, show, screen, keep)
    if camera is None and not show:
        clocks = known_cameras()
        for known in clocks.values():
            click.echo(clock_line(known, date.today()))
        click.echo(cameras_file() if clocks else
                   "no clock is known. next: pipeline clock --camera NAME")
        return
    from pipeline.clock.measure import (
        camera_clock,
        film_of_screen,
        keep_screen,
        last_screen,
        read_screen,
        show_hand,
    )
    from pipeline.commands.interaction.progress import Progress

    server = None if ntp == NO_SERVER else ntp
    if camera is None:
        click.echo(keep_screen(show_hand(server, seconds, _tell)))
        return
    with tempfile.TemporaryDirectory(prefix="pipeline-") as folder:
        if clip is None:
            clip = keep or Path(folder) / f"{device}.mkv"
            hand = _filmed(device, seconds, clip, server)
            keep_screen(hand)
        else:
            hand = read_screen(screen or last_screen())
        with Progress(not quiet) as progress:
            film = film_of_screen(clip, hand, progress)
    clock = camera_clock(camera, film, hand, date.today())
    path = keep_camera(clock)
    if as_json:
        echo_json({**asdict(clock), "measured": clock.measured.isoformat(), "file": str(path)})
        return
    click.echo(clock_line(clock, clock.measured))
    if not quiet:
        click.echo("\n".join([*clock_parts(clock, film), next_step(clock)]))
    click.echo(path)


def _require_sense(
    camera: str | None, clip: Path | None, show: bool, screen: Path | None, keep: Path | None
) -> None:
    """Refuse options that contradict each other, and an empty name."""
    if camera is not None and not camera.strip():
        raise click.UsageError("--camera needs a name, such as c920 or phone.")
    if show and (camera or clip):
        raise click.UsageError("--show only draws the hand; measure the film of it afterwards "
                               "(--camera NAME --clip FILE).")
    if clip is not None and camera is None:
        raise click.UsageError("--clip needs --camera NAME, under which the clock is kept.")
    if screen is not None and clip is None:
        raise click.UsageError("--screen belongs to --clip: it describes the hand of that film.")
    if keep is not None and (clip is not None or camera is None or keep.suffix != ".mkv"):
        raise click.UsageError("--keep FILE.mkv keeps the film that --device takes.")


def _tell(line: str) -> None:
    click.echo(line, err=True)


def _filmed(device: int, seconds: float, clip: Path, server: str | None) -> "DrawnHand":
    """Draw the hand and film it meanwhile."""
    from pipeline.clock.measure import show_hand
    from pipeline.commands.interaction.progress import Progress
    from pipeline.stages.live_clip import film_clip

    with Progress() as progress:
        return show_hand(server, seconds, _tell,
                         lambda: film_clip(device, seconds, clip, progress))
