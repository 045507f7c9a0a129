"""``pipeline rate VIDEO...``."""

from pathlib import Path
from typing import Literal

import click


@click.command()
@click.argument("videos", metavar="VIDEO...", nargs=-1, required=True,
                type=click.Path(path_type=Path))
@click.option("--fps", type=click.FloatRange(min=0, min_open=True),
              help="Frame rate when filmed, where the file's time stamps are wrong.")
@click.option("--nominal-rpm", type=click.FloatRange(min=0, min_open=True),
              help="What the plate should do: a check, and the choice among aliases.")
@click.option("--json", "as_json", is_flag=True,
              help="Print rate.NAME of results.json for each clip, by the stem of its file.")
def command(
    videos: tuple[Path, ...], fps: float | None, nominal_rpm: float | None, as_json: bool
) -> None:
    """Measure the plate's rate in each VIDEO. Nothing is written."""
    import json

    from pipeline.commands.progress import ClipProgress
    from pipeline.rate_json import rate_json
    from pipeline.rate_lines import clip_lines, rate_line
    from pipeline.rates import CLOCK_PPM, follow_clips, measure_setting
    from pipeline.workplace import Workplace
    from vision.timebase import Timebase

    stems = [video.stem for video in videos]
    if len(set(stems)) < len(stems):
        twice = next(stem for i, stem in enumerate(stems) if stem in stems[:i])
        raise click.UsageError(
            f"two clips are called '{twice}', and results go by that name. Rename one, or measure "
            f"them one after the other."
        )
    source: Literal["container", "constant"] = "container" if fps is None else "constant"
    clock = Timebase(source=source, fps=fps, ppm=CLOCK_PPM[source])
    with ClipProgress() as progress:
        tracks = follow_clips([(video, None) for video in videos], Workplace(None, progress))
    rates = [
        measure_setting(stem, [track], clock, nominal_rpm)
        for stem, track in zip(stems, tracks, strict=True)
    ]
    for rate in rates:
        for warning in rate.warnings:
            click.secho(f"warning: {warning}", fg="yellow", err=True)
    if as_json:
        found = {rate.name: rate_json(rate) for rate in rates}
        click.echo(json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False))
        return
    for rate in rates:
        click.echo(rate_line(rate))
        for line in clip_lines(rate):
            click.echo(line)
