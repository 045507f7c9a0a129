"""``pipeline rate VIDEO...``, or ``pipeline rate --camera N``."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from pipeline.commands import examples
from pipeline.commands.interaction.arguments import (
    LONGEST_S,
    Finite,
    PathArgument,
    gyroscope_options,
    log_in_si,
)
from pipeline.commands.interaction.output import echo_json, echo_warnings, json_option, quiet_option
from pipeline.commands.interaction.rate_outputs import RateOutputs, measured_flutter, show_rates
from pipeline.config.units import FASTEST_RPM

if TYPE_CHECKING:
    from pipeline.stages.rate import SettingRate
    from vision.phase_track import PhaseTrack
    from vision.rate.timebase import Timebase

FILMED_S = 60.0  #: the clip that the guide asks for
SLOWEST_FPS, FASTEST_FPS = 0.01, 1e5  #: from time lapse to high speed


@click.command(epilog=examples(
    "pipeline rate video/17rpm.mp4 --nominal-rpm 16.667",
    "pipeline rate --camera 0 --seconds 30",
    "pipeline rate clips/*.mp4 --json",
    "pipeline rate video/17rpm.mp4 --from 4 --to 52 --overlay seen.mp4",
    "pipeline rate video/33rpm.mp4 --flutter --gyro platter.csv --page platter.html",
))
@click.argument("videos", metavar="[VIDEO...]", nargs=-1, type=PathArgument())
@click.option("--camera", type=click.IntRange(min=0), metavar="N",
              help="Film the plate with this camera (0 is the first) and measure the clip.")
@click.option("--seconds", type=Finite(min=1, max=LONGEST_S), default=FILMED_S, show_default=True,
              help="Duration of the clip that --camera films.")
@click.option("--keep", type=PathArgument(dir_okay=False), metavar="FILE.mkv",
              help="Keep the clip that --camera films; default: delete it.")
@click.option("--fps", type=Finite(min=SLOWEST_FPS, max=FASTEST_FPS),
              help="True frame rate, if the time stamps of the file are wrong.")
@click.option("--clock", metavar="NAME",
              help="Camera that filmed the clips, if `pipeline clock` has measured its clock.")
@click.option("--nominal-rpm", type=Finite(min=0, min_open=True, max=FASTEST_RPM),
              help="Expected rate: a check, and the selection if several rates fit.")
@click.option("--from", "from_s", type=Finite(min=0, max=LONGEST_S), metavar="SECONDS",
              help="Measure the clip from this time on; default: the part that turns steadily.")
@click.option("--to", "to_s", type=Finite(min=0, max=LONGEST_S), metavar="SECONDS",
              help="Measure the clip up to this time.")
@click.option("--rim", type=(Finite(), Finite(), Finite(min=1)), metavar="X Y RADIUS",
              help="Centre and radius of the plate's rim in pixels, if it is not detected.")
@click.option("--tilted-rim", type=(Finite(), Finite(), Finite(min=1), Finite(min=1), Finite()),
              metavar="X Y MAJOR MINOR DEGREES",
              help="The rim as an ellipse, if it is seen from the side: semi-axes in pixels, and "
                   "the direction of the major one, from the right towards downwards.")
@click.option("--overlay", type=PathArgument(dir_okay=False), metavar="OUT.mp4",
              help="Write the clip with rim, mark, angle and rate drawn on it.")
@click.option("--flutter", is_flag=True,
              help="Print wow and flutter of the platter, unweighted and AES6-weighted.")
@click.option("--gyro", type=PathArgument(dir_okay=False), metavar="LOG",
              help="With --flutter: log of a gyroscope on the turning platter; no clip is needed.")
@click.option("--config", type=PathArgument(dir_okay=False),
              help="Configuration whose `sensor` states the units of --gyro; default: guess them.")
@gyroscope_options
@click.option("--page", type=PathArgument(dir_okay=False), metavar="OUT.html",
              help="With --flutter: write a page with speed over the angle, spectrum, spectrogram.")
@click.option("--csv", type=PathArgument(dir_okay=False), metavar="OUT.csv",
              help="Write the angle of every frame.")
@click.option("--force", is_flag=True, help="Replace the files of --overlay, --page and --csv.")
@json_option("the section `rate` of results.json, by the names of the clips,")
@quiet_option("the rates")
def command(
    videos: tuple[Path, ...],
    camera: int | None,
    seconds: float,
    keep: Path | None,
    fps: float | None,
    clock: str | None,
    nominal_rpm: float | None,
    from_s: float | None,
    to_s: float | None,
    rim: tuple[float, float, float] | None,
    tilted_rim: tuple[float, float, float, float, float] | None,
    overlay: Path | None,
    flutter: bool,
    gyro: Path | None,
    config: Path | None,
    gyroscope_scale: str | float | None,
    page: Path | None,
    csv: Path | None,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Measure the rate of the plate in each VIDEO, or in a clip that a camera films now.

    The command writes no file except those of --keep, --overlay, --page and --csv. If the rate of
    the plate is not constant, it prints the rate against time instead of one value.
    """
    shown: Literal["text", "quiet", "json"] = "json" if as_json else "quiet" if quiet else "text"
    if (gyro or page) and not flutter:
        raise click.UsageError("--gyro and --page belong to --flutter.")
    if gyro is None and (config or gyroscope_scale) is not None:
        raise click.UsageError("--config states the units of --gyro LOG, as --gyroscope-range and "
                               "--gyroscope-unit do.")
    outputs = RateOutputs(overlay, csv, page)
    outputs.require_free(videos, force)
    of_log_alone = gyro is not None and camera is None and not videos
    if of_log_alone and (overlay or csv):
        raise click.UsageError("--overlay and --csv need a clip.")
    if (camera is None) == (not videos) and not of_log_alone:
        raise click.UsageError("type one or more clips, or a camera (--camera 0), but not both.")
    if keep is not None and (camera is None or keep.suffix != ".mkv"):
        raise click.UsageError("--keep FILE.mkv needs --camera: it keeps the clip of the camera.")
    if from_s is not None and to_s is not None and to_s <= from_s:
        raise click.UsageError(f"--to {to_s:g} is not after --from {from_s:g}.")
    if clock is not None and fps is not None:
        raise click.UsageError("--clock and --fps both state the clock; give one of them.")
    if rim is not None and tilted_rim is not None:
        raise click.UsageError("--rim and --tilted-rim both state the rim; give one of them.")
    ellipse = tilted_rim or (None if rim is None else (*rim, rim[2], 0.0))
    log = None if gyro is None else log_in_si(gyro, config, gyroscope_scale)
    rates: list[SettingRate] = []
    if not of_log_alone:
        with _filmed(camera, seconds, keep) as clip:
            clips = videos if clip is None else (clip,)
            rates = _measure(clips, _clock(clips, fps, clock), nominal_rpm, (from_s, to_s),
                             ellipse, shown, outputs)
    show_rates(rates, measured_flutter(rates, log, outputs) if flutter else [], outputs, shown)


