"""A configuration as text: one line per section; and the same for programs."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from calib.poses.imu_log import TRIADS
from pipeline.config.load import Config
from pipeline.config.schema import RunSection, TriadFitSection, VideoRateSection
from pipeline.stages.rehearsal import Rehearsal
from pipeline.text.formatting import count
from pipeline.text.names import command, short_name

LISTED = 4  #: files that a line names; layout


def config_lines(config: Config, poses: Mapping[RunSection, int]) -> Iterator[str]:
    """One line per section of the file, with the number of ``poses`` of each setting.

    The last line is the next command.
    """
    path, title = config.source.path, config.title
    yield f"{path}: no error{f' in {title!r}' if title else ''}"
    yield f"sensor         {config.sensor.name}"
    for name, rate in config.rate.items():
        if isinstance(rate, VideoRateSection):
            timebase = rate.timebase
            source = f"clock of {timebase.camera}" if timebase.camera else f"{timebase.source} time"
            clock = f"{source}, {timebase.relative_sd * 1e6:.4g} ppm"
            yield f"rate           {name}: {count(len(rate.video), 'clip')}, {clock}"
        else:
            value = f"{rate.rate_rad_s:g} ± {rate.sd_rad_s:g} rad/s"
            yield f"rate           {name}: {value}, stated in the configuration"
    for triad, section in config.triads.items():
        for run in section.at_rest:
            yield f"{triad:<14} {_poses(run, poses)}"
        for run in section.turning:
            yield f"{triad:<14} {_poses(run, poses)} at rate {run.rate}"
        yield f"{triad:<14} model {', '.join(section.model)}"
    yield f"results        {config.output_folder}"
    yield f"next: {command('run', path)}"


def config_json(config: Config, rehearsal: Rehearsal) -> dict[str, Any]:
    """The same for programs; ``problems`` is empty, as the configuration is right."""
    return {
        "config": str(config.source.path),
        "title": config.title,
        "exit_code": 0,
        "problems": [],
        "warnings": list(rehearsal.warnings),
        "sensor": config.sensor.name,
        "rate": {name: {"clips": [str(path) for path in rate.video]}
                 if isinstance(rate, VideoRateSection) else
                 {"rate_rad_s": rate.rate_rad_s, "sd_rad_s": rate.sd_rad_s}
                 for name, rate in config.rate.items()},
        **{triad: _triad_json(config.triads.get(triad))
           for triad in dict.fromkeys((*TRIADS, *config.triads))},
        "results": str(config.output_folder),
    }


def _triad_json(section: TriadFitSection | None) -> dict[str, Any] | None:
    return None if section is None else {
        "model": section.model,
        **(_logs(section.at_rest[0]) if section.at_rest else {}),
        "runs": [{"rate": run.rate, **_logs(run)} for run in section.turning]}


def _logs(section: RunSection) -> dict[str, Any]:
    paths = [str(path) for files in section.poses.files_by_key().values() for path in files]
    return {"files": paths, "exclude": list(section.exclude)}


def _poses(section: RunSection, counts: Mapping[RunSection, int]) -> str:
    poses, excluded = section.poses, section.exclude
    number = counts.get(section.recorded)
    beside = f", {count(number, 'pose')}" if number is not None else ""
    without = f", without {', '.join(map(str, excluded))}" if excluded else ""
    if poses.log:
        return f"static intervals in {_listed(poses.log)}{beside}{without}"
    if poses.means:
        return f"rows of {_listed(poses.means)}{beside}{without}"
    return f"{count(len(poses.files) - len(excluded), 'pose')}{without}"


def _listed(paths: Sequence[Path]) -> str:
    """The names of files, with their folder or archive if names alone are the same; the first and
    the last of many."""
    names = [short_name(path, paths) for path in paths]
    return ", ".join(names) if len(names) <= LISTED else (
        f"{len(names)} files, {names[0]} to {names[-1]}")
