"""``pipeline rate VIDEO...``, or ``pipeline rate --camera N``."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import click

from pipeline.commands import examples
from pipeline.commands.arguments import Finite, PathArgument

FILMED_S = 60.0
LONGEST_S = 86_400.0  #: a day
SLOWEST_FPS, FASTEST_FPS = 0.01, 1e5  #: from time lapse to high speed
FASTEST_RPM = 1e5


@click.command(epilog=examples(
    "pipeline rate video/17rpm.mp4 --nominal-rpm 16.667",
    "pipeline rate --camera 0 --seconds 30",
    "pipeline rate clips/*.mp4 --json",
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
@click.option("--nominal-rpm", type=Finite(min=0, min_open=True, max=FASTEST_RPM),
              help="Expected rate: a check, and the selection if several rates fit.")
@click.option("--json", "as_json", is_flag=True,
              help="Print the section rate.NAME of results.json; NAME is the clip without suffix.")
def command(
    videos: tuple[Path, ...],
    camera: int | None,
    seconds: float,
    keep: Path | None,
    fps: float | None,
    nominal_rpm: float | None,
    as_json: bool,
) -> None:
    """Measure the rate of the plate in each VIDEO, or in a clip that a camera films now.

    The command writes no file except the clip of --keep. If the rate of the plate is not constant,
    it prints the rate against time instead of one value.
    """
    if (camera is None) == (not videos):
        raise click.UsageError("type one or more clips, or a camera (--camera 0), but not both.")
    if keep is not None and (camera is None or keep.suffix != ".mkv"):
        raise click.UsageError("--keep FILE.mkv needs --camera: it keeps the clip of the camera.")
    with _filmed(camera, seconds, keep) as clip:
        _measure(videos if clip is None else (clip,), fps, nominal_rpm, as_json)


@contextmanager
def _filmed(camera: int | None, seconds: float, keep: Path | None) -> Iterator[Path | None]:
    """The clip of the camera, deleted at the end unless it is to be kept; None without one."""
    if camera is None:
        yield None
        return
    from pipeline.commands.progress import ClipProgress
    from pipeline.stages.live_clip import film_clip

    with tempfile.TemporaryDirectory(prefix="pipeline-") as folder:
        clip = keep or Path(folder) / f"camera_{camera}.mkv"
        with ClipProgress() as progress:
            film_clip(camera, seconds, clip, progress)
        yield clip


def _measure(
    videos: tuple[Path, ...], fps: float | None, nominal_rpm: float | None, as_json: bool
) -> None:
    import json

    from pipeline.commands.progress import ClipProgress
    from pipeline.console.rate_text import clip_lines, history_lines, rate_line
    from pipeline.results.rate import history_json, rate_json
    from pipeline.stages.context import RunContext
    from pipeline.stages.rate import follow_clips, measure_setting
    from vision.errors import RateRefused
    from vision.rate.timebase import CLOCK_PPM, Timebase

    stems = [video.stem for video in videos]
    if len(set(stems)) < len(stems):
        twice = next(stem for i, stem in enumerate(stems) if stem in stems[:i])
        raise click.UsageError(
            f"two clips have the name '{twice}', which is the key of the results. Rename one, or "
            f"measure them in two commands."
        )
    source: Literal["container", "constant"] = "container" if fps is None else "constant"
    clock = Timebase(source=source, fps=fps, ppm=CLOCK_PPM[source])
    with ClipProgress() as progress:
        tracks = follow_clips([(video, None) for video in videos], RunContext(None, progress))
    rates = []
    for stem, track in zip(stems, tracks, strict=True):
        try:
            rates.append(measure_setting(stem, [track], clock, nominal_rpm))
        except RateRefused as refused:
            if refused.history is not None and as_json:
                by_stem = {stem: history_json(refused.history, str(refused))}
                click.echo(json.dumps(by_stem, indent=1, ensure_ascii=False, allow_nan=False))
            elif refused.history is not None:
                for line in history_lines(stem, refused.history):
                    click.echo(line)
            raise
    for rate in rates:
        for warning in rate.warnings:
            click.secho(f"warning: {warning}", fg="yellow", err=True)
    if as_json:
        by_name = {rate.name: rate_json(rate) for rate in rates}
        click.echo(json.dumps(by_name, indent=1, ensure_ascii=False, allow_nan=False))
        return
    for rate in rates:
        click.echo(rate_line(rate))
        for line in clip_lines(rate):
            click.echo(line)
