"""The files that ``pipeline rate`` writes, and its output on wow and flutter."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from pipeline.commands.interaction.output import echo_json

if TYPE_CHECKING:
    from calib.poses.imu_log import ImuLog
    from pipeline.stages.flutter import MeasuredFlutter
    from pipeline.stages.rate import SettingRate


@dataclass(frozen=True)
class RateOutputs:
    """The files to write."""

    overlay: Path | None
    csv: Path | None
    page: Path | None

    def require_free(self, videos: tuple[Path, ...], force: bool) -> None:
        """Refuse files that cannot be written, before the work."""
        for option, path, suffix in (("--overlay", self.overlay, ".mp4"),
                                     ("--csv", self.csv, ".csv"), ("--page", self.page, ".html")):
            if path is None:
                continue
            if path.suffix != suffix or (len(videos) > 1 and suffix != ".html"):
                raise click.UsageError(f"{option} OUT{suffix} needs one clip, and writes an "
                                       f"{suffix}.")
            if any(path.exists() and video.exists() and path.samefile(video) for video in videos):
                raise click.UsageError(f"{option} {path} is the clip itself; choose another name.")
            if path.exists() and not force:
                raise click.UsageError(f"{path} exists; choose another name, or replace it "
                                       f"(--force).")

    @property
    def written(self) -> tuple[Path, ...]:
        """The written outputs, in order."""
        return tuple(path for path in (self.overlay, self.csv, self.page) if path is not None)


def measured_flutter(
    rates: "list[SettingRate]", log: "ImuLog | None", outputs: RateOutputs
) -> "list[MeasuredFlutter]":
    """Wow and flutter of the clips and of a gyroscope's log; their page is written.

    Raises
    ------
    UnreadableInput, UnwritableOutput, RateRefused
        The log does not belong to the clip, is too short, or the page cannot be written.
    """
    from pipeline.stages.flutter import flutter_of_clip, flutter_of_gyroscope

    measured = [flutter_of_clip(rate.sources[0], rate.clips[0]) for rate in rates]
    if log is not None:
        measured.append(flutter_of_gyroscope(log, rates[0].clips[0] if rates else None))
    if outputs.page is not None:
        from pipeline.files import write_whole
        from pipeline.report.plate.speed_charts import speed_page

        write_whole(outputs.page, speed_page(measured[0].source, measured))
    return measured


def show_rates(
    rates: "list[SettingRate]", flutter: "list[MeasuredFlutter]", outputs: RateOutputs,
    shown: Literal["text", "quiet", "json"],
) -> None:
    """Print the rates, with their clips or with wow and flutter, and the names of the files."""
    from pipeline.console.rate_text import clip_lines, flutter_json, flutter_lines, rate_line

    if shown == "json":
        from pipeline.results.rate import rate_section

        sources = {"flutter": [flutter_json(source) for source in flutter]} if flutter else {}
        echo_json({rate.name: rate_section(rate).as_json() for rate in rates} | sources)
        return
    for rate in rates:
        click.echo(rate_line(rate))
        for line in clip_lines(rate) if shown == "text" and not flutter else ():
            click.echo(line)
    for source in flutter:
        click.echo("\n".join(flutter_lines(source)))
    for path in outputs.written:
        click.echo(path)
