"""A configuration as text: one line per section."""

from collections.abc import Iterator

from pipeline.config.load import Config
from pipeline.config.schema import PosesSection, VideoRateSection


def summary_lines(config: Config) -> Iterator[str]:
    """One line per section of the file; the last line is the next command."""
    path, title = config.source.path, config.title
    yield f"{path}: no error{f' in {title!r}' if title else ''}"
    yield f"sensor         {config.sensor.name}"
    for name, rate in config.rate.items():
        if isinstance(rate, VideoRateSection):
            clock = f"{rate.timebase.source} time, {rate.timebase.relative_sd * 1e6:g} ppm"
            yield f"rate           {name}: {_count(len(rate.video), 'clip')}, {clock}"
        else:
            value = f"{rate.rate_rad_s:g} ± {rate.sd_rad_s:g} rad/s"
            yield f"rate           {name}: {value}, stated in the configuration"
    if config.accelerometer:
        section = config.accelerometer
        yield f"accelerometer  {_poses(section.poses)}; model {', '.join(section.model)}"
    if config.gyroscope:
        for run in config.gyroscope.runs:
            yield f"gyroscope      {_poses(run.poses)} at rate {run.rate}"
        yield f"gyroscope      model {', '.join(config.gyroscope.model)}"
    yield f"results        {config.output_folder}"
    yield f"next: pipeline run {path}"


def _poses(poses: PosesSection) -> str:
    if poses.log:
        return f"static intervals in {', '.join(path.name for path in poses.log)}"
    return _count(len(poses.files), "pose")


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}{'' if n == 1 else 's'}"