@contextmanager
def _filmed(camera: int | None, seconds: float, keep: Path | None) -> Iterator[Path | None]:
    """The clip of the camera, deleted at the end unless it should be kept; None without one."""
    if camera is None:
        yield None
        return
    from pipeline.commands.interaction.progress import Progress
    from pipeline.stages.live_clip import film_clip

    with tempfile.TemporaryDirectory(prefix="pipeline-") as folder:
        clip = keep or Path(folder) / f"camera_{camera}.mkv"
        with Progress() as progress:
            film_clip(camera, seconds, clip, progress)
        yield clip


def _clock(videos: tuple[Path, ...], fps: float | None, name: str | None) -> "Timebase":
    """The clock of the clips: their own stamps, a frame rate, or that of a known camera."""
    from vision.rate.timebase import CLOCK_PPM, Timebase

    if name is None:
        source: Literal["container", "constant"] = "container" if fps is None else "constant"
        return Timebase(source=source, fps=fps, ppm=CLOCK_PPM[source])
    from pipeline.cameras import cameras_file, known_cameras
    from pipeline.stages.rate import camera_timebase

    known = known_cameras()
    if name not in known:
        raise click.UsageError(
            f"--clock {name}: {cameras_file()} has {', '.join(known) or 'no camera'}. "
            f"Measure it (pipeline clock --camera {name}).")
    return camera_timebase(known[name], videos)


def _measure(
    videos: tuple[Path, ...],
    clock: "Timebase",
    nominal_rpm: float | None,
    part: tuple[float | None, float | None],
    rim: tuple[float, float, float, float, float] | None,
    shown: Literal["text", "quiet", "json"],
    outputs: RateOutputs,
) -> "list[SettingRate]":
    from pipeline.commands.interaction.progress import Progress
    from pipeline.console.rate_text import rate_history_lines
    from pipeline.files import write_whole
    from pipeline.stages.context import RunContext
    from pipeline.stages.rate import ClipToFollow, draw_overlay, follow_clips, measure_setting
    from vision.errors import RateRefused
    from vision.geometry import PlateOverride
    from vision.rate.steady_part import ClipPart

    stems = [video.stem for video in videos]
    if len(set(stems)) < len(stems):
        twice = next(stem for i, stem in enumerate(stems) if stem in stems[:i])
        raise click.UsageError(
            f"two clips have the name '{twice}', which is the key of the results. Rename one, or "
            f"measure them in two commands."
        )
    plate = None if rim is None else PlateOverride(rim[:2], *rim[2:])
    clips = [ClipToFollow(video, plate, part[0] or 0.0) for video in videos]
    tracks: list[PhaseTrack] = []
    rates: list[SettingRate] = []
    refused: RateRefused | None = None
    try:
        with Progress(shown != "quiet") as progress:
            tracks = follow_clips(clips, RunContext(None, progress))
        for stem, track in zip(stems, tracks, strict=True):
            rates.append(measure_setting(stem, [track], clock, nominal_rpm, part=ClipPart(*part)))
    except RateRefused as error:
        refused = error
    if tracks and outputs.overlay is not None:
        with Progress(shown != "quiet") as progress:
            draw_overlay(videos[0], tracks[0], next(iter(rates), None), outputs.overlay, progress)
    clip = rates[0].clips[0] if rates else None
    history = refused.history if refused else clip.history if clip else None
    if history is not None and outputs.csv is not None:
        from pipeline.results.rate import angles_csv

        write_whole(outputs.csv, angles_csv(history, clip))
    if refused is not None:
        stem = next((video.stem for video in videos if str(refused).startswith(f"{video.name}:")),
                    stems[0])
        if shown == "json":
            from pipeline.results.rate import refusal_json

            echo_json({stem: refusal_json(refused)})
        elif history is not None:
            click.echo("\n".join(rate_history_lines(stem, history)))
        raise refused
    for rate in rates:
        echo_warnings(rate.warnings)
    return rates
